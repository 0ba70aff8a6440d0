"use strict";
// A live page: outputs as they come from watch_node, and commands back to it with the token behind #.

const LIVE_PERIOD = 100; // ms between changes of the picture, at least
const CURVES_EVERY = 5; // pictures for each time the curves are drawn
const TURNING = ["inner_ring_speed", "shaft_speed"]; // series [rad/s] by which turns are counted
const FEWEST_SHOWN = 10; // outputs, however fast the shaft turns
const liveToken = location.hash.slice(1);

// An event as {time: [s, ...], values: {series: [[numbers of one output], ...]}}; see run_page.py.
function liveFrames(text, series) {
  const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
  const count = new Float64Array(bytes.buffer.slice(0, 8))[0];
  const time = Array.from(new Float64Array(bytes.buffer.slice(8, 8 + 8 * count)));
  const table = new Float32Array(bytes.buffer.slice(8 + 8 * count));
  const widths = series.map((one) => one.shape.reduce((product, size) => product * size, 1));
  const row = widths.reduce((sum, one) => sum + one, 0), values = {};
  let low = 0;
  series.forEach((one, k) => {
    values[one.name] = time.map((_, frame) => Array.from(table.subarray(frame * row + low, frame * row + low + widths[k])));
    low += widths[k];
  });
  return { time, values };
}

// Outputs that wait to be shown: those of one event are spread over the time between two, so that slow motion is smooth.
class LiveQueue {
  constructor() {
    Object.assign(this, { time: [], values: {}, gap: LIVE_PERIOD, came: performance.now() });
  }

  add({ time, values }) {
    if (this.time.length && time[0] <= this.time.at(-1)) [this.time, this.values] = [[], {}]; // the run has begun again
    const now = performance.now();
    [this.gap, this.came] = [Math.min(Math.max(now - this.came, LIVE_PERIOD), 10000.0), now];
    this.time.push(...time);
    for (const [name, rows] of Object.entries(values)) (this.values[name] ||= []).push(...rows);
    this.share = Math.ceil((this.time.length * LIVE_PERIOD) / this.gap);
  }

  take() {
    const values = {};
    for (const [name, rows] of Object.entries(this.values)) values[name] = rows.splice(0, this.share);
    return { time: this.time.splice(0, this.share), values };
  }
}

function liveStart(view) {
  const { series } = view.found.packed, bar = liveBar(view.found.live), events = new EventSource("events");
  const waiting = new LiveQueue();
  let turns = 0;
  events.addEventListener("frames", (event) => waiting.add(liveFrames(event.data, series)));
  events.addEventListener("again", () => location.reload());
  events.addEventListener("pace", (event) => bar.paced(event.data));
  events.addEventListener("refused", (event) => bar.refused(event.data));
  events.addEventListener("status", (event) => (bar.state.textContent = event.data));
  events.onerror = () => (bar.state.textContent = "no connection: is watch still running?");
  events.onopen = () => (bar.state.textContent = "");
  setInterval(() => {
    if (!waiting.time.length || bar.held()) return;
    const frames = waiting.take(), again = frames.time[0] <= view.store.last;
    if (!turns || again) liveBegin(view);
    if (again || turns++ % CURVES_EVERY === 0) {
      view.append(frames);
      liveWindow(view, bar.turns());
    } else {
      view.store.append(frames);
      view.player.seek(view.store.last);
    }
  }, LIVE_PERIOD);
  for (const one of ["time", "play"]) $(one).addEventListener("pointerdown", () => bar.hold());
}

// Curves show the last `turns` of the shaft alone; all that is kept where that is 0, or where nothing turns.
function liveWindow({ store, charts, timeFactor }, turns) {
  const name = TURNING.find((one) => store.has(one)), speed = name ? Math.abs(store.at(name, store.count - 1)) : 0.0;
  if (!(turns > 0.0 && speed > 0.0) || !charts.length || store.count < FEWEST_SHOWN) return;
  const first = Math.min(store.last - (2.0 * Math.PI * turns) / speed, store.time[store.count - FEWEST_SHOWN]);
  charts[0].plot.setScale("x", { min: Math.max(first, store.first) * timeFactor, max: store.last * timeFactor }); // the others follow
}

// The page's first data are older than the events, or of a run that has begun again; curves are without dots, which
// cost most of the drawing.
function liveBegin(view) {
  view.store.count = 0;
  for (const chart of view.charts) {
    chart.spec.lines.forEach((line) => (line.points = false));
    chart.build();
  }
}

async function liveSend(command, say) {
  say.textContent = "…";
  try {
    const answer = await fetch("command", { method: "POST", body: JSON.stringify(command), headers: { "X-Token": liveToken } });
    say.textContent = (await answer.text()).trim();
    say.classList.toggle("refused", !answer.ok);
  } catch {
    say.textContent = "no connection: is watch still running?";
  }
}

// Speed, load, pace, pause and reset; and a switch that holds the picture while one looks back.
function liveBar({ commands, speed: turning, load: acting }) {
  const say = make("output", { id: "live-answer" }), state = make("span", { id: "live-state" });
  const send = (command) => liveSend(command, say);
  const button = (text, act) => make("button", { type: "button", onclick: act }, text);
  const number = (label, value) => make("input", { type: "number", step: "any", value, "aria-label": label, title: label });
  const group = (words, ...parts) => make("span", { class: "live-group" }, make("span", { class: "live-words" }, words), ...parts);
  const speed = number("speed [rpm]", Math.round((turning * 30) / Math.PI)), pace = number("pace: simulated seconds in a second", 1);
  const load = ["x", "y", "z"].map((axis, k) => number(`load along ${axis} [N]`, Number(acting[k].toPrecision(4))));
  const follow = make("input", { type: "checkbox", id: "live-follow", checked: "" });
  const obeys = (name, part) => (commands.includes(name) ? [part] : []);
  const turns = number("curves show so many turns of the shaft; 0 = all", 10);
  const controls = [
    ...obeys("command/speed", group("speed", speed, "rpm", button("set", () => send({ do: "speed", value: (speed.valueAsNumber * Math.PI) / 30 })))),
    ...obeys("command/load", group("load x, y, z", ...load, "N", button("set", () => send({ do: "load", force: load.map((one) => one.valueAsNumber) })))),
    group("pace", pace, "× real time", button("set", () => send({ do: "pace", value: pace.valueAsNumber }))),
    group("", button("pause", () => send({ do: "pause", on: true })), button("go on", () => send({ do: "pause", on: false })),
      button("reset", () => send({ do: "reset" }))),
  ];
  if (!liveToken) {
    for (const one of controls) one.querySelectorAll("input, button").forEach((each) => (each.disabled = true));
    say.textContent = "only to look at: commands need the whole address that watch printed";
  }
  document.body.insertBefore(
    make("section", { id: "live" }, ...controls, turning ? group("curves of", turns, "turns") : "", make("label", { class: "live-group" }, follow, "follow"), say, state), $("main"));
  let given = false; // a pace that somebody is about to set stays
  pace.addEventListener("input", () => (given = true));
  const paced = (value) => given || (pace.value = value);
  const refused = (words) => ((say.textContent = words), say.classList.add("refused"));
  return { state, paced, refused, turns: () => turns.valueAsNumber, held: () => !follow.checked, hold: () => (follow.checked = false) };
}

const liveReady = setInterval(() => {
  if (!document.body.dataset.ready) return;
  clearInterval(liveReady);
  liveStart(window.bearingView);
}, 50);
