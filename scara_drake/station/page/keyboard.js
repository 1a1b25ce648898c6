/** The keyboard: keys that are held move the stick gently; Space is the dead-man button. */

import { atRest } from "./input.js";

const RAMP = 3.0; // of full travel, in a second
const FULL = 0.6; // what a held key asks for; with Shift all of it

/** Keys by their place on the keyboard, so that they are the same on every layout. */
const AXES = {
  KeyA: ["axes", 0, -1], // left
  KeyD: ["axes", 0, 1],
  KeyW: ["axes", 1, -1], // forward
  KeyS: ["axes", 1, 1],
  KeyF: ["axes", 2, -1], // down
  KeyR: ["axes", 2, 1],
  KeyG: ["axes", 3, -1], // mast down
  KeyT: ["axes", 3, 1],
  KeyQ: ["orientation", 2, 1], // yaw
  KeyE: ["orientation", 2, -1],
  KeyU: ["orientation", 0, -1], // roll
  KeyO: ["orientation", 0, 1],
  KeyI: ["orientation", 1, -1], // pitch
  KeyK: ["orientation", 1, 1],
};
const HELD = { Space: "engage", KeyC: "clutch", KeyM: "mast", KeyH: "hold", Backspace: "reset", Escape: "estop" };

/** In words, for the page. */
export const KEYBOARD_HELP =
  "W A S D moves, R F up and down, T G mast, Q E turns, Shift faster, Space engages";

export class KeyboardSource {
  constructor() {
    this.kind = "keyboard";
    this.name = "keyboard";
    /** @type {Set<string>} */
    this.down = new Set();
    this.reading = atRest();
    this.at = performance.now();
    addEventListener("keydown", (event) => this.#key(event, true));
    addEventListener("keyup", (event) => this.#key(event, false));
    addEventListener("blur", () => this.clear()); // the keyup goes to another window
  }

  /** No key is held. */
  clear() {
    this.down.clear();
    this.reading = atRest();
  }

  /**
   * @param {KeyboardEvent} event
   * @param {boolean} down
   */
  #key(event, down) {
    if (!(event.code in AXES) && !(event.code in HELD) && !event.code.startsWith("Shift")) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return this.clear();
    if (event.code === "Escape" && document.querySelector("dialog[open]")) return;
    // Space and Backspace would press the button that has the focus; Enter still does.
    if (event.code in HELD) event.preventDefault();
    if (down) this.down.add(event.code);
    else this.down.delete(event.code);
    if (!event.repeat) dispatchEvent(new Event("station-input"));
  }

  /** @returns {import("./input.js").Reading} */
  read() {
    const now = performance.now();
    const step = (RAMP * Math.min(now - this.at, 100)) / 1000;
    this.at = now;
    const wanted = this.#wanted();
    for (const part of ["axes", "orientation"]) {
      this.reading[part] = this.reading[part].map((value, index) => {
        const way = wanted[part][index] - value;
        return Math.abs(way) <= step ? wanted[part][index] : value + Math.sign(way) * step;
      });
    }
    this.reading.buttons = wanted.buttons;
    return this.reading;
  }

  #wanted() {
    const wanted = atRest();
    const full = this.down.has("ShiftLeft") || this.down.has("ShiftRight") ? 1 : FULL;
    for (const code of this.down) {
      if (code in HELD) wanted.buttons[HELD[code]] = true;
      if (!(code in AXES)) continue;
      const [part, index, sign] = AXES[code];
      wanted[part][index] += sign * full;
    }
    return wanted;
  }
}
