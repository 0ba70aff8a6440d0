"use strict";
// Elements of the page, numbers with units, and colours. Texts of a document are set as text, never as markup.

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
  const text = size >= 1e6 || size < 1e-4 ? Number(value.toPrecision(count)).toExponential() : Number(value.toPrecision(count)).toString();
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

const SHADES = {
  steel: [196, 204, 212], dark: [92, 102, 112], brass: [214, 176, 92], blue: [40, 128, 206], orange: [230, 118, 30],
  green: [28, 158, 116], red: [214, 64, 62], glass: [170, 196, 216],
};
const SCALE = [[28, 16, 68], [94, 23, 110], [159, 42, 99], [212, 72, 66], [245, 125, 21], [250, 193, 39], [252, 255, 164]];

THREE.ColorManagement.enabled = false;

const tone = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// A colour of a curve or a body; black would not be seen on a dark ground.
function curveColour(number, palette) {
  const colour = palette[number % palette.length];
  return colour === "#000000" ? tone("ink") : colour;
}

const curveDash = (number, palette) => [[], [6, 3], [2, 3], [8, 3, 2, 3]][Math.floor(number / palette.length) % 4];

// Red, green, blue from 0 to 1 of a share from 0 to 1.
function scaleColour(share) {
  const place = Math.min(Math.max(share || 0.0, 0.0), 1.0) * (SCALE.length - 1);
  const low = Math.min(Math.floor(place), SCALE.length - 2), part = place - low;
  return SCALE[low].map((one, k) => (one + part * (SCALE[low + 1][k] - one)) / 255.0);
}

const scaleText = (share) => `rgb(${scaleColour(share).map((one) => Math.round(255 * one)).join(",")})`;
const scaleGradient = () => `linear-gradient(to right, ${SCALE.map((_, k) => scaleText(k / (SCALE.length - 1))).join(",")})`;

const shadeTextures = new Map();

// Texture of a ball of this shade in the ambient light, a texture by the direction of the surface.
function shadeTexture(name) {
  if (shadeTextures.has(name)) return shadeTextures.get(name);
  const size = 128, base = SHADES[name] || SHADES.steel, metal = name === "steel" || name === "brass" || name === "dark";
  const canvas = make("canvas", { width: size, height: size });
  const context = canvas.getContext("2d"), image = context.createImageData(size, size);
  for (let row = 0; row < size; row++) {
    for (let column = 0; column < size; column++) {
      let x = (2.0 * column + 1.0) / size - 1.0, y = 1.0 - (2.0 * row + 1.0) / size;
      const far = Math.hypot(x, y);
      if (far > 0.99) [x, y] = [(x / far) * 0.99, (y / far) * 0.99];
      const z = Math.sqrt(1.0 - x * x - y * y);
      const light = Math.max(0.0, -0.42 * x + 0.62 * y + 0.66 * z), low = Math.max(0.0, 0.5 * x - 0.6 * y + 0.3 * z);
      const gleam = Math.max(0.0, -0.26 * x + 0.38 * y + 0.89 * z) ** (metal ? 38 : 22);
      const horizon = metal ? 0.16 * Math.exp(-(((y + 0.18 + 0.15 * x) / 0.17) ** 2)) : 0.0;
      const shade = 0.3 + 0.66 * light + 0.14 * low - horizon;
      const place = 4 * (row * size + column);
      for (let k = 0; k < 3; k++) image.data[place + k] = Math.min(255, base[k] * shade + 150 * gleam);
      image.data[place + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = "";
  texture.generateMipmaps = false;
  texture.minFilter = THREE.LinearFilter;
  shadeTextures.set(name, texture);
  return texture;
}

function shaded(name, more = {}) {
  return new THREE.MeshMatcapMaterial({ matcap: shadeTexture(name), ...more });
}
