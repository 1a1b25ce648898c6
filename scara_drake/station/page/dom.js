/** Small helpers for the page's elements. */

/**
 * The element of an id.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element "${id}"`);
  return element;
}

/**
 * Write a text, if it is another: what a screen reader announces must not repeat itself.
 * @param {Element} element
 * @param {string} text
 */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * Make an element.
 * @param {string} tag
 * @param {Record<string, string>} [attributes]
 * @param {...(Node | string)} children
 * @returns {HTMLElement}
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/**
 * A number in words, or a dash where it is not known.
 * @param {number | null | undefined} value
 * @param {number} digits behind the point
 * @param {string} [unit]
 */
export function told(value, digits, unit = "") {
  if (value === null || value === undefined || !Number.isFinite(value)) return "-";
  return value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1") + (unit && `\u202f${unit}`);
}

/**
 * Seconds as milliseconds.
 * @param {number | null | undefined} seconds
 */
export function toldMilliseconds(seconds) {
  return told(seconds === null || seconds === undefined ? null : 1000 * seconds, 0, "ms");
}

/**
 * @param {number} value
 * @param {number} low
 * @param {number} high
 */
export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}
