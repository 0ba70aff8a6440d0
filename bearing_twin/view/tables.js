"use strict";
// Tables of figures, shares and facts, the page of a study, and the contacts of the chosen body.

function figureTable(rows) {
  const errors = rows.some((row) => row.error), intervals = rows.some((row) => row.interval);
  const head = make("tr", {}, make("th", {}, "figure"), make("th", { class: "number" }, "value"), make("th", {}, "unit"));
  if (errors) head.append(make("th", { class: "number" }, "error"));
  if (intervals) head.append(make("th", { class: "number" }, "95 % interval"));
  const body = make("tbody");
  for (const row of rows) {
    const words = make("td", {}, make("div", { class: "words" }, row.words));
    if (row.meaning) words.append(make("div", { class: "meaning" }, row.meaning));
    const sort = row.value.length > 24 ? "number long" : "number";
    const line = make("tr", {}, words, make("td", { class: sort }, row.value), make("td", { class: "unit" }, row.unit));
    if (errors) line.append(make("td", { class: "number" }, row.error ? `± ${row.error}` : ""));
    if (intervals) line.append(make("td", { class: "number" }, row.interval));
    body.append(line);
  }
  return make("div", { class: "scroll" }, make("table", { class: "figures" }, make("thead", {}, head), body));
}

function ballTable(table, noun) {
  const head = make("tr", {}, make("th", {}, noun));
  for (const [words, unit, meaning] of table.header) {
    head.append(make("th", { class: "number", title: meaning }, words, make("div", { class: "unit" }, unit || " ")));
  }
  const body = make("tbody");
  table.rows.forEach((row, k) => {
    body.append(make("tr", {}, make("td", {}, String(k)), ...row.map((one) => make("td", { class: "number" }, one))));
  });
  if (table.errors.length) {
    body.append(make("tr", {}, make("td", {}, "±"), ...table.errors.map((one) => make("td", { class: "number" }, one))));
  }
  const shown = make("div", { class: "scroll" }, make("table", { class: "balls" }, make("thead", {}, head), body));
  return table.title ? make("section", {}, make("p", { class: "note" }, table.title), shown) : shown;
}

function factList(facts) {
  const list = make("dl");
  for (const [words, text] of facts) list.append(make("dt", {}, words), make("dd", {}, text));
  return list;
}

function sentences(title, texts, sort) {
  const list = make("ul", {}, ...texts.map((text) => make("li", {}, text)));
  return texts.length ? make("section", { class: `said ${sort}` }, make("h3", {}, title), list) : "";
}

// Shares of a variance as bars with intervals: rows of {words, first, total} with value, low, high.
function shareBars(found) {
  const box = make("section", { class: "chart" }, make("header", {}, make("h3", {}, found.title)));
  const names = make("div", { class: "names" });
  found.orders.forEach((order, k) => names.append(make("span", { class: "name" }, make("i", { class: `order${k}` }), order)));
  box.append(names);
  for (const row of found.rows) {
    const bars = make("div", { class: "bars" });
    row.shares.forEach(({ value, low, high }, k) => {
      const percent = (one) => `${100.0 * Math.min(Math.max(one, 0.0), 1.0)}%`;
      const bar = make("div", { class: "share" }, make("div", { class: `bar order${k}`, style: `width: ${percent(value)}` }));
      if (low !== null && high !== null) {
        bar.append(make("div", { class: "whisker", style: `left: ${percent(low)}; right: calc(100% - ${percent(high)})` }));
      }
      bars.append(make("div", { class: "lane" }, bar, make("span", { class: "number" }, `${(Math.round(1000.0 * value) / 10.0 || 0.0).toFixed(1)} %`)));
    });
    box.append(make("div", { class: "row" }, make("div", { class: "words" }, row.words), bars));
  }
  return box;
}

function showStudy(found, panes, charts) {
  document.body.classList.add("flat", "still");
  const curves = panes.add("Results", "curves");
  for (const one of found.charts) charts.push(new Chart(curves, studySpec(one, found.palette)));
  for (const one of found.shares) curves.append(shareBars(one));
  const figures = panes.add("Statistics");
  for (const table of found.statistics) figures.append(make("section", { class: "card" }, make("h3", {}, table.title)), figureTable(table.rows));
  showModel(panes.add("Study"), found, "");
}

function studySpec(one, palette) {
  const lines = one.lines.map((line) => ({
    ...line, number: line.colour, colour: curveColour(line.colour, palette), dash: line.dashed ? [7, 4] : [],
    fill: line.filled ? `${palette[line.colour]}44` : undefined, stroke: palette[line.colour],
  }));
  const spans = one.spans.map((span) => ({ ...span, colour: palette[span.colour] }));
  const bands = one.bands.map(([high, low, colour]) => ({ series: [high + 1, low + 1], fill: `${palette[colour]}33` }));
  return { ...one, lines, spans, bands, height: 250, named: true, range: one.from_zero ? (u, low, high) => [0.0, 1.08 * high || 1.0] : undefined };
}

class Details {
  constructor(parent, view, store, choose) {
    Object.assign(this, { details: view.details, store, parent, body: -1, spots: [] });
    const count = store.get(view.details.semi_major).shape[0];
    this.select = make("select", { "aria-label": `which ${view.details.noun}` },
      ...Array.from({ length: count }, (_, k) => make("option", { value: k }, `${view.details.noun} ${k}`)));
    this.select.addEventListener("change", () => choose(Number(this.select.value)));
    const title = make("header", {}, this.select, make("span", { class: "hint" }, `click a ${view.details.noun} to look at it`));
    this.grid = make("div", { class: "contacts" });
    parent.replaceChildren(title, this.grid);
    this.details.contacts.forEach((name, side) => this.add(name, side));
    this.measure();
  }

  add(name, side) {
    const gradient = draw("radialGradient", { id: `pressure${side}` });
    const ellipse = draw("ellipse", { cx: 0, cy: 0, fill: `url(#pressure${side})` });
    const words = draw("text", { x: 0, y: 7, class: "apart" });
    const picture = draw("svg", { viewBox: "-100 -32 200 64", role: "img", "aria-label": `contact ellipse, ${name}` },
      draw("defs", {}, gradient), ellipse, words);
    const numbers = make("dl");
    this.grid.append(make("div", { class: "contact" }, make("h4", {}, name), picture, numbers));
    this.spots.push({ side, gradient, ellipse, words, numbers });
  }

  measure() {
    const { details, store } = this;
    this.longest = store.greatest(details.semi_major) || 1.0;
    this.greatest = store.greatest(details.pressure) || 1.0;
  }

  choose(body) {
    this.body = body;
    this.select.value = String(body);
  }

  update(place) {
    const { details, store } = this, frame = Math.min(Math.floor(place), store.count - 1);
    if (this.body < 0 || frame < 0) return;
    for (const { side, gradient, ellipse, words, numbers } of this.spots) {
      const column = this.body * details.contacts.length + side;
      const read = (name) => store.at(name, frame, column);
      const [major, minor, pressure] = [details.semi_major, details.semi_minor, details.pressure].map(read);
      ellipse.setAttribute("rx", (92.0 * major) / this.longest);
      ellipse.setAttribute("ry", (92.0 * minor) / this.longest);
      words.textContent = major > 0.0 ? "" : "apart";
      const stops = [0.0, 0.3, 0.55, 0.75, 0.9, 1.0]; // Hertz: the pressure falls as the root of 1 - r^2
      gradient.replaceChildren(...stops.map((r) => draw("stop", {
        offset: r, "stop-color": scaleText((pressure / this.greatest) * Math.sqrt(Math.max(0.0, 1.0 - r * r))),
      })));
      const rows = [["semi-axes", bothAxes(major, minor, store.get(details.semi_major))],
        ["peak pressure", withUnit(pressure, store.get(details.pressure))],
        ...details.rows.map(([text, name]) => [text, angleOr(read(name), store.get(name))])];
      if (numbers.children.length !== 2 * rows.length) {
        numbers.replaceChildren(...rows.flatMap(([text]) => [make("dt", {}, text), make("dd", {}, "")]));
      }
      rows.forEach(([, value], k) => (numbers.children[2 * k + 1].textContent = value));
    }
  }
}

// Both semi-axes in the unit of the longer one.
function bothAxes(major, minor, series) {
  const [factor, unit] = prefixed(major, series.unit, series.prefixes);
  return major > 0.0 ? `${digits(major * factor, 3)} × ${digits(minor * factor, 3)} ${unit}` : "–";
}

const angleOr = (value, series) => (series.unit === "rad" ? `${digits((value * 180.0) / Math.PI, 3)}°` : withUnit(value, series, 3));
