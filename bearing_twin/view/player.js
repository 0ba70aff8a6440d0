"use strict";
// Time: play, pause, slider, pace; everything that shows the run gets each new time.

const PACED = 8; // images after which their pace is reported

class Player {
  constructor(parent, store, period, show, moving, paced) {
    Object.assign(this, { store, show, moving, paced, time: store.first, playing: false, shown: [] });
    this.measure();
    this.button = make("button", { type: "button", id: "play", title: "play or pause (space)", "aria-label": "play or pause" });
    this.slider = make("input", { type: "range", id: "time", min: 0, max: 1000, step: "any", value: 0, "aria-label": "time" });
    this.label = make("output", { id: "now" });
    this.pace = make("select", { id: "pace", title: "simulated time that passes in a second", "aria-label": "pace" });
    parent.replaceChildren(this.button, this.slider, this.label, this.pace);
    this.paces(period);
    this.button.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    this.slider.addEventListener("input", () => {
      this.pause();
      this.seek(store.first + (Number(this.slider.value) / 1000.0) * (store.last - store.first));
    });
    document.addEventListener("keydown", (event) => this.key(event));
    this.label.style.minWidth = `${2 * this.text(store.last).length + 3}ch`;
    this.icon();
  }

  measure() {
    [this.factor, this.unit] = timed(this.store.last);
  }

  // Simulated seconds in a second of looking: real time and slower in steps of 1, 2, 5.
  paces(period) {
    const span = this.store.last - this.store.first || 1.0, wanted = period > 0.0 ? Math.min(period, span / 2.0) : span / 8.0;
    const slowest = Math.min(wanted / 10.0, 1.0), rows = [];
    for (let decade = 0; 10 ** decade >= slowest / 10.0 && decade > -13; decade--) {
      for (const one of [1, 0.5, 0.2]) rows.push(one * 10 ** decade);
    }
    const kept = rows.filter((one) => one >= slowest * 0.99 && one <= Math.max(span, wanted * 1.01));
    if (!kept.length) kept.push(wanted);
    this.speed = kept.reduce((best, one) => (Math.abs(Math.log(one / wanted)) < Math.abs(Math.log(best / wanted)) ? one : best));
    for (const one of kept) {
      const slower = 1.0 / one, text = slower > 1.5 ? `1/${digits(slower, 3)} of real time` : "real time";
      this.pace.append(make("option", { value: one }, text));
    }
    this.pace.value = String(this.speed);
    this.pace.addEventListener("change", () => (this.speed = Number(this.pace.value)));
  }

  key(event) {
    if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName) && event.key === " ") return;
    if (event.key === " ") this.playing ? this.pause() : this.play();
    else if (event.key === "ArrowRight" || event.key === "ArrowLeft") this.step(event.key === "ArrowRight" ? 1 : -1);
    else return;
    event.preventDefault();
  }

  step(frames) {
    this.pause();
    const place = Math.min(Math.max(Math.round(this.store.placeOf(this.time)) + frames, 0), this.store.count - 1);
    this.seek(this.store.time[place]);
  }

  play() {
    if (this.time >= this.store.last) this.time = this.store.first;
    this.playing = true;
    this.before = null;
    this.icon();
    requestAnimationFrame((now) => this.tick(now));
  }

  pause() {
    this.playing = false;
    this.icon();
  }

  tick(now) {
    if (!this.playing) return;
    if (this.before !== null) {
      // a page that stood still, as one in the background, goes on where it was
      this.seek(this.time + this.speed * Math.min((now - this.before) / 1000.0, 0.25));
      this.shown.push(now);
      this.frames = (this.frames || 0) + 1;
      while (now - this.shown[0] > 2000.0) this.shown.shift();
      const last = this.shown.slice(-PACED - 1);
      if (this.frames % PACED === 0 && last.length > 2) this.paced((last.at(-1) - last[0]) / 1000.0 / (last.length - 1));
    }
    this.before = now;
    if (this.time >= this.store.last) this.pause();
    else requestAnimationFrame((next) => this.tick(next));
  }

  get framesPerSecond() {
    const { shown } = this;
    return shown.length > 2 ? (1000.0 * (shown.length - 1)) / (shown[shown.length - 1] - shown[0]) : 0.0;
  }

  seek(time) {
    const { store } = this;
    this.time = Math.min(Math.max(time, store.first), store.last);
    this.slider.value = String((1000.0 * (this.time - store.first)) / (store.last - store.first || 1.0));
    this.slider.style.setProperty("--done", `${this.slider.value / 10.0}%`);
    this.label.textContent = `${this.text(this.time)} / ${this.text(store.last)} ${this.unit}`;
    this.show(this.time, store.placeOf(this.time));
  }

  text(time) {
    const span = (this.store.last - this.store.first) * this.factor || 1.0;
    return (time * this.factor).toFixed(Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(span)))));
  }

  icon() {
    const path = this.playing ? "M5 3h4v14H5zM11 3h4v14h-4z" : "M5 2.5v15l12-7.5z";
    this.button.replaceChildren(draw("svg", { viewBox: "0 0 20 20", "aria-hidden": "true" }, draw("path", { d: path })));
    this.moving(this.playing);
  }
}
