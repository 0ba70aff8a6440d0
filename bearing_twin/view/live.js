"use strict";
// A live page: outputs as they come from watch_node, and commands back to it with the token behind #.

const LIVE_PERIOD = 100; // ms between changes of the picture, at least
const CURVES_EVERY = 5; // pictures for each time the curves are drawn
const TURNING = ["inner_ring_speed", "shaft_speed"]; // series [rad/s] by which turns are counted
const FEWEST_SHOWN = 10; // outputs, however fast the shaft turns
const liveToken = location.hash.slice(1);

// Outputs of one event are shown over the time between two, so that slow motion is smooth.
function liveStart(view) {
  const { series } = view.contents.packed, bar = liveBar(view.contents.live), events = new EventSource("events");
  let waiting = new Store(series), turns = 0, lastEvent = performance.now(), share = 1, read = Promise.resolve();
  const receive = async (text) => {
    const frames = await unpack(text, waiting), now = performance.now();
    if (waiting.count && frames.time[0] <= waiting.last) waiting = new Store(series); // the run has begun again
    waiting.append(frames, Infinity);
    share = Math.ceil((waiting.count * LIVE_PERIOD) / Math.min(Math.max(now - lastEvent, LIVE_PERIOD), 10000.0));
    lastEvent = now;
  };
  events.addEventListener("frames", (event) => (read = read.then(() => receive(event.data))));
  events.addEventListener("again", () => location.reload());
  events.addEventListener("pace", (event) => bar.paced(event.data));
  events.addEventListener("refused", (event) => bar.refused(event.data));
  events.addEventListener("status", (event) => (bar.state.textContent = event.data));
  events.onerror = () => (bar.state.textContent = "no connection: is watch still running?");
  events.onopen = () => (bar.state.textContent = "");
  setInterval(() => {
    if (!waiting.count || bar.held()) return;
    const frames = waiting.take(share), restarted = frames.time[0] <= view.store.last;
    if (!turns || restarted) liveBegin(view);
    if (restarted || turns++ % CURVES_EVERY === 0) {
      view.append(frames);
      liveWindow(view, bar.turns());
    } else {
      view.store.append(frames, LONGEST_LIVE);
      view.player.seek(view.store.last);
    }
  }, LIVE_PERIOD);
  for (const id of ["time", "play"]) $(id).addEventListener("pointerdown", () => bar.hold());
}

// Curves show the last `turns` of the shaft alone; all that is kept where that is 0, or where nothing turns.
function liveWindow({ store, charts, timeFactor }, turns) {
  const name = TURNING.find((series) => store.has(series)), speed = name ? Math.abs(store.value(name, store.count - 1)) : 0.0;
  if (!(turns > 0.0 && speed > 0.0) || store.count < FEWEST_SHOWN) return;
  const first = Math.min(store.last - (2.0 * Math.PI * turns) / speed, store.time[store.count - FEWEST_SHOWN]);
  const range = { min: Math.max(first, store.first) * timeFactor, max: store.last * timeFactor };
  for (const { plot } of charts) plot.setScale("x", range);
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
function liveBar({ commands, speed: initialSpeed, load: initialLoad }) {
  const say = make("output", { id: "live-answer" }), state = make("span", { id: "live-state" });
  const send = (command) => liveSend(command, say);
  const button = (text, act) => make("button", { type: "button", onclick: act }, text);
  const number = (label, value) => make("input", { type: "number", step: "any", value, "aria-label": label, title: label });
  const group = (label, ...parts) => make("span", { class: "live-group" }, make("span", { class: "live-words" }, label), ...parts);
  const speed = number("speed [rpm]", Math.round((initialSpeed * 30) / Math.PI)), pace = number("pace: simulated seconds in a second", 1);
  const load = ["x", "y", "z"].map((axis, k) => number(`load along ${axis} [N]`, Number(initialLoad[k].toPrecision(4))));
  const follow = make("input", { type: "checkbox", id: "live-follow", checked: "" });
  const ifCommand = (name, element) => (commands.includes(name) ? [element] : []);
  const turns = number("curves show so many turns of the shaft; 0 = all", 10);
  const controls = [
    ...ifCommand("command/speed", group("speed", speed, "rpm", button("set", () => send({ do: "speed", value: (speed.valueAsNumber * Math.PI) / 30 })))),
    ...ifCommand("command/load", group("load x, y, z", ...load, "N", button("set", () => send({ do: "load", force: load.map((input) => input.valueAsNumber) })))),
    group("pace", pace, "× real time", button("set", () => send({ do: "pace", value: pace.valueAsNumber }))),
    group("", button("pause", () => send({ do: "pause", on: true })), button("go on", () => send({ do: "pause", on: false })),
      button("reset", () => send({ do: "reset" }))),
  ];
  if (!liveToken) {
    for (const control of controls) control.querySelectorAll("input, button").forEach((each) => (each.disabled = true));
    say.textContent = "only to look at: commands need the whole address that watch printed";
  }
  document.body.insertBefore(
    make("section", { id: "live" }, ...controls, initialSpeed ? group("curves of", turns, "turns") : "", make("label", { class: "live-group" }, follow, "follow"), say, state), $("main"));
  let paceEdited = false; // a pace that somebody is about to set stays
  pace.addEventListener("input", () => (paceEdited = true));
  const paced = (value) => paceEdited || (pace.value = value);
  const refused = (sentence) => ((say.textContent = sentence), say.classList.add("refused"));
  return { state, paced, refused, turns: () => turns.valueAsNumber, held: () => !follow.checked, hold: () => (follow.checked = false) };
}

const liveReady = setInterval(() => {
  if (!document.body.dataset.ready) return;
  clearInterval(liveReady);
  liveStart(window.bearingView);
}, 50);
