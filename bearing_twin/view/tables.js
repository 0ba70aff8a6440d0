"use strict";
// Elements of the page: texts, numbers with units, tables, the contacts of the chosen body. Texts of a document are set as
// text, never as markup.

function make(tag, attributes = {}, ...children) {
  return fillElement(document.createElement(tag), attributes, children);
}

function draw(tag, attributes = {}, ...children) {
  return fillElement(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fillElement(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

const $ = (id) => document.getElementById(id);
const themeColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// [factor, unit with prefix] that make numbers up to `size` readable; `prefixes` as [prefix, scale], greatest first.
function prefixedUnit(size, unit, prefixes) {
  if (!(size > 0.0) || !Number.isFinite(size) || !unit || !prefixes.length) return [1.0, unit];
  const row = prefixes.find(([, scale]) => size >= scale) || prefixes.at(-1);
  return [1.0 / row[1], row[0] + unit];
}

// Factor and unit of times up to `size` seconds.
const timeUnit = (size) => prefixedUnit(Math.abs(size), "s", [["", 1.0], ["m", 1e-3], ["µ", 1e-6], ["n", 1e-9]]);

function digits(value, count = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value), rounded = Number(value.toPrecision(count));
  return (size >= 1e6 || size < 1e-4 ? rounded.toExponential() : rounded.toString()).replace("-", "−");
}

// A number with its unit, as 4.21 GPa; an angle in degrees.
function withUnit(value, { unit, prefixes }) {
  if (unit === "rad") return `${digits((value * 180.0) / Math.PI, 3)}°`;
  const [factor, shown] = prefixedUnit(Math.abs(value), unit, prefixes);
  return `${digits(value * factor, 3)}${shown ? " " + shown : ""}`;
}

// The greatest of 1, 2, 5, 10, 20 ... that is not above `value`, at least 1.
function roundDown(value) {
  if (!(value > 1.0) || !Number.isFinite(value)) return 1;
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * ([5, 2].find((digit) => digit * decade <= value) || 1);
}

// A table of this sort: columns are [words, unit, meaning], cells texts or elements.
function table(className, columns, rows) {
  const head = columns.map(([label, unit, meaning]) =>
    make("th", { title: meaning || "" }, label, ...(unit === undefined ? [] : [make("div", { class: "unit" }, unit || " ")])));
  const body = rows.map((row) => make("tr", {}, ...row.map((cell) => make("td", {}, cell))));
  return make("div", { class: "scroll" }, make("table", { class: className }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...body)));
}

function figureTable(rows, noun = "figure") {
  const extraColumns = [["error", "error"], ["95 % interval", "interval"]].filter(([, key]) => rows.some((row) => row[key]));
  const label = (row) => make("div", {}, row.words, make("div", { class: "meaning" }, row.meaning));
  return table("figures", [[noun], ["value"], ["unit"], ...extraColumns.map(([label]) => [label])],
    rows.map((row) => [label(row), row.value, row.unit, ...extraColumns.map(([, key]) => (key === "error" && row.error ? `± ${row.error}` : row[key] || ""))]));
}

function ballTable({ header, rows, errors, title }, noun) {
  const numbered = rows.map((row, k) => [k, ...row]);
  if (errors.length) numbered.push(["±", ...errors]);
  const element = table("balls", [[noun], ...header], numbered);
  return title ? make("section", {}, make("p", { class: "note" }, title), element) : element;
}

function card(title, ...content) {
  return make("section", { class: "card" }, make("h3", {}, title), ...content);
}

function factList(facts) {
  return make("dl", {}, ...facts.flatMap(([term, text]) => [make("dt", {}, term), make("dd", {}, text)]));
}

function sentences(title, texts, className) {
  const list = make("ul", {}, ...texts.map((text) => make("li", {}, text)));
  return texts.length ? make("section", { class: `said ${className}` }, make("h3", {}, title), list) : "";
}

class Details {
  constructor(parent, view, store, choose) {
    Object.assign(this, { details: view.details, store, body: -1 });
    const { noun, contacts, semi_major } = view.details, { shape } = store.get(semi_major);
    this.select = make("select", { "aria-label": `which ${noun}`, onchange: () => choose(Number(this.select.value)) },
      ...Array.from({ length: shape[0] }, (_, k) => make("option", { value: k }, `${noun} ${k}`)));
    const title = make("header", {}, this.select, make("span", { class: "hint" }, `click a ${noun} to look at it`));
    this.contacts = contacts.map((name, side) => this.contact(name, side));
    parent.replaceChildren(title, make("div", { class: "contacts" }, ...this.contacts.map((contact) => contact.box)));
    this.measure();
  }

  contact(name, side) {
    const gradient = draw("radialGradient", { id: `pressure${side}` });
    const ellipse = draw("ellipse", { cx: 0, cy: 0, fill: `url(#pressure${side})` });
    const note = draw("text", { x: 0, y: 7, class: "apart" }), numbers = make("div");
    const picture = draw("svg", { viewBox: "-100 -32 200 64", role: "img", "aria-label": `contact ellipse, ${name}` },
      draw("defs", {}, gradient), ellipse, note);
    return { gradient, ellipse, note, numbers, box: make("div", { class: "contact" }, make("h4", {}, name), picture, numbers) };
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

  update(index) {
    const { details, store } = this, frame = Math.min(Math.floor(index), store.count - 1);
    if (this.body < 0 || frame < 0) return;
    this.contacts.forEach(({ gradient, ellipse, note, numbers }, side) => {
      const read = (name) => store.value(name, frame, this.body * details.contacts.length + side);
      const [major, minor, pressure] = [details.semi_major, details.semi_minor, details.pressure].map(read);
      ellipse.setAttribute("rx", (92.0 * major) / this.longest);
      ellipse.setAttribute("ry", (92.0 * minor) / this.longest);
      note.textContent = major > 0.0 ? "" : "no contact";
      const stops = [0.0, 0.3, 0.55, 0.75, 0.9, 1.0]; // Hertz: the pressure falls as the root of 1 - r^2
      gradient.replaceChildren(...stops.map((r) => draw("stop", {
        offset: r, "stop-color": scaleText((pressure / this.greatest) * Math.sqrt(Math.max(0.0, 1.0 - r * r))),
      })));
      const rows = [["peak pressure", details.pressure], ...details.rows].map(([text, name]) => [text, withUnit(read(name), store.get(name))]);
      numbers.replaceChildren(factList([["semi-axes", bothAxes(major, minor, store.get(details.semi_major))], ...rows]));
    });
  }
}

// Both semi-axes in the unit of the longer one.
function bothAxes(major, minor, series) {
  const [factor, unit] = prefixedUnit(major, series.unit, series.prefixes);
  return major > 0.0 ? `${digits(major * factor, 3)} × ${digits(minor * factor, 3)} ${unit}` : "–";
}
