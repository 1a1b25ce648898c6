/** The screen: a stick and a lift to drag, and buttons that are held, by finger, pen or mouse. */

import { byId, clamp } from "./dom.js";
import { atRest } from "./input.js";

/** Say at once that something has changed. */
function changed() {
  dispatchEvent(new Event("station-input"));
}

/**
 * Call back while a pointer is down on an element, and once more with null when it is not.
 * @param {HTMLElement} element
 * @param {(event: PointerEvent | null) => void} callback
 */
function whileDown(element, callback) {
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    try {
      element.setPointerCapture(event.pointerId); // it stays ours outside of the element
    } catch {
      // the pointer is already gone
    }
    callback(event);
    changed();
  });
  element.addEventListener("pointermove", (event) => {
    if (element.hasPointerCapture(event.pointerId)) callback(event);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    element.addEventListener(end, () => {
      callback(null);
      changed();
    });
  }
  element.addEventListener("contextmenu", (event) => event.preventDefault()); // of a long press
}

/**
 * Where a pointer is in an element, from -1 to 1, right and down.
 * @param {HTMLElement} element
 * @param {PointerEvent} event
 * @returns {[number, number]}
 */
function place(element, event) {
  const box = element.getBoundingClientRect();
  const along = (at, start, size) => clamp((2.4 * (at - start)) / size - 1.2, -1, 1);
  return [along(event.clientX, box.left, box.width), along(event.clientY, box.top, box.height)];
}

export class TouchSource {
  constructor() {
    this.kind = "touch";
    this.name = "the screen";
    this.reading = atRest();
    const stick = byId("stick");
    const lift = byId("lift");
    whileDown(stick, (event) => {
      const [x, y] = event ? place(stick, event) : [0, 0];
      this.reading.axes.splice(0, 2, x, y);
    });
    whileDown(lift, (event) => {
      this.reading.axes[2] = event ? -place(lift, event)[1] : 0;
    });
    for (const name of ["engage", "clutch"]) this.#holds(byId(name), name);
  }

  /** Nothing is touched. */
  clear() {
    this.reading = atRest();
  }

  /**
   * A button that counts while it is held, by a pointer or by Enter.
   * @param {HTMLElement} button
   * @param {string} name
   */
  #holds(button, name) {
    const set = (down) => {
      this.reading.buttons[name] = down;
    };
    whileDown(button, (event) => set(event !== null));
    button.addEventListener("keydown", (event) => event.key === "Enter" && set(true));
    button.addEventListener("keyup", (event) => event.key === "Enter" && set(false));
    button.addEventListener("blur", () => set(false));
  }

  /** @returns {import("./input.js").Reading} */
  read() {
    return this.reading;
  }
}
