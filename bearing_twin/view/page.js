"use strict";
// The page: its parts put together from the document; what they show goes by one time.

const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];

const NOTHING_IN_SPACE = "This browser draws nothing in space: it has no WebGL 2, or it is switched off. Curves, contacts and figures are all here.";

class Page {
  constructor(found, store) {
    Object.assign(this, { found, store, view: found.view, charts: [], selected: -1 });
    this.group = { key: "run", charts: this.charts, seek: (x) => this.seek(x / this.timeFactor) };
    headings(found);
    this.panes = new Panes();
    if (store) this.showRun();
    else showStudy(found, this.panes, this.charts);
    themes(() => this.restyle());
  }

  showRun() {
    const { view, store, found } = this;
    const drawn = view.solids.length || view.marks.length, drawing = drawn ? graphics() : null;
    document.body.classList.toggle("flat", !drawn);
    document.body.classList.toggle("still", store.count < 2);
    if (drawing) {
      this.stage = new Stage($("space"), view, store, drawing.slow, (body) => this.select(body));
      this.tools();
    } else if (drawn) $("space").prepend(make("p", { class: "note empty" }, NOTHING_IN_SPACE));
    if (view.details) this.details = new Details($("details"), view, store, (body) => this.select(body));
    const curves = this.panes.add("Curves", "curves");
    if (found.notes.length) curves.append(sentences("Of this page", found.notes, "doubt"));
    [this.timeFactor, this.timeUnit] = timed(store.last);
    for (const panel of view.panels) new Chart(curves, this.panelSpec(panel), this.group);
    if (!view.panels.length) curves.append(make("p", { class: "note" }, "There is no channel that can be drawn as a curve."));
    const figures = this.panes.add("Figures");
    figures.append(figureTable(found.figures), ...found.tables.map((table) => ballTable(table, table.noun || view.details?.noun || "number")));
    showModel(this.panes.add("Model"), found, view.words);
    this.player = new Player($("player"), store, view.period, (time, place) => this.show(time, place),
      (moving) => this.stage?.sharpen(moving), (seconds) => this.stage?.keepPace(seconds));
    if (this.details) this.select(heaviest(store, view.details));
    this.legend();
    this.player.seek(store.first);
  }

  panelSpec(panel) {
    const { store, view, timeFactor, timeUnit } = this;
    const few = store.count <= 60;
    const lines = panel.lines.filter((line) => store.has(line.series)).map((line) => ({
      ...line, colour: curveColour(line.colour, view.palette), dash: curveDash(line.colour, view.palette), points: few,
      number: line.colour,
    }));
    return {
      ...panel, lines, ...curvesOf(store, lines, timeFactor),
      unit: panel.unit === "1" ? "" : panel.unit, xShort: "", ...this.timeWords(timeUnit),
    };
  }

  timeWords(unit) {
    return { xLabel: `time [${unit}]`, xUnit: unit };
  }

  tools() {
    const { stage, view } = this, tools = $("tools");
    tools.replaceChildren();
    if (view.enlarged) {
      const rows = once([...FACTORS, stage.factor]).sort((a, b) => a - b);
      const select = make("select", { id: "factor" }, ...rows.map((one) => make("option", { value: one }, `×${one}`)));
      select.value = String(stage.factor);
      select.addEventListener("change", () => {
        stage.enlarge(Number(select.value));
        this.legend();
      });
      tools.append(make("label", {}, view.enlarged.words, select));
    }
    tools.append(make("button", { type: "button", id: "home", onclick: () => stage.home() }, "turn back"));
  }

  legend() {
    const rows = this.stage ? this.stage.legend() : [];
    $("legend").replaceChildren(...rows.map(({ swatches, scaleTo, words, scale }) => {
      const row = make("div");
      for (const one of swatches || []) row.append(make("i", { style: `background: rgb(${SHADES[one].join(",")})` }));
      if (scaleTo) row.append(make("i", { class: "ramp", style: `background: ${scaleGradient()}` }));
      row.append(make("span", {}, words), make("span", { class: "scale" }, [scaleTo && `0 to ${scaleTo}`, scale].filter(Boolean).join(", ")));
      return row;
    }));
    if (this.stage && this.view.enlarged) {
      const words = make("span", {}, this.view.enlarged.words), scale = make("span", { class: "scale" }, `×${this.stage.factor}`);
      $("legend").append(make("div", { class: "filmed" }, words, scale));
    }
  }

  show(time, place) {
    this.stage?.show(place);
    this.details?.update(place);
    this.charts.forEach((chart) => chart.mark(time * this.timeFactor));
  }

  // Only the picture in space and its time, as a film shows it.
  filmed() {
    this.legend();
    this.stage.select(-1);
    this.stage.resize();
    this.stage.home();
  }

  seek(time) {
    this.player.pause();
    this.player.seek(time);
  }

  select(body) {
    this.selected = body;
    this.details.choose(body);
    this.stage?.select(body);
    this.charts.forEach((chart) => chart.bring(body));
    this.details.update(this.store.placeOf(this.player.time));
  }

  restyle() {
    for (const chart of this.charts) {
      chart.spec.lines.forEach((line) => {
        if (line.number !== undefined) line.colour = curveColour(line.number, this.found.palette || this.view.palette);
      });
      chart.build();
      chart.bring(this.selected);
    }
    this.stage?.ask();
  }

  // Further outputs of a run that goes on, as of Store.append; shows the last of them.
  append(frames) {
    this.store.append(frames);
    this.stage?.measure();
    this.details?.measure();
    const unit = this.timeUnit;
    [this.timeFactor, this.timeUnit] = timed(this.store.last);
    for (const chart of this.charts) {
      Object.assign(chart.spec, curvesOf(this.store, chart.spec.lines, this.timeFactor), this.timeWords(this.timeUnit));
      if (unit === this.timeUnit) chart.plot.setData(chart.data());
      else chart.outgrown();
    }
    this.player.measure();
    this.legend();
    this.player.seek(this.store.last);
  }
}

class Panes {
  add(title, sort = "") {
    const pane = make("div", { class: `pane ${sort}`, role: "tabpanel" }), tab = make("button", { type: "button", role: "tab" }, title);
    tab.addEventListener("click", () => this.open(tab, pane));
    $("tabs").append(tab);
    $("panes").append(pane);
    if ($("tabs").children.length === 1) this.open(tab, pane);
    else pane.hidden = true;
    return pane;
  }

  open(tab, pane) {
    for (const one of $("tabs").children) one.setAttribute("aria-selected", String(one === tab));
    for (const one of $("panes").children) one.hidden = one !== pane;
    $("panes").scrollTop = 0;
  }
}

const heaviest = (store, details) => {
  const { shape } = store.get(details.pressure), contacts = shape[1] || 1;
  let best = 0, greatest = -1.0;
  for (let k = 0; k < shape[0] * contacts; k++) {
    const value = store.count ? store.at(details.pressure, 0, k) : 0.0;
    if (value > greatest) [best, greatest] = [Math.floor(k / contacts), value];
  }
  return best;
};

function headings(found) {
  $("title").textContent = found.title;
  $("subtitle").textContent = found.subtitle;
  for (const { sort, name, text } of found.badges) {
    const badge = make("span", { class: `badge ${sort || ""}` }, name ? make("b", {}, name) : "", text);
    if (sort === "doubt") badge.addEventListener("click", () => $("tabs").lastElementChild.click());
    $("badges").append(badge);
  }
}

function showModel(pane, found, words) {
  pane.append(sentences("Warnings", [...found.flags, ...found.warnings], "doubt"));
  pane.append(sentences("Errors", found.errors || [], ""));
  pane.append(make("section", { class: "card" }, make("h3", {}, "Why this model"), make("p", {}, found.reason || "The log does not say.")));
  pane.append(make("section", { class: "card" }, make("h3", {}, "The run"), factList(found.facts)));
  if (words) pane.append(make("section", { class: "card" }, make("h3", {}, "The picture"), make("p", {}, words)));
  pane.append(make("p", { class: "note" }, `Made by bearing_twin ${found.version} with three.js and uPlot (MIT licence); this file needs no network.`));
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

async function start() {
  const found = JSON.parse($("document").textContent);
  const store = found.packed ? await unpacked(found.packed) : null;
  window.bearingView = new Page(found, store);
  document.body.dataset.ready = "yes";
}

start();
