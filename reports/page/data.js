"use strict";
// What the page's data blocks hold, and small helpers. Names from outside reach the page through textContent only.

function readBlock(element) {
  return JSON.parse(element.textContent);
}

// The signal that reports/packed.h wrote; NaN where there is no number.
function unpack(packed) {
  if (packed === null) return null;
  if (Array.isArray(packed)) return packed.map((v) => (v === null ? NaN : v));
  let sum = 0;
  return packed.d.map((d) => (d === null ? NaN : packed.from + packed.step * (sum += d)));
}

// Index of the last instant that is not after `t`; 0 before the first.
function indexAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}

// Linear in between, level outside; NaN beside a gap.
function valueAt(times, values, t) {
  const i = indexAt(times, t);
  if (i + 1 >= times.length || t <= times[i]) return values[i];
  const share = (t - times[i]) / (times[i + 1] - times[i]);
  return share === 0 ? values[i] : values[i] + share * (values[i + 1] - values[i]);
}

function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

function largest(values) {
  return values.reduce((most, v) => (Number.isFinite(v) ? Math.max(most, Math.abs(v)) : most), 0);
}

// Four digits, with a true minus sign.
function formatted(value, digits = 4) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  const [mantissa, power] = value.toExponential(digits - 1).split("e").map(Number);
  const words = size !== 0 && (size < 1e-3 || size >= 1e5) ? `${mantissa}e${power}` : String(Number(value.toPrecision(digits)));
  return words.replace(/-/g, "\u2212");
}

function superscript(exponent) {
  return String(exponent).replace(/./g, (c) => (c === "-" ? "\u207b" : "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[c]));
}

function axisTitle(label, unit, exponent) {
  const scale = (exponent ? `10${superscript(exponent)} ` : "") + unit;
  return [label, scale.trim()].filter((part) => part !== "").join(", ");
}

function makeElement(tag, className = "", words = "") {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (words) element.textContent = words;
  return element;
}

// A colour of the style sheet, as it is now: light or dark.
function themeColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function onThemeChange(action) {
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", action);
}
