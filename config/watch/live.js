"use strict";
// What makes a page live: outputs as they come from watch_node, and commands back to it with the token behind #.

const liveToken = location.hash.slice(1);

// An event as {time: [s, ...], values: {series: [[numbers of one output], ...]}}; see bearing_twin/nodes/live.py.
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

function liveStart(series, append) {
  const bar = liveBar(), events = new EventSource("events");
  events.addEventListener("frames", (event) => append(liveFrames(event.data, series)));
  events.addEventListener("again", () => location.reload());
  events.addEventListener("status", (event) => (bar.state.textContent = event.data));
  events.onerror = () => (bar.state.textContent = "no connection: is watch still running?");
  events.onopen = () => (bar.state.textContent = "");
}

async function liveSend(command, say) {
  try {
    const answer = await fetch("command", { method: "POST", body: JSON.stringify(command), headers: { "X-Token": liveToken } });
    say.textContent = (await answer.text()).trim();
    say.classList.toggle("refused", !answer.ok);
  } catch {
    say.textContent = "no connection: is watch still running?";
  }
}

// Speed, load, pace, pause and reset.
function liveBar() {
  const element = (tag, fields = {}, ...children) => {
    const one = Object.assign(document.createElement(tag), fields);
    one.append(...children);
    return one;
  };
  const say = element("output", { id: "live-answer" }), state = element("span", { id: "live-state" });
  const send = (command) => liveSend(command, say);
  const button = (text, act) => element("button", { type: "button", textContent: text, onclick: act });
  const number = (label, value, step = "any") => element("input", { type: "number", step, value, ariaLabel: label, title: label });
  const group = (words, ...parts) => element("span", { className: "live-group" }, element("label", { textContent: words }), ...parts);
  const speed = number("speed [rpm]", 1750), pace = number("pace, times real time", 1);
  const load = ["x", "y", "z"].map((axis) => number(`load along ${axis} [N]`, 0));
  const bar = element("section", { id: "live" },
    group("speed [rpm]", speed, button("set", () => send({ do: "speed", value: (speed.valueAsNumber * Math.PI) / 30 }))),
    group("load x, y, z [N]", ...load, button("set", () => send({ do: "load", force: load.map((one) => one.valueAsNumber) }))),
    group("× real time", pace, button("set", () => send({ do: "pace", value: pace.valueAsNumber }))),
    group("", button("pause", () => send({ do: "pause", on: true })), button("go on", () => send({ do: "pause", on: false })),
      button("reset", () => send({ do: "reset" }))),
    say, state);
  if (!liveToken) {
    bar.querySelectorAll("input, button").forEach((one) => (one.disabled = true));
    say.textContent = "only to look at: commands need the whole address that watch printed";
  }
  document.body.append(bar);
  return { state };
}
