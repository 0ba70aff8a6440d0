"use strict";
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
