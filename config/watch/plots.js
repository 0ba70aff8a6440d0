"use strict";
// Curves of a run that goes on, a few panels; each shows the series that is chosen for it.

const LONGEST = 1500; // outputs that are kept
const COLOURS = ["#1f77b4", "#e06c00", "#2a8a2a", "#c62828", "#7b52ab", "#8c564b", "#c2459b", "#666", "#8a8b00", "#008c9e"];
const found = JSON.parse(document.getElementById("document").textContent);
const kept = { time: [], values: Object.fromEntries(found.series.map((one) => [one.name, []])) };

document.getElementById("title").textContent = `${found.title}, live`;
document.getElementById("subtitle").textContent = found.subtitle;
document.getElementById("model").textContent = `${found.node} · law ${found.law || "-"}, method ${found.stepper || "-"}`;

class Panel {
  constructor(name) {
    this.select = document.createElement("select");
    this.select.ariaLabel = "series";
    for (const one of found.series) this.select.append(new Option(`${one.name.replaceAll("_", " ")} [${one.unit}]`, one.name, false, one.name === name));
    this.canvas = document.createElement("canvas");
    const box = document.createElement("section");
    box.append(this.select, this.canvas);
    document.getElementById("main").append(box);
    this.select.addEventListener("change", () => this.draw());
  }

  draw() {
    const { canvas } = this, ratio = window.devicePixelRatio || 1, rows = kept.values[this.select.value], { time } = kept;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    Object.assign(canvas, { width: width * ratio, height: height * ratio });
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    if (time.length < 2) return;
    let low = Infinity, high = -Infinity;
    for (const row of rows) for (const one of row) if (Number.isFinite(one)) [low, high] = [Math.min(low, one), Math.max(high, one)];
    if (!(high > low)) [low, high] = [low - (Math.abs(low) || 1) * 0.5, low + (Math.abs(low) || 1) * 0.5];
    const left = 62, bottom = height - 20, x = (t) => left + ((width - left - 8) * (t - time[0])) / (time.at(-1) - time[0]);
    const y = (value) => bottom - ((bottom - 10) * (value - low)) / (high - low);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = "#4a5465";
    pen.strokeStyle = "#d5dbe4";
    for (let k = 0; k <= 4; k++) {
      const value = low + (k * (high - low)) / 4;
      pen.fillText(value.toPrecision(4), 2, y(value) + 4);
      pen.beginPath();
      pen.moveTo(left, y(value));
      pen.lineTo(width - 8, y(value));
      pen.stroke();
    }
    for (let k = 0; k <= 2; k++) {
      pen.textAlign = ["left", "center", "right"][k];
      const t = time[0] + (k * (time.at(-1) - time[0])) / 2;
      pen.fillText(`${t.toPrecision(6)} s`, x(t), height - 5);
    }
    for (let column = 0; column < rows[0].length; column++) {
      pen.strokeStyle = COLOURS[column % COLOURS.length];
      pen.beginPath();
      rows.forEach((row, k) => pen.lineTo(x(time[k]), y(row[column])));
      pen.stroke();
    }
  }
}

const names = new Set(found.series.map((one) => one.name));
const wanted = ["normal_load", "cage_speed", "inner_ring_force", "inner_ring_torque"].filter((one) => names.has(one));
const panels = (wanted.length ? wanted : [...names].slice(0, 4)).map((one) => new Panel(one));

liveStart(found.series, (frames) => {
  kept.time = [...kept.time, ...frames.time].slice(-LONGEST);
  for (const [name, rows] of Object.entries(frames.values)) kept.values[name] = [...kept.values[name], ...rows].slice(-LONGEST);
  requestAnimationFrame(() => panels.forEach((panel) => panel.draw()));
});
