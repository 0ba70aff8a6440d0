"use strict";
// The picture in space: solids, the marks of forces and contacts, and the stage they stand on.

const SHADES = {
  steel: [196, 204, 212], dark: [92, 102, 112], brass: [214, 176, 92], blue: [40, 128, 206], orange: [230, 118, 30],
  green: [28, 158, 116], red: [214, 64, 62], glass: [170, 196, 216],
};
const SCALE = [[28, 16, 68], [94, 23, 110], [159, 42, 99], [212, 72, 66], [245, 125, 21], [250, 193, 39], [252, 255, 164]];

THREE.ColorManagement.enabled = false;

// Red, green, blue from 0 to 1 of a share from 0 to 1.
function scaleColour(share) {
  const position = Math.min(Math.max(share || 0.0, 0.0), 1.0) * (SCALE.length - 1);
  const low = Math.min(Math.floor(position), SCALE.length - 2), fraction = position - low;
  return SCALE[low].map((channel, k) => (channel + fraction * (SCALE[low + 1][k] - channel)) / 255.0);
}

const scaleText = (share) => `rgb(${scaleColour(share).map((channel) => Math.round(255 * channel)).join(",")})`;
const scaleGradient = () => `linear-gradient(to right, ${SCALE.map((_, k) => scaleText(k / (SCALE.length - 1))).join(",")})`;

const shadeTextures = new Map();

// Texture of a ball of this shade in the ambient light, a texture by the direction of the surface.
function shadeTexture(name) {
  if (shadeTextures.has(name)) return shadeTextures.get(name);
  const size = 128, base = SHADES[name] || SHADES.steel, metal = name === "steel" || name === "brass" || name === "dark";
  const canvas = make("canvas", { width: size, height: size });
  const context = canvas.getContext("2d"), image = context.createImageData(size, size);
  for (let row = 0; row < size; row++) {
    for (let column = 0; column < size; column++) {
      let x = (2.0 * column + 1.0) / size - 1.0, y = 1.0 - (2.0 * row + 1.0) / size;
      const distance = Math.hypot(x, y);
      if (distance > 0.99) [x, y] = [(x / distance) * 0.99, (y / distance) * 0.99];
      const z = Math.sqrt(1.0 - x * x - y * y);
      const light = Math.max(0.0, -0.42 * x + 0.62 * y + 0.66 * z), bounce = Math.max(0.0, 0.5 * x - 0.6 * y + 0.3 * z);
      const gleam = Math.max(0.0, -0.26 * x + 0.38 * y + 0.89 * z) ** (metal ? 38 : 22);
      const horizon = metal ? 0.16 * Math.exp(-(((y + 0.18 + 0.15 * x) / 0.17) ** 2)) : 0.0;
      const shade = 0.3 + 0.66 * light + 0.14 * bounce - horizon;
      const offset = 4 * (row * size + column);
      for (let k = 0; k < 3; k++) image.data[offset + k] = Math.min(255, base[k] * shade + 150 * gleam);
      image.data[offset + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = "";
  texture.generateMipmaps = false;
  texture.minFilter = THREE.LinearFilter;
  shadeTextures.set(name, texture);
  return texture;
}

function shaded(name, more = {}) {
  return new THREE.MeshMatcapMaterial({ matcap: shadeTexture(name), ...more });
}

// Solids: their shapes as triangles, and the bodies of a scene where each output has them.

// Sides enough that a rim 300 pixels from its middle deviates by less than half of one: without a graphics processor
// corners cost more than pixels.
const SIDES = 64; // sides of a full turn
const DARK_PARTS = 3, DARK_WIDTH = 6; // dark parts of the rim of a turned body that is marked; how wide, in sides by DARK_PARTS

const SHAPES = {
  ellipsoid(axes, solid) {
    const fine = solid.count > 60 ? 8 : solid.count > 4 ? 12 : 32;
    const geometry = new THREE.SphereGeometry(1.0, 2 * fine, fine);
    return geometry.scale(axes[0], axes[1], axes[2]);
  },
  turned(turned, solid, factor) {
    return turnedGeometry(turned.strokes, (turned.grow || 0.0) * factor, solid.marked);
  },
  extruded({ outlines, low, high }) {
    const parts = outlines.map((outline) => {
      const shape = new THREE.Shape(outline.map(([x, y]) => new THREE.Vector2(x, y)));
      return new THREE.ExtrudeGeometry(shape, { depth: high - low, bevelEnabled: false }).translate(0, 0, low);
    });
    return THREE.mergeGeometries(parts);
  },
  cylinder({ radius, length }) {
    return new THREE.CylinderGeometry(radius, radius, length, SIDES).rotateX(0.5 * Math.PI);
  },
  // A plate whose upper face is y = 0.
  slab({ width, height }) {
    return new THREE.BoxGeometry(width, height, 0.25 * width).translate(0.0, -0.5 * height, 0.0);
  },
  // The plane z = 0 under all that is seen.
  ground(_, solid, factor, region) {
    return new THREE.CircleGeometry(2.2 * region.radius, SIDES).translate(region.middle[0], region.middle[1], 0.0);
  },
  mesh({ vertices, normals, triangles }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(vertices.flat(), 3));
    geometry.setAttribute("normal", new THREE.Float32BufferAttribute(normals.flat(), 3));
    return geometry.setIndex(triangles.flat());
  },
};

function shapeGeometry(solid, factor, region) {
  const [[kind, numbers]] = Object.entries(solid.shape);
  return SHAPES[kind](numbers, solid, factor, region);
}

// Strokes of (radius, z) turned about z, in the same sense around the section; a stroke is smooth, its ends are edges.
// Radii grow by `grow`.
function turnedGeometry(strokes, grow, marked) {
  const outlines = strokes.map((stroke) => stroke.map(([radius, z]) => new THREE.Vector2(radius + grow, z)));
  const isBackward = THREE.ShapeUtils.isClockWise(outlines.flat());
  const parts = outlines.map((outline) => {
    const geometry = new THREE.LatheGeometry(isBackward ? outline.reverse() : outline, SIDES, 0.5 * Math.PI).rotateX(0.5 * Math.PI);
    const colours = Array.from({ length: SIDES + 1 }, (_, side) => {
      const dark = marked && (side * DARK_PARTS) % SIDES < DARK_WIDTH;
      return outline.map(() => (dark ? [0.16, 0.42, 0.72] : [1.0, 1.0, 1.0]));
    });
    return geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours.flat(2), 3));
  });
  return THREE.mergeGeometries(parts);
}

// Two belts round an ellipsoid, by which its turning is seen.
function beltGeometry(axes) {
  const half = 0.13, belt = () => new THREE.SphereGeometry(1.008, 32, 2, 0.0, 2.0 * Math.PI, 0.5 * Math.PI - half, 2.0 * half);
  return THREE.mergeGeometries([belt(), belt().rotateX(0.5 * Math.PI)]).scale(axes[0], axes[1], axes[2]);
}

// An arrow of length 1 along +y, as thick as one of that length is.
function arrowGeometry() {
  const shaft = new THREE.CylinderGeometry(0.05, 0.05, 0.66, 8, 1, true).translate(0.0, 0.33, 0.0);
  const head = new THREE.ConeGeometry(0.14, 0.36, 12).translate(0.0, 0.82, 0.0);
  return THREE.mergeGeometries([shaft, head]);
}

const rotationOf = new THREE.Quaternion(), tiltOf = new THREE.Quaternion(), nextRotation = new THREE.Quaternion();
const vectorOf = new THREE.Vector3(), ones = new THREE.Vector3(1.0, 1.0, 1.0), matrixOf = new THREE.Matrix4();

class Bodies {
  constructor(solid, store, palette, region) {
    Object.assign(this, { solid, store, region, group: new THREE.Group(), positions: [], rotations: [] });
    this.manyColours = typeof solid.colour !== "string";
    for (let k = 0; k < solid.count; k++) {
      this.positions.push(new THREE.Vector3());
      this.rotations.push(new THREE.Quaternion());
    }
    this.build(1.0, palette);
  }

  build(factor, palette) {
    this.group.children.forEach((mesh) => mesh.geometry.dispose());
    this.group.clear();
    const { solid } = this, turned = "turned" in solid.shape;
    const options = { vertexColors: turned, opacity: solid.opacity, transparent: solid.opacity < 1.0 };
    const shade = this.manyColours ? "steel" : solid.colour;
    this.body = this.mesh(shapeGeometry(solid, factor, this.region), shaded(shade, options));
    if (solid.opacity < 1.0) this.body.renderOrder = 2;
    if (solid.marked && "ellipsoid" in solid.shape) {
      const belts = this.mesh(beltGeometry(solid.shape.ellipsoid), shaded(this.manyColours ? "glass" : "blue"));
      if (this.manyColours) {
        for (let k = 0; k < solid.count; k++) belts.setColorAt(k, new THREE.Color(curveColour(k, palette)));
      }
    }
    this.palette = palette;
  }

  mesh(geometry, material) {
    const mesh = new THREE.InstancedMesh(geometry, material, this.solid.count);
    mesh.frustumCulled = false;
    mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    this.group.add(mesh);
    return mesh;
  }

  enlarge(factor) {
    const { turned } = this.solid.shape;
    if (turned && turned.grow) this.build(factor, this.palette);
  }

  update(index, factor) {
    for (let k = 0; k < this.solid.count; k++) {
      this.placeBody(k, index, factor);
      matrixOf.compose(this.positions[k], this.rotations[k], ones);
      for (const mesh of this.group.children) mesh.setMatrixAt(k, matrixOf);
    }
    for (const mesh of this.group.children) mesh.instanceMatrix.needsUpdate = true;
  }

  placeBody(k, index, factor) {
    const { solid, store } = this, position = this.positions[k].set(0.0, 0.0, 0.0), rotation = this.rotations[k].identity();
    const row = solid.place + k;
    if (solid.position) addVector(position, store, solid.position, index, 3 * row, 1.0);
    if (solid.deviation) addVector(position, store, solid.deviation, index, 3 * row, factor);
    if (solid.orientation) {
      quaternionAt(rotation, store, solid.orientation, Math.floor(index), 4 * row);
      quaternionAt(nextRotation, store, solid.orientation, Math.min(Math.floor(index) + 1, store.count - 1), 4 * row);
      rotation.slerp(nextRotation, index - Math.floor(index));
    } else if (solid.turn) {
      const angle = Math.atan2(store.between(solid.turn, index, 1), store.between(solid.turn, index, 0));
      rotation.set(0.0, 0.0, Math.sin(0.5 * angle), Math.cos(0.5 * angle));
    }
    if (solid.tilt) {
      vectorOf.set(factor * store.between(solid.tilt, index, 0), factor * store.between(solid.tilt, index, 1), 0.0);
      const angle = vectorOf.length();
      if (angle > 0.0) rotation.premultiply(tiltOf.setFromAxisAngle(vectorOf.divideScalar(angle), angle));
    }
  }
}

function addVector(vector, store, name, index, column, factor) {
  vector.x += factor * store.between(name, index, column);
  vector.y += factor * store.between(name, index, column + 1);
  vector.z += factor * store.between(name, index, column + 2);
}

function quaternionAt(quaternion, store, name, frame, column) {
  quaternion.set(
    store.value(name, frame, column), store.value(name, frame, column + 1), store.value(name, frame, column + 2),
    store.value(name, frame, column + 3),
  ).normalize();
}

// Marks of forces and contacts: arrows, ellipses, surfaces coloured by a number, bent bars, paths of points.

const up = new THREE.Vector3(0.0, 1.0, 0.0), hidden = new THREE.Matrix4().makeScale(0, 0, 0);
const normalOf = new THREE.Vector3(), majorOf = new THREE.Vector3(), minorOf = new THREE.Vector3(), sizeOf = new THREE.Vector3();

const NEVER_DRAWN = "none at any output"; // forces and contacts between outputs are not drawn

// Number of rows of `length` numbers in a series.
const rowsOf = (store, name, length) => store.get(name).width / length;

// Where a mark stands: on the surface of a body against `normal`, at a point, or in the origin.
function markPosition(mark, stage, store, index, row, rows) {
  vectorOf.set(0.0, 0.0, 0.0);
  if (mark.on) {
    const bodies = stage.bodies(mark.on), body = Math.floor((row * bodies.solid.count) / rows);
    vectorOf.copy(bodies.positions[body]);
    if (mark.radius) vectorOf.addScaledVector(normalOf, -mark.radius);
  } else if (mark.point) {
    addVector(vectorOf, store, mark.point, Math.floor(index), 3 * row, 1.0);
  }
  return vectorOf;
}

// Base of marks: their description, the numbers they show, and a group in the scene.
class Mark {
  constructor(mark, store) {
    Object.assign(this, { mark, store, group: new THREE.Group() });
    this.build(mark, store);
    this.measure();
  }

  add(...parts) {
    for (const part of parts) part.frustumCulled = false;
    this.group.add(...parts);
  }

  // The vector of a row at an index among the outputs, of length 1, in `normalOf`; its length before, 0 for none.
  aim(name, index, row) {
    addVector(normalOf.set(0.0, 0.0, 0.0), this.store, name, index, 3 * row, 1.0);
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
    this.greatest = mark.size ? store.greatest(mark.size) : store.greatest(mark.vector, 3);
  }

  update(index, factor, stage) {
    const { mark, store, rows } = this, frame = Math.floor(index);
    this.meshes.forEach((mesh, kind) => {
      for (let row = 0; row < rows; row++) {
        const strength = this.aim(mark.vector, index, row);
        const size = (mark.size ? store.value(mark.size, frame, row) : strength) / this.greatest;
        if (!(size > 2e-3) || row % this.meshes.length !== kind || !strength) {
          mesh.setMatrixAt(row, hidden);
          continue;
        }
        const length = mark.longest * size, position = markPosition(mark, stage, store, index, row, rows);
        if (!mark.from_point) position.addScaledVector(normalOf, -length);
        const thick = mark.longest * (0.35 + 0.65 * Math.min(size, 1.0));
        mesh.setMatrixAt(row, matrixOf.compose(position, rotationOf.setFromUnitVectors(up, normalOf), sizeOf.set(thick, length, thick)));
      }
      mesh.instanceMatrix.needsUpdate = true;
    });
  }

  legend() {
    const { mark, greatest } = this;
    return [{ swatches: mark.colours, words: mark.words, scale: greatest ? `longest ${withUnit(greatest, mark)}` : NEVER_DRAWN }];
  }
}

class EllipseMarks extends Mark {
  build(mark, store) {
    this.rows = rowsOf(store, mark.normal, 3);
    const material = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, depthTest: false, transparent: true, opacity: 0.92 });
    this.mesh = new THREE.InstancedMesh(new THREE.CircleGeometry(1.0, 28), material, this.rows);
    this.mesh.renderOrder = 5;
    this.add(this.mesh);
  }

  measure() {
    const { mark, store } = this;
    this.greatest = store.greatest(mark.pressure);
    this.factor = roundDown(mark.reach / store.greatest(mark.semi_major));
  }

  update(index, factor, stage) {
    const { mark, store, rows, mesh } = this, frame = Math.floor(index), colour = new THREE.Color();
    for (let row = 0; row < rows; row++) {
      const major = store.value(mark.semi_major, frame, row);
      if (!this.aim(mark.normal, index, row) || !(major > 0.0)) {
        mesh.setMatrixAt(row, hidden);
        continue;
      }
      majorOf.set(...mark.along);
      if (mark.major_axis) addVector(majorOf.set(0.0, 0.0, 0.0), store, mark.major_axis, frame, 3 * row, 1.0);
      majorOf.addScaledVector(normalOf, -majorOf.dot(normalOf));
      if (majorOf.length() < 1e-9) majorOf.set(normalOf.y, -normalOf.x, 0.0);
      majorOf.normalize();
      minorOf.crossVectors(normalOf, majorOf);
      const position = markPosition(mark, stage, store, index, row, rows);
      majorOf.multiplyScalar(this.factor * major);
      minorOf.multiplyScalar(this.factor * store.value(mark.semi_minor, frame, row));
      mesh.setMatrixAt(row, matrixOf.makeBasis(majorOf, minorOf, normalOf).setPosition(position));
      mesh.setColorAt(row, colour.setRGB(...scaleColour(store.value(mark.pressure, frame, row) / this.greatest)));
    }
    mesh.instanceMatrix.needsUpdate = true;
    if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
  }

  legend() {
    const words = `${this.mark.words}, by pressure`;
    if (!this.greatest) return [{ words, scale: NEVER_DRAWN }];
    return [{ scaleTo: withUnit(this.greatest, this.store.get(this.mark.pressure)), words, scale: `×${this.factor}` }];
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

  update(index) {
    const { mark, store } = this, frame = Math.round(index), { values, width } = store.get(mark.nodes);
    for (const { signs, geometry } of this.copies) {
      const position = geometry.getAttribute("position"), colour = geometry.getAttribute("color"), shade = new THREE.Color();
      for (let k = 0; k < width / 2; k++) {
        position.setXYZ(k, signs[0] * values[frame * width + 2 * k], signs[1] * values[frame * width + 2 * k + 1], 0.0);
        // the root shows the many small energies beside the few great ones; the legend says so
        const share = Math.sqrt(store.value(mark.values, frame, k) / this.greatest);
        shade.setRGB(...scaleColour(share));
        colour.setXYZ(k, shade.r, shade.g, shade.b);
      }
      position.needsUpdate = colour.needsUpdate = true;
    }
  }

  legend() {
    const { mark } = this;
    if (mark.values !== mark.scale[0]) return [];
    return [{ scaleTo: withUnit(this.greatest, this.store.get(mark.values)), words: mark.words, scale: "root scale" }];
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

  update(index, factor) {
    const { mark, store, rest } = this, position = this.mesh.geometry.getAttribute("position");
    const last = store.get(mark.deflection).width - 1;
    for (let k = 0; k < position.count; k++) {
      const station = Math.round((rest[3 * k] / mark.length + 0.5) * last);
      position.setY(k, rest[3 * k + 1] - 0.5 * mark.height - factor * store.between(mark.deflection, index, station));
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

const MARK_VIEWS = { arrows: ArrowMarks, contactellipses: EllipseMarks, movingmesh: MovingMeshMarks, bar: BarMarks, trail: TrailMarks };

// The picture in space: camera, bodies and marks, the selected body, and the texts that give the scales.

const MOST_NUMBERS = 40; // bodies with a number: more would cover each other
const CLICK_RADIUS = 4; // pixels that a click may move
const COARSE_RATIO = 0.5; // pixels of a picture that moves against those of one that stands, along an edge, where they are slow

// The renderer of pictures in space: null where this browser draws none; `slow` where no graphics processor does, so that
// smooth edges and fine pixels would cost most of the frames.
function graphics() {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return null;
  const facts = context.getExtension("WEBGL_debug_renderer_info");
  const name = facts ? String(context.getParameter(facts.UNMASKED_RENDERER_WEBGL)) : "";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return { slow: /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name) };
}

// The visible part, wide enough for all points of the series that are to be seen.
function visibleRegion(region, store) {
  if (!region.around.length || !store.count) return region;
  const box = new THREE.Box3();
  for (const name of region.around) box.union(new THREE.Box3().setFromArray(store.get(name).values));
  const radius = region.radius + 0.5 * box.getSize(new THREE.Vector3()).length();
  return { ...region, radius, middle: box.getCenter(new THREE.Vector3()).toArray() };
}

class Stage {
  constructor(parent, view, store, slow, onSelect) {
    Object.assign(this, { parent, view, store, index: 0.0, selected: -1, slow, onSelect });
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.slow });
    this.renderer.outputColorSpace = "srgb-linear"; // colours are drawn as they are written
    this.sharpen(false);
    parent.prepend(this.renderer.domElement);
    const region = (this.region = visibleRegion(view.look, store));
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();
    this.scale = 1.0 / region.radius;
    this.world.scale.setScalar(this.scale);
    this.world.position.set(...region.middle).multiplyScalar(-this.scale);
    this.scene.add(this.world);
    this.camera = new THREE.PerspectiveCamera(30.0, 1.0, 0.05, 200.0);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.requestRender());
    this.camera.up.set(...view.look.up);
    this.solids = view.solids.map((description) => new Bodies(description, store, view.palette, region));
    this.marks = view.marks.map((description) => new MARK_VIEWS[description.item](description, store));
    [...this.solids, ...this.marks].forEach((item) => this.world.add(item.group));
    if (view.axes) this.world.add(this.axes());
    this.numbers();
    this.halo = this.addHalo();
    this.enlarge(this.automaticFactor());
    this.listen();
    this.resize();
    this.home();
  }

  // Fewer pixels while a picture moves that no graphics processor draws.
  sharpen(moving) {
    const fine = Math.min(window.devicePixelRatio || 1.0, 2.0);
    this.renderer.setPixelRatio(this.slow ? (moving ? COARSE_RATIO : 1.0) : fine);
    if (this.scene) this.requestRender();
  }

  bodies(name) {
    return this.solids.find((bodies) => bodies.solid.name === name);
  }

  // The enlargement at which the greatest displacement is drawn as long as the view wants it.
  automaticFactor() {
    const { enlarged } = this.view;
    if (!enlarged) return 1.0;
    const sizes = enlarged.series.map((name) => this.store.greatest(name, this.store.get(name).shape.at(-1) === 3 ? 3 : 1));
    return roundDown(enlarged.reach / Math.max(enlarged.least, ...sizes));
  }

  enlarge(factor) {
    this.factor = factor;
    this.solids.forEach((bodies) => bodies.enlarge(factor));
    this.show(this.index);
  }

  home() {
    const direction = new THREE.Vector3(...this.view.look.direction).normalize();
    const wide = this.camera.aspect < 1.0 ? 1.0 / this.camera.aspect : 1.0;
    this.camera.position.copy(direction).multiplyScalar(4.3 * wide);
    this.controls.target.set(0.0, 0.0, 0.0);
    this.controls.update();
    this.requestRender();
  }

  // Directions of the axes in the middle, as long as there is room in a bore.
  axes() {
    const group = new THREE.Group(), length = 0.15 * this.region.radius;
    for (const [name, direction] of [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]]) {
      const geometry = new THREE.BufferGeometry();
      const end = direction.map((component) => component * length);
      geometry.setAttribute("position", new THREE.Float32BufferAttribute([0, 0, 0, ...end], 3));
      group.add(new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: 0x8a97a3 })));
      this.label("axis", name, new THREE.Vector3(...end).multiplyScalar(1.25));
    }
    return group;
  }

  // A word that goes with a place in the world, which may move.
  label(className, text, position) {
    const label = make("span", { class: className }, text);
    this.parent.append(label);
    (this.labels ||= []).push([label, position]);
  }

  // The numbers of bodies that curves and tables name.
  numbers() {
    const { details } = this.view, positions = details ? this.bodies(details.solid).positions : [];
    if (positions.length > 1 && positions.length <= MOST_NUMBERS) positions.forEach((position, k) => this.label("axis number", k, position));
  }

  addHalo() {
    const { details } = this.view;
    if (!details) return null;
    const { shape } = this.bodies(details.solid).solid, axes = shape.ellipsoid || [0, 0, 0];
    const material = new THREE.MeshBasicMaterial({ color: 0x2f9bff, side: 1 }); // the side turned away: a rim is seen
    const halo = new THREE.Mesh(new THREE.SphereGeometry(1.07 * Math.max(...axes), 32, 16), material);
    halo.visible = false;
    this.world.add(halo);
    return halo;
  }

  listen() {
    const canvas = this.renderer.domElement;
    let down = [0, 0];
    canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) <= CLICK_RADIUS) this.pick(event);
    });
    new ResizeObserver(() => this.resize()).observe(this.parent);
  }

  pick(event) {
    const { details } = this.view;
    if (!details) return;
    const box = this.renderer.domElement.getBoundingClientRect(), caster = new THREE.Raycaster();
    const x = (2.0 * (event.clientX - box.left)) / box.width - 1.0, y = 1.0 - (2.0 * (event.clientY - box.top)) / box.height;
    caster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const { body } = this.bodies(details.solid);
    body.computeBoundingSphere();
    const [hit] = caster.intersectObject(body);
    if (hit) this.onSelect(hit.instanceId);
  }

  select(body) {
    this.selected = body;
    this.show(this.index);
  }

  resize() {
    const width = Math.max(this.parent.clientWidth, 1), height = Math.max(this.parent.clientHeight, 1);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.requestRender();
  }

  // Everything as it is at an index among the outputs.
  show(index) {
    this.index = index;
    if (!this.store.count) return;
    [...this.solids, ...this.marks].forEach((item) => item.update(index, this.factor, this));
    if (this.halo) {
      this.halo.visible = this.selected >= 0;
      if (this.selected >= 0) this.halo.position.copy(this.bodies(this.view.details.solid).positions[this.selected]);
    }
    this.requestRender();
  }

  requestRender() {
    if (this.isRequested) return;
    this.isRequested = true;
    requestAnimationFrame(() => this.render());
  }

  render() {
    this.isRequested = false;
    this.renderer.setClearColor(new THREE.Color(themeColour("stage")), 1.0);
    this.renderer.render(this.scene, this.camera);
    for (const [label, position] of this.labels || []) {
      const projected = position.clone().applyMatrix4(this.world.matrixWorld).project(this.camera);
      label.style.left = `${50.0 * (1.0 + projected.x)}%`;
      label.style.top = `${50.0 * (1.0 - projected.y)}%`;
    }
  }

  measure() {
    this.marks.forEach((mark) => mark.measure());
  }

  legend() {
    return this.marks.flatMap((mark) => mark.legend());
  }
}
