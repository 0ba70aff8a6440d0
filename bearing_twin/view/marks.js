"use strict";
// What stands for forces and contacts: arrows, ellipses, surfaces coloured by a number, bent bars, ways of points.

const up = new THREE.Vector3(0.0, 1.0, 0.0), ahead = new THREE.Vector3(0.0, 0.0, 1.0), hidden = new THREE.Matrix4().makeScale(0, 0, 0);
const normalOf = new THREE.Vector3(), majorOf = new THREE.Vector3(), minorOf = new THREE.Vector3(), sizeOf = new THREE.Vector3();

// How many rows of `length` numbers a series has.
const rowsOf = (store, name, length) => store.get(name).width / length;

// Where a mark stands: on the surface of a body against `normal`, at a point, or in the origin.
function markPlace(mark, stage, store, place, row, rows) {
  placeOf.set(0.0, 0.0, 0.0);
  if (mark.on) {
    const bodies = stage.bodies(mark.on), body = Math.floor((row * bodies.solid.count) / rows);
    placeOf.copy(bodies.places[body]);
    if (mark.radius) placeOf.addScaledVector(normalOf, -mark.radius);
  } else if (mark.point) {
    addVector(placeOf, store, mark.point, Math.floor(place), 3 * row, 1.0);
  }
  return placeOf;
}

// What marks share: their description, the numbers they show, and a group in the scene.
class Mark {
  constructor(mark, store) {
    Object.assign(this, { mark, store, group: new THREE.Group() });
    this.build(mark, store);
    this.measure();
  }

  add(...parts) {
    for (const one of parts) one.frustumCulled = false;
    this.group.add(...parts);
  }

  // The vector of a row at a place among the outputs, of length 1, in `normalOf`; its length before, 0 for none.
  aim(name, place, row) {
    addVector(normalOf.set(0.0, 0.0, 0.0), this.store, name, place, 3 * row, 1.0);
    const length = normalOf.length();
    if (length > 0.0) normalOf.divideScalar(length);
    return length || 0.0;
  }

  measure() {}

  update() {}

  legend() {
    return [];
  }
}

class ArrowMarks extends Mark {
  build(mark, store) {
    this.rows = rowsOf(store, mark.vector, 3);
    this.meshes = mark.colours.map((colour) => new THREE.InstancedMesh(arrowGeometry(), shaded(colour), this.rows));
    this.add(...this.meshes);
  }

  measure() {
    const { mark, store } = this;
    this.greatest = (mark.size ? store.greatest(mark.size) : store.greatest(mark.vector, 3)) || 1.0;
  }

  update(place, factor, stage) {
    const { mark, store, rows } = this, frame = Math.floor(place);
    this.meshes.forEach((mesh, kind) => {
      for (let row = 0; row < rows; row++) {
        const strength = this.aim(mark.vector, place, row);
        const size = (mark.size ? store.at(mark.size, frame, row) : strength) / this.greatest;
        if (!(size > 2e-3) || row % this.meshes.length !== kind || !strength) {
          mesh.setMatrixAt(row, hidden);
          continue;
        }
        const length = mark.longest * size, where = markPlace(mark, stage, store, place, row, rows);
        if (!mark.from_point) where.addScaledVector(normalOf, -length);
        const thick = mark.longest * (0.35 + 0.65 * Math.min(size, 1.0));
        mesh.setMatrixAt(row, matrixOf.compose(where, turnOf.setFromUnitVectors(up, normalOf), sizeOf.set(thick, length, thick)));
      }
      mesh.instanceMatrix.needsUpdate = true;
    });
  }

  legend() {
    const { mark } = this;
    return [{ swatches: mark.colours, words: mark.words, scale: `longest ${withUnit(this.greatest, mark, 3)}` }];
  }
}

class SpotMarks extends Mark {
  build(mark, store) {
    this.rows = rowsOf(store, mark.normal, 3);
    const material = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, depthTest: false, transparent: true, opacity: 0.92 });
    this.mesh = new THREE.InstancedMesh(new THREE.CircleGeometry(1.0, 28), material, this.rows);
    this.mesh.renderOrder = 5;
    this.add(this.mesh);
  }

  measure() {
    const { mark, store } = this;
    this.greatest = store.greatest(mark.pressure) || 1.0;
    this.factor = roundedDown(mark.reach / store.greatest(mark.semi_major));
  }

  update(place, factor, stage) {
    const { mark, store, rows, mesh } = this, frame = Math.floor(place), colour = new THREE.Color();
    for (let row = 0; row < rows; row++) {
      const major = store.at(mark.semi_major, frame, row);
      if (!this.aim(mark.normal, place, row) || !(major > 0.0)) {
        mesh.setMatrixAt(row, hidden);
        continue;
      }
      majorOf.set(...mark.along);
      if (mark.major_axis) addVector(majorOf.set(0.0, 0.0, 0.0), store, mark.major_axis, frame, 3 * row, 1.0);
      majorOf.addScaledVector(normalOf, -majorOf.dot(normalOf));
      if (majorOf.length() < 1e-9) majorOf.set(normalOf.y, -normalOf.x, 0.0);
      majorOf.normalize();
      minorOf.crossVectors(normalOf, majorOf);
      const where = markPlace(mark, stage, store, place, row, rows);
      majorOf.multiplyScalar(this.factor * major);
      minorOf.multiplyScalar(this.factor * store.at(mark.semi_minor, frame, row));
      mesh.setMatrixAt(row, matrixOf.makeBasis(majorOf, minorOf, normalOf).setPosition(where));
      mesh.setColorAt(row, colour.setRGB(...scaleColour(store.at(mark.pressure, frame, row) / this.greatest)));
    }
    mesh.instanceMatrix.needsUpdate = true;
    if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
  }

  legend() {
    const series = this.store.get(this.mark.pressure);
    return [{ scaleTo: withUnit(this.greatest, series, 3), words: `${this.mark.words}, by pressure`, scale: `×${this.factor}` }];
  }
}

class MovingMeshMarks extends Mark {
  build(mark, store) {
    const nodes = store.get(mark.nodes).width / 2;
    this.copies = mark.signs.map((signs) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(new Float32Array(3 * nodes), 3));
      geometry.setAttribute("color", new THREE.Float32BufferAttribute(new Float32Array(3 * nodes), 3));
      geometry.setIndex(mark.triangles.flat());
      const material = new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide });
      const lines = new THREE.BufferGeometry();
      lines.setAttribute("position", geometry.getAttribute("position"));
      lines.setIndex(mark.edges.flat());
      const ink = new THREE.LineBasicMaterial({ color: 0xffffff, transparent: true, opacity: 0.28 });
      this.add(new THREE.Mesh(geometry, material), new THREE.LineSegments(lines, ink));
      return { signs, geometry };
    });
  }

  measure() {
    this.greatest = Math.max(...this.mark.scale.map((name) => this.store.greatest(name))) || 1.0;
  }

  update(place) {
    const { mark, store } = this, frame = Math.round(place), { values, width } = store.get(mark.nodes);
    for (const { signs, geometry } of this.copies) {
      const position = geometry.getAttribute("position"), colour = geometry.getAttribute("color"), shade = new THREE.Color();
      for (let k = 0; k < width / 2; k++) {
        position.setXYZ(k, signs[0] * values[frame * width + 2 * k], signs[1] * values[frame * width + 2 * k + 1], 0.0);
        // the root shows the many small energies beside the few great ones; the legend says so
        const share = Math.sqrt(store.at(mark.values, frame, k) / this.greatest);
        shade.setRGB(...scaleColour(share));
        colour.setXYZ(k, shade.r, shade.g, shade.b);
      }
      position.needsUpdate = colour.needsUpdate = true;
    }
  }

  legend() {
    const { mark } = this;
    if (mark.values !== mark.scale[0]) return [];
    return [{ scaleTo: withUnit(this.greatest, this.store.get(mark.values), 3), words: mark.words, scale: "root scale" }];
  }
}

class BarMarks extends Mark {
  build(mark, store) {
    const stations = store.get(mark.deflection).width;
    const geometry = new THREE.BoxGeometry(mark.length, mark.height, mark.width, stations - 1, 1, 1);
    this.rest = Float32Array.from(geometry.getAttribute("position").array);
    this.mesh = new THREE.Mesh(geometry, shaded(mark.colour));
    this.add(this.mesh);
  }

  update(place, factor) {
    const { mark, store, rest } = this, position = this.mesh.geometry.getAttribute("position");
    const last = store.get(mark.deflection).width - 1;
    for (let k = 0; k < position.count; k++) {
      const station = Math.round((rest[3 * k] / mark.length + 0.5) * last);
      position.setY(k, rest[3 * k + 1] - 0.5 * mark.height - factor * store.between(mark.deflection, place, station));
    }
    position.needsUpdate = true;
    this.mesh.geometry.computeVertexNormals();
  }
}

class TrailMarks extends Mark {
  build(mark) {
    const geometry = new THREE.BufferGeometry();
    this.line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: `rgb(${SHADES[mark.colour].join(",")})` }));
    this.add(this.line);
  }

  measure() {
    const { values } = this.store.get(this.mark.position);
    this.line.geometry.setAttribute("position", new THREE.Float32BufferAttribute(values.slice(0, 3 * this.store.count), 3));
  }

  legend() {
    return [{ swatches: [this.mark.colour], words: this.mark.words, scale: "" }];
  }
}

const MARK_VIEWS = { arrows: ArrowMarks, spots: SpotMarks, movingmesh: MovingMeshMarks, bar: BarMarks, trail: TrailMarks };
