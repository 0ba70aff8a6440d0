"use strict";
// Elements of the page, and numbers as people read them. Texts of a document are set as text, never as markup.

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  setAll(element, attributes);
  element.append(...children);
  return element;
}

function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  setAll(element, attributes);
  element.append(...children);
  return element;
}

function setAll(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value);
  }
}

const $ = (id) => document.getElementById(id);

// [factor, unit with prefix] that make numbers up to `size` readable; `prefixes` as [prefix, scale], greatest first.
function prefixed(size, unit, prefixes) {
  const rows = prefixes && prefixes.length ? prefixes : [["", 1.0]];
  if (!(size > 0.0) || !Number.isFinite(size) || !unit) return [1.0, unit || ""];
  const found = rows.find(([, scale]) => size >= scale) || rows[rows.length - 1];
  return [1.0 / found[1], found[0] + unit];
}

// Factor and unit of times up to `size` seconds.
const timed = (size) => prefixed(Math.abs(size) || 1e-12, "s", [["", 1.0], ["m", 1e-3], ["µ", 1e-6], ["n", 1e-9]]);

function digits(value, count = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(count - 1) : Number(value.toPrecision(count)).toString();
  return text.replace("-", "−");
}

// A number with its unit, as 4.21 GPa.
function withUnit(value, series, count = 4) {
  const [factor, unit] = prefixed(Math.abs(value), series.unit, series.prefixes);
  return `${digits(value * factor, count)}${unit ? " " + unit : ""}`;
}

// The greatest of 1, 2, 5, 10, 20 ... that is not above `value`, at least 1.
function roundedDown(value) {
  if (!(value > 1.0) || !Number.isFinite(value)) return 1;
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * ([5, 2].find((one) => one * decade <= value) || 1);
}

const once = (text) => [...new Set(text)];
