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
    const found = Array.from({ length: this.count }, (_, frame) => this.at(name, frame, column));
    return found.map((one) => (Number.isNaN(one) ? null : one));
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

  // Takes in outputs behind those that are there, as of `unpacked`; the oldest go where there are more than `most`.
  append({ time, values }, most) {
    const kept = Math.min(this.count, Math.max(0, most - time.length)), gone = this.count - kept;
    const joined = (before, more, width) => {
      const found = new before.constructor((kept + time.length) * width);
      found.set(before.subarray(gone * width, this.count * width));
      found.set(more, kept * width);
      return found;
    };
    for (const one of this.series.values()) one.values = joined(one.values, values[one.name], one.width);
    this.time = joined(this.time, time, 1);
    this.count = this.time.length;
  }

  // Takes out the first `count` outputs, as `append` takes them in.
  take(count) {
    const values = {}, time = this.time.slice(0, count);
    for (const one of this.series.values()) {
      values[one.name] = one.values.slice(0, count * one.width);
      one.values = one.values.slice(count * one.width);
    }
    this.time = this.time.slice(count);
    this.count = this.time.length;
    return { time, values };
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
  const { time } = store, places = gaps(time);
  const parted = (column, between) => places.reduceRight((kept, k) => (kept.splice(k, 0, between(k)), kept), column);
  return {
    x: parted(Array.from(time, (one) => one * factor), (k) => 0.5 * factor * (time[k - 1] + time[k])),
    ys: lines.map((line) => parted(store.column(line.series, line.column), () => null)),
  };
}

// Outputs in a text of `packed` in page.py: {time [s], values of each of the store's series, output after output}.
async function unpacked(text, store) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const content = await new Response(stream).arrayBuffer();
  let place = 0;
  const numbers = (count) => new Float64Array(content.slice(place, (place += 8 * count)));
  const [count] = numbers(1), time = numbers(count), values = {};
  for (const { name, width } of store.series.values()) {
    const low = numbers(width), high = numbers(width), size = count * width;
    const bytes = new Uint8Array(content, place, 2 * size), found = (values[name] = new Float32Array(size));
    place += 2 * size;
    for (let column = 0, k = 0; column < width; column++) {
      const step = (high[column] - low[column]) / STEPS;
      for (let frame = 0, whole = 0; frame < count; frame++, k++) {
        whole = (whole + bytes[k] + 256 * bytes[size + k]) & 65535;
        found[frame * width + column] = whole === MISSING ? NaN : low[column] + step * whole;
      }
    }
  }
  return { time, values };
}
