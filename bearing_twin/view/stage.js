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
  const place = Math.min(Math.max(share || 0.0, 0.0), 1.0) * (SCALE.length - 1);
  const low = Math.min(Math.floor(place), SCALE.length - 2), part = place - low;
  return SCALE[low].map((one, k) => (one + part * (SCALE[low + 1][k] - one)) / 255.0);
}

const scaleText = (share) => `rgb(${scaleColour(share).map((one) => Math.round(255 * one)).join(",")})`;
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
      const far = Math.hypot(x, y);
      if (far > 0.99) [x, y] = [(x / far) * 0.99, (y / far) * 0.99];
      const z = Math.sqrt(1.0 - x * x - y * y);
      const light = Math.max(0.0, -0.42 * x + 0.62 * y + 0.66 * z), low = Math.max(0.0, 0.5 * x - 0.6 * y + 0.3 * z);
      const gleam = Math.max(0.0, -0.26 * x + 0.38 * y + 0.89 * z) ** (metal ? 38 : 22);
      const horizon = metal ? 0.16 * Math.exp(-(((y + 0.18 + 0.15 * x) / 0.17) ** 2)) : 0.0;
      const shade = 0.3 + 0.66 * light + 0.14 * low - horizon;
      const place = 4 * (row * size + column);
      for (let k = 0; k < 3; k++) image.data[place + k] = Math.min(255, base[k] * shade + 150 * gleam);
      image.data[place + 3] = 255;
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
const ROUND = 64; // sides of a full turn
const MARKS = 3, DARK = 6; // dark parts of the rim of a turned body that is marked; how wide, in sides by MARKS

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
    return new THREE.CylinderGeometry(radius, radius, length, ROUND).rotateX(0.5 * Math.PI);
  },
  // A plate whose upper face is y = 0.
  slab({ width, height }) {
    return new THREE.BoxGeometry(width, height, 0.25 * width).translate(0.0, -0.5 * height, 0.0);
  },
  // The plane z = 0 under all that is seen.
  ground(_, solid, factor, look) {
    return new THREE.CircleGeometry(2.2 * look.radius, ROUND).translate(look.middle[0], look.middle[1], 0.0);
  },
  mesh({ vertices, normals, triangles }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(vertices.flat(), 3));
    geometry.setAttribute("normal", new THREE.Float32BufferAttribute(normals.flat(), 3));
    return geometry.setIndex(triangles.flat());
  },
};

function shapeGeometry(solid, factor, look) {
  const [[sort, numbers]] = Object.entries(solid.shape);
  return SHAPES[sort](numbers, solid, factor, look);
}

// Strokes of (radius, z) turned about z; a stroke is smooth, its ends are edges; radii grow by `grow`.
function turnedGeometry(strokes, grow, marked) {
  const places = [], normals = [], colours = [], index = [], out = outward(strokes);
  for (const stroke of strokes) {
    const first = places.length / 3;
    stroke.forEach(([radius, z], i) => {
      const [before, after] = [stroke[Math.max(i - 1, 0)], stroke[Math.min(i + 1, stroke.length - 1)]];
      const along = [after[0] - before[0], after[1] - before[1]], length = Math.hypot(...along) || 1.0;
      for (let j = 0; j <= ROUND; j++) {
        const angle = (2.0 * Math.PI * j) / ROUND, cosine = Math.cos(angle), sine = Math.sin(angle);
        places.push((radius + grow) * cosine, (radius + grow) * sine, z);
        normals.push((-out * along[1] * cosine) / length, (-out * along[1] * sine) / length, (out * along[0]) / length);
        const dark = marked && (j * MARKS) % ROUND < DARK;
        colours.push(...(dark ? [0.16, 0.42, 0.72] : [1.0, 1.0, 1.0]));
      }
    });
    for (let i = 0; i + 1 < stroke.length; i++) {
      for (let j = 0; j < ROUND; j++) {
        const a = first + i * (ROUND + 1) + j, b = a + ROUND + 1;
        if (out > 0.0) index.push(a, b, a + 1, b, b + 1, a + 1);
        else index.push(a, a + 1, b, b, a + 1, b + 1);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(places, 3));
  geometry.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
  return geometry.setIndex(index);
}

// 1 where a section's strokes run so that the body is on their right, as (radius, z), else -1.
function outward(strokes) {
  const corners = strokes.flat();
  const area = corners.reduce((sum, [r, z], k) => {
    const [nextR, nextZ] = corners[(k + 1) % corners.length];
    return sum + r * nextZ - nextR * z;
  }, 0.0);
  return area > 0.0 ? -1.0 : 1.0;
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

const turnOf = new THREE.Quaternion(), tiltOf = new THREE.Quaternion(), nextTurn = new THREE.Quaternion();
const placeOf = new THREE.Vector3(), ones = new THREE.Vector3(1.0, 1.0, 1.0), matrixOf = new THREE.Matrix4();

class Bodies {
  constructor(solid, store, palette, look) {
    Object.assign(this, { solid, store, look, group: new THREE.Group(), places: [], turns: [] });
    this.manyColours = typeof solid.colour !== "string";
    for (let k = 0; k < solid.count; k++) {
      this.places.push(new THREE.Vector3());
      this.turns.push(new THREE.Quaternion());
    }
    this.build(1.0, palette);
  }

  build(factor, palette) {
    this.group.children.forEach((mesh) => mesh.geometry.dispose());
    this.group.clear();
    const { solid } = this, turned = "turned" in solid.shape;
    const look = { vertexColors: turned, opacity: solid.opacity, transparent: solid.opacity < 1.0 };
    const shade = this.manyColours ? "steel" : solid.colour;
    this.body = this.mesh(shapeGeometry(solid, factor, this.look), shaded(shade, look));
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

  update(place, factor) {
    for (let k = 0; k < this.solid.count; k++) {
      this.placed(k, place, factor);
      matrixOf.compose(this.places[k], this.turns[k], ones);
      for (const mesh of this.group.children) mesh.setMatrixAt(k, matrixOf);
    }
    for (const mesh of this.group.children) mesh.instanceMatrix.needsUpdate = true;
  }

  placed(k, place, factor) {
    const { solid, store } = this, where = this.places[k].set(0.0, 0.0, 0.0), turn = this.turns[k].identity();
    const row = solid.place + k;
    if (solid.position) addVector(where, store, solid.position, place, 3 * row, 1.0);
    if (solid.deviation) addVector(where, store, solid.deviation, place, 3 * row, factor);
    if (solid.orientation) {
      quaternionAt(turn, store, solid.orientation, Math.floor(place), 4 * row);
      quaternionAt(nextTurn, store, solid.orientation, Math.min(Math.floor(place) + 1, store.count - 1), 4 * row);
      turn.slerp(nextTurn, place - Math.floor(place));
    } else if (solid.turn) {
      const angle = Math.atan2(store.between(solid.turn, place, 1), store.between(solid.turn, place, 0));
      turn.set(0.0, 0.0, Math.sin(0.5 * angle), Math.cos(0.5 * angle));
    }
    if (solid.tilt) {
      placeOf.set(factor * store.between(solid.tilt, place, 0), factor * store.between(solid.tilt, place, 1), 0.0);
      const angle = placeOf.length();
      if (angle > 0.0) turn.premultiply(tiltOf.setFromAxisAngle(placeOf.divideScalar(angle), angle));
    }
  }
}

function addVector(vector, store, name, place, column, factor) {
  vector.x += factor * store.between(name, place, column);
  vector.y += factor * store.between(name, place, column + 1);
  vector.z += factor * store.between(name, place, column + 2);
}

function quaternionAt(quaternion, store, name, frame, column) {
  quaternion.set(
    store.at(name, frame, column), store.at(name, frame, column + 1), store.at(name, frame, column + 2),
    store.at(name, frame, column + 3),
  ).normalize();
}

// Marks of forces and contacts: arrows, ellipses, surfaces coloured by a number, bent bars, paths of points.

const up = new THREE.Vector3(0.0, 1.0, 0.0), ahead = new THREE.Vector3(0.0, 0.0, 1.0), hidden = new THREE.Matrix4().makeScale(0, 0, 0);
const normalOf = new THREE.Vector3(), majorOf = new THREE.Vector3(), minorOf = new THREE.Vector3(), sizeOf = new THREE.Vector3();

const NONE = "none at any output"; // forces and contacts between outputs are not drawn

// Number of rows of `length` numbers in a series.
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

// Base of marks: their description, the numbers they show, and a group in the scene.
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
    this.greatest = mark.size ? store.greatest(mark.size) : store.greatest(mark.vector, 3);
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
    const { mark, greatest } = this;
    return [{ swatches: mark.colours, words: mark.words, scale: greatest ? `longest ${withUnit(greatest, mark)}` : NONE }];
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
    const words = `${this.mark.words}, by pressure`;
    if (!this.greatest) return [{ words, scale: NONE }];
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

const MARK_VIEWS = { arrows: ArrowMarks, contactellipses: EllipseMarks, movingmesh: MovingMeshMarks, bar: BarMarks, trail: TrailMarks };

// The picture in space: camera, bodies and marks, what is chosen in it, and the words that say its scales.

const MOST_NUMBERS = 40; // bodies with a number: more would cover each other
const STILL = 4; // pixels that a click may move
const COARSE = 0.5; // pixels of a picture that moves against those of one that stands, along an edge, where they are slow

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
function seen(look, store) {
  if (!look.around.length || !store.count) return look;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const name of look.around) {
    const { values } = store.get(name);
    for (let k = 0; k < values.length; k++) {
      low[k % 3] = Math.min(low[k % 3], values[k]);
      high[k % 3] = Math.max(high[k % 3], values[k]);
    }
  }
  const half = low.map((one, k) => 0.5 * (high[k] - one));
  return { ...look, radius: look.radius + Math.hypot(...half), middle: low.map((one, k) => one + half[k]) };
}

class Stage {
  constructor(parent, view, store, slow, chosen) {
    Object.assign(this, { parent, view, store, place: 0.0, selected: -1, slow, chosen });
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.slow });
    this.renderer.outputColorSpace = "srgb-linear"; // colours are drawn as they are written
    this.sharpen(false);
    parent.prepend(this.renderer.domElement);
    const look = (this.look = seen(view.look, store));
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();
    this.scale = 1.0 / look.radius;
    this.world.scale.setScalar(this.scale);
    this.world.position.set(...look.middle).multiplyScalar(-this.scale);
    this.scene.add(this.world);
    this.camera = new THREE.PerspectiveCamera(30.0, 1.0, 0.05, 200.0);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.ask());
    this.camera.up.set(...view.look.up);
    this.solids = view.solids.map((one) => new Bodies(one, store, view.palette, look));
    this.marks = view.marks.map((one) => new MARK_VIEWS[one.item](one, store));
    [...this.solids, ...this.marks].forEach((one) => this.world.add(one.group));
    if (view.axes) this.world.add(this.axes());
    this.numbers();
    this.halo = this.addHalo();
    this.enlarge(this.wantedFactor());
    this.listen();
    this.resize();
    this.home();
  }

  // Fewer pixels while a picture moves that no graphics processor draws.
  sharpen(moving) {
    const fine = Math.min(window.devicePixelRatio || 1.0, 2.0);
    this.renderer.setPixelRatio(this.slow ? (moving ? COARSE : 1.0) : fine);
    if (this.scene) this.ask();
  }

  bodies(name) {
    return this.solids.find((one) => one.solid.name === name);
  }

  // The enlargement at which the greatest displacement is drawn as long as the view wants it.
  wantedFactor() {
    const { enlarged } = this.view;
    if (!enlarged) return 1.0;
    const sizes = enlarged.series.map((name) => this.store.greatest(name, this.store.get(name).shape.at(-1) === 3 ? 3 : 1));
    return roundedDown(enlarged.reach / Math.max(enlarged.least, ...sizes));
  }

  enlarge(factor) {
    this.factor = factor;
    this.solids.forEach((one) => one.enlarge(factor));
    this.show(this.place);
  }

  home() {
    const direction = new THREE.Vector3(...this.view.look.direction).normalize();
    const wide = this.camera.aspect < 1.0 ? 1.0 / this.camera.aspect : 1.0;
    this.camera.position.copy(direction).multiplyScalar(4.3 * wide);
    this.controls.target.set(0.0, 0.0, 0.0);
    this.controls.update();
    this.ask();
  }

  // Directions of the axes in the middle, as long as there is room in a bore.
  axes() {
    const group = new THREE.Group(), length = 0.15 * this.look.radius;
    for (const [name, direction] of [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]]) {
      const geometry = new THREE.BufferGeometry();
      const end = direction.map((one) => one * length);
      geometry.setAttribute("position", new THREE.Float32BufferAttribute([0, 0, 0, ...end], 3));
      group.add(new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: 0x8a97a3 })));
      this.label("axis", name, new THREE.Vector3(...end).multiplyScalar(1.25));
    }
    return group;
  }

  // A word that goes with a place in the world, which may move.
  label(sort, word, place) {
    const label = make("span", { class: sort }, word);
    this.parent.append(label);
    (this.labels ||= []).push([label, place]);
  }

  // The numbers of bodies that curves and tables name.
  numbers() {
    const { details } = this.view, places = details ? this.bodies(details.solid).places : [];
    if (places.length > 1 && places.length <= MOST_NUMBERS) places.forEach((place, k) => this.label("axis number", k, place));
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
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) <= STILL) this.pick(event);
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
    if (hit) this.chosen(hit.instanceId);
  }

  select(body) {
    this.selected = body;
    this.show(this.place);
  }

  resize() {
    const width = Math.max(this.parent.clientWidth, 1), height = Math.max(this.parent.clientHeight, 1);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  // Everything as it is at a place among the outputs.
  show(place) {
    this.place = place;
    if (!this.store.count) return;
    [...this.solids, ...this.marks].forEach((one) => one.update(place, this.factor, this));
    if (this.halo) {
      this.halo.visible = this.selected >= 0;
      if (this.selected >= 0) this.halo.position.copy(this.bodies(this.view.details.solid).places[this.selected]);
    }
    this.ask();
  }

  ask() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.render());
  }

  render() {
    this.asked = false;
    this.renderer.setClearColor(new THREE.Color(tone("stage")), 1.0);
    this.renderer.render(this.scene, this.camera);
    for (const [label, place] of this.labels || []) {
      const seen = place.clone().applyMatrix4(this.world.matrixWorld).project(this.camera);
      label.style.left = `${50.0 * (1.0 + seen.x)}%`;
      label.style.top = `${50.0 * (1.0 - seen.y)}%`;
    }
  }

  measure() {
    this.marks.forEach((one) => one.measure());
  }

  legend() {
    return this.marks.flatMap((one) => one.legend());
  }
}
