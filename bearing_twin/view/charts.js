"use strict";
// Curves: hover, zoom by dragging, double click for all of it, click to go there; a line marks the time of the picture.

const LEGEND = 12; // curves that are named above; more are named where the pointer is

// A colour of a curve or a body; black would not be seen on a dark ground.
function curveColour(number, palette) {
  const colour = palette[number % palette.length];
  return colour === "#000000" ? themeColour("ink") : colour;
}

const curveDash = (number, palette) => [[], [6, 3], [2, 3], [8, 3, 2, 3]][Math.floor(number / palette.length) % 4];

class Chart {
  // spec: {title, unit, prefixes, lines: [{label, colour, body, points}], palette, x, ys, xUnit}; seek(x) goes there
  constructor(parent, spec, seek) {
    Object.assign(this, { spec, seek, marked: null });
    this.readout = make("span", { class: "readout" });
    this.frame = make("div", { class: "plot" });
    this.timeLine = make("div", { class: "head" });
    parent.append(make("section", { class: "chart" }, make("header", {}, make("h3", {}, spec.title), this.readout), this.frame));
    this.build();
    new ResizeObserver(() => this.plot.setSize({ width: this.width(), height: this.plot.height })).observe(this.frame);
  }

  build() {
    const { spec } = this, greatest = spec.ys.flat().reduce((largest, y) => Math.max(largest, Math.abs(y) || 0.0), 0.0);
    [this.factor, this.unit] = prefixedUnit(greatest, spec.unit, spec.prefixes);
    this.plot?.destroy();
    this.plot = new uPlot(this.options(), this.data(), this.frame);
    this.plot.over.append(this.timeLine);
    this.plot.over.addEventListener("click", () => this.onClick());
  }

  data() {
    const { spec, factor } = this;
    return [spec.x, ...spec.ys.map((y) => y.map((value) => (value === null ? null : value * factor)))];
  }

  options() {
    const { lines, xUnit } = this.spec, font = "12px system-ui, sans-serif", grid = { stroke: themeColour("grid"), width: 1 };
    const values = (u, splits) => splits.map((split) => (split === null ? "" : digits(split, 6)));
    const axis = { stroke: themeColour("soft"), grid, ticks: { show: false }, font, labelFont: font, values };
    return {
      width: this.width(), height: 168, legend: { show: lines.length > 1 && lines.length <= LEGEND, live: false },
      focus: { alpha: 0.25 }, padding: [8, 18, 0, 2],
      cursor: { sync: { key: "run" }, drag: { x: true, y: false }, focus: { prox: 24 }, points: { size: 6 } },
      scales: { x: { time: false } },
      series: [{}, ...lines.map((line) => this.line(line))],
      axes: [
        { ...axis, label: `time [${xUnit}]`, labelSize: 16, labelGap: -2, size: 24, gap: 3 },
        { ...axis, label: this.unit, labelSize: 18, size: 54, gap: 4 },
      ],
      hooks: {
        setCursor: [() => this.showValues()],
        setSeries: [(u, number) => { this.focused = number; this.showValues(); }],
        ...Object.fromEntries(["setScale", "ready", "setSize"].map((hook) => [hook, [() => this.markTime(this.time)]])),
      },
    };
  }

  line({ label, colour, points }) {
    const { palette } = this.spec, stroke = curveColour(colour, palette);
    // whole pixels (pxAlign) make stairs of a curve that is nearly flat
    return { label, stroke, width: 1.6, dash: curveDash(colour, palette), pxAlign: 0, points: { show: Boolean(points), size: 5, fill: stroke } };
  }

  width() {
    return Math.max(this.frame.clientWidth, 120);
  }

  // Says the time where the pointer is, and the numbers of the curve near it, or of all where they are few.
  showValues() {
    const { plot, spec } = this, row = plot?.cursor.idx;
    if (!plot || row === null || row === undefined || plot.cursor.left < 0) {
      this.readout.textContent = "";
      return;
    }
    const shown = this.focused ? [this.focused - 1] : spec.lines.length <= 3 ? [...spec.lines.keys()] : [];
    const readings = shown.map((k) => [spec.lines[k].label, plot.data[k + 1][row]]).filter(([, value]) => value !== null && value !== undefined);
    const texts = readings.map(([label, value]) => `${label} ${digits(value)} ${this.unit}`.trim());
    this.readout.textContent = [`${digits(plot.data[0][row], 6)} ${spec.xUnit}`, ...texts].join(" · ");
  }

  onClick() {
    const { select, cursor } = this.plot;
    if (!select.width && cursor.left >= 0) this.seek(this.plot.posToVal(cursor.left, "x"));
  }

  markTime(x) {
    this.time = x;
    if (!this.plot || x === null) return;
    const left = this.plot.valToPos(x, "x");
    this.timeLine.style.display = left >= 0 && left <= this.plot.over.clientWidth ? "block" : "none";
    this.timeLine.style.transform = `translateX(${left}px)`;
  }

  // Curves of one body in front, the others pale; -1 for all alike.
  emphasize(body) {
    const { lines } = this.spec;
    if (!lines.some((line) => line.body >= 0)) return;
    lines.forEach((line, k) => {
      this.plot.series[k + 1].alpha = body < 0 || line.body === body ? 1.0 : 0.35;
      this.plot.series[k + 1].width = (body >= 0 && line.body === body ? 2.4 : 1.6) * (window.devicePixelRatio || 1);
    });
    this.plot.redraw(false);
  }
}
