"use strict";
// Rigid bodies: where they stand and how they are turned at a place of the run.

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
