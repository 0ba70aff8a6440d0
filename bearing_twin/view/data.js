"use strict";
// The numbers of a page: every series at every output shown, unpacked from the document or appended while they come.

const MISSING = 65535, STEPS = 65534;
const LONGEST_LIVE = 4000; // outputs that are kept of a run that goes on
const FAR = 5.0; // so many times what is usual near it a stretch between two outputs is a gap
const NEAR_SPANS = 15, ODD_SPANS = 2, FEW_SPANS = 4; // how many are near, are longer than usual, say anything

class Store {
  constructor(described) {
    this.series = new Map();
    for (const one of described) {
      const width = one.shape.reduce((product, size) => product * size, 1);
      this.series.set(one.name, { ...one, width, values: new Float32Array(0) });
    }
    this.count = 0;
    this.time = new Float64Array(0);
  }

  has(name) {
    return this.series.has(name);
  }

  get(name) {
    return this.series.get(name);
  }

  at(name, frame, column = 0) {
    const one = this.series.get(name);
    return one.values[frame * one.width + column];
  }

  // Between two outputs; `place` is a number of frames with its part.
  between(name, place, column = 0) {
    const low = Math.min(Math.floor(place), this.count - 1), high = Math.min(low + 1, this.count - 1);
    const first = this.at(name, low, column), second = this.at(name, high, column);
    return first + (place - low) * (second - first);
  }

  column(name, column = 0) {
    const { values, width } = this.series.get(name);
    const found = new Array(this.count);
    for (let frame = 0; frame < this.count; frame++) {
      const value = values[frame * width + column];
      found[frame] = Number.isNaN(value) ? null : value;
    }
    return found;
  }

  // Greatest size among the numbers of a series, or of its vectors of `length` numbers.
  greatest(name, length = 1) {
    const { values, width } = this.series.get(name);
    let found = 0.0;
    for (let first = 0; first + length <= this.count * width; first += length) {
      let square = 0.0;
      for (let k = 0; k < length; k++) square += values[first + k] ** 2;
      if (square > found) found = square;
    }
    return Math.sqrt(found);
  }

  get first() {
    return this.count ? this.time[0] : 0.0;
  }

  get last() {
    return this.count ? this.time[this.count - 1] : 0.0;
  }

  // The place of a time among the outputs, with its part between two of them.
  placeOf(time) {
    let low = 0, high = this.count - 1;
    if (high <= 0 || time <= this.time[0]) return 0;
    if (time >= this.time[high]) return high;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.time[middle] <= time) low = middle;
      else high = middle;
    }
    return low + (time - this.time[low]) / (this.time[high] - this.time[low] || 1.0);
  }

  // Adds outputs: {time: [s, ...], values: {series: [[numbers of one output], ...]}}; the oldest go when there are too many.
  append(frames) {
    const more = frames.time.length, kept = Math.min(this.count, Math.max(0, LONGEST_LIVE - more)), gone = this.count - kept;
    const time = new Float64Array(kept + more);
    time.set(this.time.subarray(gone, this.count));
    time.set(frames.time, kept);
    for (const one of this.series.values()) {
      const values = new Float32Array((kept + more) * one.width);
      values.set(one.values.subarray(gone * one.width, this.count * one.width));
      const rows = frames.values[one.name];
      if (rows) rows.forEach((row, k) => values.set(Array.isArray(row) ? row : [row], (kept + k) * one.width));
      one.values = values;
    }
    this.time = time;
    this.count = kept + more;
  }
}

// The outputs before which a stretch is missing: it lasts far longer than what lies between the outputs near it, of which
// one in each event of a live run is longer than the rest.
function gaps(time) {
  const lasts = (k) => time[k + 1] - time[k], found = [];
  const usual = (low, high) => {
    const spans = [];
    for (let k = Math.max(low, 0); k < Math.min(high, time.length - 1); k++) spans.push(lasts(k));
    return spans.length < FEW_SPANS ? 0.0 : spans.sort((a, b) => b - a)[ODD_SPANS];
  };
  for (let k = 0; k + 1 < time.length; k++) {
    // those before say it of nearly all outputs, quickly
    if (k && lasts(k) <= FAR * lasts(k - 1)) continue;
    const near = Math.max(usual(k - NEAR_SPANS, k), usual(k + 1, k + 1 + NEAR_SPANS));
    if (near > 0.0 && lasts(k) > FAR * near) found.push(k + 1);
  }
  return found;
}

// Curves over time [s] for Chart, with nothing where a stretch is missing: {x, ys}.
function curvesOf(store, lines, factor) {
  const places = gaps(store.time.subarray(0, store.count)), { time } = store;
  const parted = (column, between) => places.reduceRight((kept, k) => (kept.splice(k, 0, between(k)), kept), column);
  const x = Array.from(time.subarray(0, store.count), (one) => one * factor);
  return {
    x: parted(x, (k) => 0.5 * factor * (time[k - 1] + time[k])),
    ys: lines.map((line) => parted(store.column(line.series, line.column), () => null)),
  };
}

async function unpacked(packed) {
  const store = new Store(packed.series);
  const text = atob(packed.data), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const content = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = packed.frames;
  store.count = count;
  store.time = new Float64Array(content.slice(0, 8 * count).buffer);
  let start = 8 * count;
  for (const one of store.series.values()) {
    const size = count * one.width;
    one.values = decoded(content.subarray(start, start + size), content.subarray(start + size, start + 2 * size), one, count);
    start += 2 * size;
  }
  return store;
}

// A column is kept as differences, low bytes apart from high ones; see page.py.
function decoded(lowBytes, highBytes, one, count) {
  const values = new Float32Array(count * one.width);
  for (let column = 0, k = 0; column < one.width; column++) {
    const range = one.low.length > 1 ? column : 0;
    const low = one.low[range], step = (one.high[range] - low) / STEPS;
    for (let frame = 0, whole = 0; frame < count; frame++, k++) {
      whole = (whole + lowBytes[k] + 256 * highBytes[k]) & 65535;
      values[frame * one.width + column] = whole === MISSING ? NaN : low + step * whole;
    }
  }
  return values;
}
