"use strict";
// The page: its parts put together from the document; what they show goes by one time, which plays or is chosen.

const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];

const NO_WEBGL = "This browser draws nothing in space: it has no WebGL 2, or it is switched off. Curves, contacts and figures are all here.";

class Page {
  constructor(contents, store) {
    Object.assign(this, { contents, store, view: contents.view, charts: [], selected: -1 });
    headings(contents);
    this.panes = new Panes();
    if (store) this.showRun();
    else this.showStudy();
    themes(() => this.restyle());
  }

  showRun() {
    const { view, store, contents } = this;
    const hasDrawing = view.solids.length || view.marks.length, drawing = hasDrawing ? graphics() : null;
    document.body.classList.toggle("flat", !hasDrawing);
    document.body.classList.toggle("still", store.count < 2);
    if (drawing) {
      this.stage = new Stage($("space"), view, store, drawing.slow, (body) => this.select(body));
      this.tools();
    } else if (hasDrawing) $("space").prepend(make("p", { class: "note empty" }, NO_WEBGL));
    if (view.details) this.details = new Details($("details"), view, store, (body) => this.select(body));
    const curves = this.panes.add("Curves", "curves");
    curves.append(sentences("Notes", contents.notes, "warning"));
    [this.timeFactor, this.timeUnit] = timeUnit(store.last);
    this.charts = view.panels.map((panel) => new Chart(curves, this.panelSpec(panel), (x) => this.seek(x / this.timeFactor)));
    if (!view.panels.length) curves.append(make("p", { class: "note" }, "There is no channel that can be drawn as a curve."));
    const noun = view.details?.noun || "number";
    this.panes.add("Figures").append(figureTable(contents.figures), ...contents.tables.map((table_) => ballTable(table_, table_.noun || noun)));
    showModel(this.panes.add("Model"), contents, ["Why this model", "The run"], view.words);
    this.player = new Player($("player"), store, view.period, (time, index) => this.show(time, index), (moving) => this.stage?.sharpen(moving));
    if (this.details) this.select(heaviest(store, view.details));
    this.legend();
    this.player.seek(store.first);
  }

  showStudy() {
    const { contents } = this;
    document.body.classList.add("flat", "still");
    const picture = make("img", { src: contents.picture, alt: "distributions, convergence, shares of the variance" });
    this.panes.add("Results").append(make("div", { class: "scroll" }, picture));
    this.panes.add("Statistics").append(...contents.statistics.map(({ title, rows }) => card(title, figureTable(rows, "statistic"))));
    showModel(this.panes.add("Study"), contents, ["Sampling", "The study"]);
  }

  panelSpec(panel) {
    const { store, view, timeFactor, timeUnit } = this;
    const lines = panel.lines.filter((line) => store.has(line.series)).map((line) => ({ ...line, points: store.count <= 60 }));
    return { ...panel, lines, palette: view.palette, ...curvesOf(store, lines, timeFactor), xUnit: timeUnit };
  }

  tools() {
    const { stage, view } = this, tools = $("tools");
    if (view.enlarged) {
      const rows = [...new Set([...FACTORS, stage.factor])].sort((a, b) => a - b);
      const select = make("select", { id: "factor", onchange: () => stage.enlarge(Number(select.value)) },
        ...rows.map((factor) => make("option", { value: factor }, `×${factor}`)));
      select.value = String(stage.factor);
      tools.append(make("label", {}, view.enlarged.words, select));
    }
    tools.append(make("button", { type: "button", id: "home", onclick: () => stage.home() }, "reset view"));
  }

  legend() {
    const rows = this.stage ? this.stage.legend() : [];
    $("legend").replaceChildren(...rows.map(({ swatches, scaleTo, words: label, scale }) => {
      const row = make("div");
      for (const swatch of swatches || []) row.append(make("i", { style: `background: rgb(${SHADES[swatch].join(",")})` }));
      if (scaleTo) row.append(make("i", { class: "ramp", style: `background: ${scaleGradient()}` }));
      row.append(make("span", {}, label), make("span", { class: "scale" }, [scaleTo && `0 to ${scaleTo}`, scale].filter(Boolean).join(", ")));
      return row;
    }));
  }

  show(time, index) {
    this.stage?.show(index);
    this.details?.update(index);
    this.charts.forEach((chart) => chart.markTime(time * this.timeFactor));
  }

  seek(time) {
    this.player.pause();
    this.player.seek(time);
  }

  select(body) {
    this.selected = body;
    this.details.choose(body);
    this.stage?.select(body);
    this.charts.forEach((chart) => chart.emphasize(body));
    this.details.update(this.store.indexOf(this.player.time));
  }

  restyle() {
    for (const chart of this.charts) {
      chart.build();
      chart.emphasize(this.selected);
    }
    this.stage?.requestRender();
  }

  // Further outputs of a run that goes on; shows the last of them.
  append(frames) {
    this.store.append(frames, LONGEST_LIVE);
    this.stage?.measure();
    this.details?.measure();
    const unit = this.timeUnit;
    [this.timeFactor, this.timeUnit] = timeUnit(this.store.last);
    for (const chart of this.charts) {
      Object.assign(chart.spec, curvesOf(this.store, chart.spec.lines, this.timeFactor), { xUnit: this.timeUnit });
      if (unit === this.timeUnit) chart.plot.setData(chart.data());
      else chart.build();
    }
    this.player.measure();
    this.legend();
    this.player.seek(this.store.last);
  }
}

class Panes {
  add(title, sort = "") {
    const pane = make("div", { class: `pane ${sort}`, role: "tabpanel" });
    const tab = make("button", { type: "button", role: "tab", onclick: () => this.open(tab, pane) }, title);
    $("tabs").append(tab);
    $("panes").append(pane);
    if ($("tabs").children.length === 1) this.open(tab, pane);
    else pane.hidden = true;
    return pane;
  }

  open(tab, pane) {
    for (const other of $("tabs").children) other.setAttribute("aria-selected", String(other === tab));
    for (const other of $("panes").children) other.hidden = other !== pane;
    $("panes").scrollTop = 0;
  }
}

// The body with the greatest pressure at the first output.
function heaviest(store, details) {
  const contacts = details.contacts.length, { width } = store.get(details.pressure);
  let best = 0;
  for (let k = 1; k < width; k++) if (store.value(details.pressure, 0, k) > store.value(details.pressure, 0, best)) best = k;
  return Math.floor(best / contacts);
}

function headings(contents) {
  $("title").textContent = contents.title;
  $("subtitle").textContent = contents.subtitle;
  for (const { sort, name, text } of contents.badges) {
    const badge = make("span", { class: `badge ${sort}` }, name ? make("b", {}, name) : "", text);
    if (sort === "warning") badge.addEventListener("click", () => $("tabs").lastElementChild.click());
    $("badges").append(badge);
  }
}

function showModel(pane, contents, [reasonTitle, runTitle], pictureText = "") {
  pane.append(sentences("Warnings", [...contents.flags, ...contents.warnings], "warning"), sentences("Errors", contents.errors, ""));
  pane.append(card(reasonTitle, make("p", {}, contents.reason || "The log does not say.")), card(runTitle, factList(contents.facts)));
  if (pictureText) pane.append(card("The picture", make("p", {}, pictureText)));
  pane.append(make("p", { class: "note" }, `Made by bearing_twin ${contents.version} with three.js and uPlot (MIT licence); this file needs no network.`));
}

function themes(changed) {
  const dark = window.matchMedia("(prefers-color-scheme: dark)"), root = document.documentElement;
  const set = (on) => {
    root.classList.toggle("dark", on);
    changed();
  };
  $("theme").addEventListener("click", () => set(!root.classList.contains("dark")));
  dark.addEventListener("change", () => set(dark.matches));
  if (dark.matches) set(true);
}

// Time: play, pause, slider, pace; everything that shows the run gets each new time.
class Player {
  constructor(parent, store, period, show, moving) {
    Object.assign(this, { store, show, moving, time: store.first, playing: false, images: 0 });
    this.measure();
    const toggle = () => (this.playing ? this.pause() : this.play());
    this.button = make("button", { type: "button", id: "play", title: "play or pause (space)", "aria-label": "play or pause", onclick: toggle });
    this.slider = make("input", { type: "range", id: "time", min: 0, max: 1000, step: "any", value: 0, "aria-label": "time", oninput: () => {
      this.pause();
      this.seek(store.first + (Number(this.slider.value) / 1000.0) * (store.last - store.first));
    } });
    this.label = make("output", { id: "now", style: `min-width: ${2 * this.text(store.last).length + 3}ch` });
    parent.replaceChildren(this.button, this.slider, this.label, this.paces(period));
    document.addEventListener("keydown", (event) => this.key(event, toggle));
    this.icon();
  }

  measure() {
    [this.factor, this.unit] = timeUnit(this.store.last);
  }

  // Choice of the simulated seconds in a second of looking: real time and slower in steps of 1, 2, 5.
  paces(period) {
    const span = this.store.last - this.store.first || 1.0, preferred = period > 0.0 ? Math.min(period, span / 2.0) : span / 8.0;
    const slowest = Math.min(preferred / 10.0, 1.0), rows = [];
    for (let decade = 0; 10 ** decade >= slowest / 10.0 && decade > -13; decade--) {
      for (const pace of [1, 0.5, 0.2]) rows.push(pace * 10 ** decade);
    }
    const choices = rows.filter((pace) => pace >= slowest * 0.99 && pace <= Math.max(span, preferred * 1.01));
    if (!choices.length) choices.push(preferred);
    this.speed = choices.reduce((best, pace) => (Math.abs(Math.log(pace / preferred)) < Math.abs(Math.log(best / preferred)) ? pace : best));
    const label = (pace) => (pace < 0.7 ? `1/${digits(1.0 / pace, 3)} of real time` : "real time");
    const select = make("select", { id: "pace", title: "simulated time that passes in a second", "aria-label": "pace",
      onchange: () => (this.speed = Number(select.value)) }, ...choices.map((pace) => make("option", { value: pace }, label(pace))));
    select.value = String(this.speed);
    return select;
  }

  // Keys with another one held are the browser's, and those of a control its own; arrows on the slider are the player's.
  key(event, toggle) {
    const { target } = event, isControl = ["INPUT", "SELECT"].includes(target.tagName) && target !== this.slider;
    if (event.altKey || event.ctrlKey || event.metaKey || isControl) return;
    if (event.key === " " && (target === this.slider || target.tagName === "BUTTON")) return;
    const action = { " ": toggle, ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1) }[event.key];
    if (!action) return;
    action();
    event.preventDefault();
  }

  step(frames) {
    this.pause();
    const index = Math.min(Math.max(Math.round(this.store.indexOf(this.time)) + frames, 0), this.store.count - 1);
    this.seek(this.store.time[index]);
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
    // a page that stood still, as one in the background, goes on where it was
    if (this.before !== null) this.seek(this.time + this.speed * Math.min((now - this.before) / 1000.0, 0.25));
    this.images++;
    this.before = now;
    if (this.time >= this.store.last) this.pause();
    else requestAnimationFrame((next) => this.tick(next));
  }

  seek(time) {
    const { store } = this;
    this.time = Math.min(Math.max(time, store.first), store.last);
    this.slider.value = String((1000.0 * (this.time - store.first)) / (store.last - store.first || 1.0));
    this.slider.style.setProperty("--done", `${this.slider.value / 10.0}%`);
    this.label.textContent = `${this.text(this.time)} / ${this.text(store.last)} ${this.unit}`;
    this.show(this.time, store.indexOf(this.time));
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

async function start() {
  const contents = JSON.parse($("document").textContent), { packed } = contents;
  const store = packed ? new Store(packed.series) : null;
  if (store) store.append(await unpack(packed.data, store), Infinity);
  window.bearingView = new Page(contents, store);
  document.body.dataset.ready = "yes";
}

start();
