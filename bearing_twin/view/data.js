"use strict";
// The numbers of a page: every series at every output shown, unpacked from the document or appended while they come.

const MISSING = 65535, STEPS = 65534;
const LONGEST_LIVE = 4000; // outputs that are kept of a run that goes on
const GAP_FACTOR = 5.0; // so many times what is usual near it a stretch between two outputs is a gap
const NEIGHBOURS = 15, SKIPPED_SPANS = 2, LEAST_SPANS = 4; // how many are near, are longer than usual, say anything

class Store {
  constructor(descriptions) {
    this.series = new Map();
    for (const series of descriptions) {
      const width = series.shape.reduce((product, size) => product * size, 1);
      this.series.set(series.name, { ...series, width, values: new Float32Array(0) });
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

  value(name, frame, column = 0) {
    const series = this.series.get(name);
    return series.values[frame * series.width + column];
  }

  // Between two outputs; `index` is a number of frames with its fraction.
  between(name, index, column = 0) {
    const low = Math.min(Math.floor(index), this.count - 1), high = Math.min(low + 1, this.count - 1);
    const first = this.value(name, low, column), second = this.value(name, high, column);
    return first + (index - low) * (second - first);
  }

  column(name, column = 0) {
    const values = Array.from({ length: this.count }, (_, frame) => this.value(name, frame, column));
    return values.map((value) => (Number.isNaN(value) ? null : value));
  }

  // Greatest size among the numbers of a series, or of its vectors of `length` numbers.
  greatest(name, length = 1) {
    const { values, width } = this.series.get(name);
    let largest = 0.0;
    for (let first = 0; first + length <= this.count * width; first += length) {
      let square = 0.0;
      for (let k = 0; k < length; k++) square += values[first + k] ** 2;
      if (square > largest) largest = square;
    }
    return Math.sqrt(largest);
  }

  get first() {
    return this.count ? this.time[0] : 0.0;
  }

  get last() {
    return this.count ? this.time[this.count - 1] : 0.0;
  }

  // The index of a time among the outputs, with its fraction between two of them.
  indexOf(time) {
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

  // Takes in outputs behind those that are there, as of `unpack`; the oldest go where there are more than `limit`.
  append({ time, values }, limit) {
    const kept = Math.min(this.count, Math.max(0, limit - time.length)), dropped = this.count - kept;
    const joined = (old, added, width) => {
      const result = new old.constructor((kept + time.length) * width);
      result.set(old.subarray(dropped * width, this.count * width));
      result.set(added, kept * width);
      return result;
    };
    for (const series of this.series.values()) series.values = joined(series.values, values[series.name], series.width);
    this.time = joined(this.time, time, 1);
    this.count = this.time.length;
  }

  // Takes out the first `count` outputs, as `append` takes them in.
  take(count) {
    const values = {}, time = this.time.slice(0, count);
    for (const series of this.series.values()) {
      values[series.name] = series.values.slice(0, count * series.width);
      series.values = series.values.slice(count * series.width);
    }
    this.time = this.time.slice(count);
    this.count = this.time.length;
    return { time, values };
  }
}

// The outputs before which a stretch is missing: it lasts far longer than what lies between the outputs near it, of which
// one in each event of a live run is longer than the rest.
function gaps(time) {
  const span = (k) => time[k + 1] - time[k], gapIndices = [];
  const typical = (low, high) => {
    const spans = [];
    for (let k = Math.max(low, 0); k < Math.min(high, time.length - 1); k++) spans.push(span(k));
    return spans.length < LEAST_SPANS ? 0.0 : spans.sort((a, b) => b - a)[SKIPPED_SPANS];
  };
  for (let k = 0; k + 1 < time.length; k++) {
    // those before say it of nearly all outputs, quickly
    if (k && span(k) <= GAP_FACTOR * span(k - 1)) continue;
    const usualSpan = Math.max(typical(k - NEIGHBOURS, k), typical(k + 1, k + 1 + NEIGHBOURS));
    if (usualSpan > 0.0 && span(k) > GAP_FACTOR * usualSpan) gapIndices.push(k + 1);
  }
  return gapIndices;
}

// Curves over time [s] for Chart, with nothing where a stretch is missing: {x, ys}.
function curvesOf(store, lines, factor) {
  const { time } = store, breaks = gaps(time);
  const withBreaks = (column, value) => breaks.reduceRight((result, k) => (result.splice(k, 0, value(k)), result), column);
  return {
    x: withBreaks(Array.from(time, (t) => t * factor), (k) => 0.5 * factor * (time[k - 1] + time[k])),
    ys: lines.map((line) => withBreaks(store.column(line.series, line.column), () => null)),
  };
}

// Outputs in a text of `pack_series` in page.py: {time [s], values of each of the store's series, output after output}.
async function unpack(text, store) {
  const binary = atob(text), packed = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; k++) packed[k] = binary.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const content = await new Response(stream).arrayBuffer();
  let offset = 0;
  const numbers = (count) => new Float64Array(content.slice(offset, (offset += 8 * count)));
  const [count] = numbers(1), time = numbers(count), values = {};
  for (const { name, width } of store.series.values()) {
    const low = numbers(width), high = numbers(width), size = count * width;
    const bytes = new Uint8Array(content, offset, 2 * size), decoded = (values[name] = new Float32Array(size));
    offset += 2 * size;
    for (let column = 0, k = 0; column < width; column++) {
      const step = (high[column] - low[column]) / STEPS;
      for (let frame = 0, code = 0; frame < count; frame++, k++) {
        code = (code + bytes[k] + 256 * bytes[size + k]) & 65535;
        decoded[frame * width + column] = code === MISSING ? NaN : low[column] + step * code;
      }
    }
  }
  return { time, values };
}
