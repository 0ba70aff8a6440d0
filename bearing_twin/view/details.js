"use strict";
// The contacts of the chosen body: ellipses to one scale, pressure over each, load and angle in numbers.

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
