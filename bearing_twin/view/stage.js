"use strict";
// The picture in space: camera, bodies and marks, what is chosen in it, and the words that say its scales.

const MOST_NUMBERS = 40; // bodies with a number: more would cover each other
const STILL = 4; // pixels that a click may move
const FINEST = 0.75, COARSEST = 0.3; // pixels of a moving picture against those of a still one, along an edge
const SLOW_FRAME = 1.0 / 18.0, QUICK_FRAME = 1.0 / 40.0; // s between images: fewer pixels beyond the one, more below the other

// What draws pictures in space: null where this browser draws none; `slow` where no graphics processor does, so that
// smooth edges and fine pixels would cost most of the frames.
function graphics() {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return null;
  const facts = context.getExtension("WEBGL_debug_renderer_info");
  const name = facts ? String(context.getParameter(facts.UNMASKED_RENDERER_WEBGL)) : "";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return { slow: /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name) };
}

// What is looked at, wide enough for all points of the series that are to be seen.
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
    Object.assign(this, { parent, view, store, place: 0.0, selected: -1, slow, chosen, coarse: FINEST });
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
    this.renderer.setPixelRatio(this.slow ? (moving ? this.coarse : 1.0) : fine);
    if (this.scene) this.ask();
  }

  // As many pixels as the machine draws in time, by the mean time between the last images [s].
  keepPace(seconds) {
    const wanted = seconds > SLOW_FRAME ? this.coarse * 0.8 : seconds < QUICK_FRAME ? this.coarse * 1.1 : this.coarse;
    const coarse = Math.min(Math.max(wanted, COARSEST), FINEST);
    if (!this.slow || coarse === this.coarse) return;
    this.coarse = coarse;
    this.sharpen(true);
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
