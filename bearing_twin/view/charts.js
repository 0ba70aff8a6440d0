"use strict";
// Curves: hover, zoom by dragging, double click for all of it, click to go there; a line marks the time of the picture.

const LEGEND = 12; // curves that are named beside the title; more are named where the pointer is

class Chart {
  // spec: {title, unit, prefixes, lines: [{label, colour, dash, width, fill}], x, ys, xLabel, bands, spans}
  constructor(parent, spec, group) {
    Object.assign(this, { spec, group, marked: null });
    this.readout = make("span", { class: "readout" });
    this.names = make("div", { class: "names" });
    this.frame = make("div", { class: "plot" });
    this.element = make("section", { class: "chart" },
      make("header", {}, make("h3", {}, spec.title), this.readout), this.names, this.frame);
    parent.append(this.element);
    this.head = make("div", { class: "head" });
    this.build();
    new ResizeObserver(() => this.fit()).observe(this.frame);
    group?.charts.push(this);
  }

  build() {
    const { spec } = this, whole = spec.ys.flat().reduce((most, one) => Math.max(most, Math.abs(one) || 0.0), 0.0);
    [this.factor, this.unit] = prefixed(whole, spec.unit, spec.prefixes);
    const range = this.plot ? [this.plot.scales.x.min, this.plot.scales.x.max] : null;
    this.plot?.destroy();
    this.plot = new uPlot(this.options(), this.data(), this.frame);
    this.plot.over.append(this.head);
    this.plot.over.addEventListener("click", () => this.clicked());
    if (range && range[0] !== null && this.zoomed) this.plot.setScale("x", { min: range[0], max: range[1] });
    this.name();
  }

  // Built anew where times have another unit: a part that was looked at is none any more.
  outgrown() {
    this.zoomed = false;
    this.build();
  }

  data() {
    const { spec, factor } = this;
    return [spec.x, ...spec.ys.map((y) => y.map((one) => (one === null ? null : one * factor)))];
  }

  options() {
    const { spec } = this, soft = tone("soft"), grid = { stroke: tone("grid"), width: 1 };
    const axis = { stroke: soft, grid, ticks: { show: false }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
    const values = (u, splits) => splits.map((one) => (one === null ? "" : digits(one, 6)));
    return {
      width: this.width(), height: spec.height || 168, legend: { show: false }, focus: { alpha: 0.25 },
      padding: [8, 18, 0, 2],
      cursor: {
        sync: this.group ? { key: this.group.key } : undefined, drag: { x: true, y: false }, focus: { prox: 24 }, points: { size: 6 },
      },
      scales: { x: { time: false }, y: spec.range ? { range: spec.range } : {} },
      series: [{}, ...spec.lines.map((line) => this.line(line))],
      axes: [
        { ...axis, values, label: spec.xLabel, labelSize: 16, labelGap: -2, size: 24, gap: 3 },
        { ...axis, values, label: this.unit, labelSize: 18, size: (u, found) => sizeFor(found), gap: 4 },
      ],
      hooks: {
        setCursor: [() => this.read()],
        setSeries: [(u, number) => { this.focused = number; this.read(); }],
        setScale: [(u, key) => key === "x" && this.scaled()],
        ready: [() => this.mark(this.marked)],
        setSize: [() => this.mark(this.marked)],
        drawClear: [(u) => this.drawSpans(u)],
      },
      bands: spec.bands,
    };
  }

  line(line) {
    return {
      label: line.label, stroke: line.colour, width: line.width || 1.6, dash: line.dash, fill: line.fill,
      pxAlign: 0, // whole pixels make stairs of a curve that is nearly flat
      points: { show: Boolean(line.points), size: 5, fill: line.colour }, spanGaps: Boolean(line.spanGaps),
    };
  }

  // Coloured strips between two values of x, with a line at a third: intervals.
  drawSpans(u) {
    const { ctx, bbox } = u;
    for (const { low, high, value, colour } of this.spec.spans || []) {
      const [left, right, middle] = [low, high, value].map((one) => (one === null ? null : u.valToPos(one, "x", true)));
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      ctx.fillStyle = colour;
      ctx.globalAlpha = 0.2;
      const known = left !== null && right !== null && Number.isFinite(right - left);
      if (known) ctx.fillRect(left, bbox.top, Math.max(right - left, 1), bbox.height);
      ctx.globalAlpha = 1.0;
      ctx.fillRect(middle - 1, bbox.top, 2, bbox.height);
      ctx.restore();
    }
  }

  width() {
    return Math.max(this.frame.clientWidth, 120);
  }

  fit() {
    if (this.plot && Math.abs(this.plot.width - this.width()) > 1) this.plot.setSize({ width: this.width(), height: this.plot.height });
  }

  name() {
    const { lines } = this.spec;
    this.names.replaceChildren();
    if (lines.length > LEGEND || (lines.length === 1 && !this.spec.named)) return;
    lines.forEach((line, k) => {
      const item = make("button", { type: "button", class: "name", title: "show or hide this curve" },
        make("i", { style: `--line: ${line.stroke || line.colour}`, class: line.fill ? "filled" : line.dash?.length ? "dashed" : "" }), line.label);
      item.addEventListener("click", () => {
        const shown = !this.plot.series[k + 1].show;
        this.plot.setSeries(k + 1, { show: shown });
        item.classList.toggle("off", !shown);
      });
      this.names.append(item);
    });
  }

  read() {
    const { plot, spec } = this;
    if (!plot) return;
    const row = plot.cursor.idx;
    if (row === null || row === undefined || plot.cursor.left < 0) {
      this.readout.textContent = "";
      return;
    }
    const lines = spec.lines.map((line, k) => [line.label, plot.data[k + 1][row]]).filter(([, value]) => value !== null && value !== undefined);
    const near = this.focused ? lines.filter(([label]) => label === spec.lines[this.focused - 1]?.label) : lines.length <= 3 ? lines : [];
    const values = near.map(([label, value]) => `${label} ${digits(value)} ${this.unit}`.trim());
    this.readout.textContent = [`${spec.xShort || ""} ${digits(plot.data[0][row], 6)} ${spec.xUnit || ""}`.trim(), ...values].join(" · ");
  }

  clicked() {
    const { plot, group } = this;
    if (group?.seek && !plot.select.width && plot.cursor.left >= 0) group.seek(plot.posToVal(plot.cursor.left, "x"));
  }

  scaled() {
    const { plot, group } = this;
    if (!plot || !group || group.busy) return;
    const { min, max } = plot.scales.x;
    const full = plot.data[0];
    this.zoomed = full.length > 1 && (min > full[0] || max < full[full.length - 1]);
    group.busy = true;
    for (const one of group.charts) {
      if (one !== this && one.plot && (one.plot.scales.x.min !== min || one.plot.scales.x.max !== max)) {
        one.zoomed = this.zoomed;
        one.plot.setScale("x", { min, max });
      }
      one.mark(one.marked);
    }
    group.busy = false;
  }

  mark(x) {
    this.marked = x;
    if (!this.plot || x === null) return;
    const left = this.plot.valToPos(x, "x");
    this.head.style.display = Number.isFinite(left) && left >= 0 && left <= this.plot.bbox.width / uPlot.pxRatio ? "block" : "none";
    this.head.style.transform = `translateX(${left}px)`;
  }

  // Curves of one body in front, the others pale; -1 for all alike.
  bring(body) {
    const { lines } = this.spec;
    if (!lines.some((line) => line.body >= 0)) return;
    lines.forEach((line, k) => {
      const mine = body < 0 || line.body < 0 || line.body === body;
      this.plot.series[k + 1].alpha = mine ? 1.0 : 0.35;
      this.plot.series[k + 1].width = (body >= 0 && line.body === body ? 2.4 : line.width || 1.6) * (window.devicePixelRatio || 1);
    });
    this.plot.redraw(true);
  }
}

function sizeFor(values) {
  const longest = (values || []).reduce((most, text) => Math.max(most, text.length), 3);
  return 12 + 7 * longest;
}
