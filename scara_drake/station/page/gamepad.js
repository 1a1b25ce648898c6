/**
 * A gamepad that the browser knows: its sticks and buttons, and its motors.
 *
 * It is looked for anew at every reading, because a page that was reloaded gets no
 * `gamepadconnected`. A control that stands far from its rest when it is first seen counts only
 * after it has been near: some triggers rest at -1.
 */

import { clamp } from "./dom.js";
import { atRest } from "./input.js";

const DEAD_ZONE = 0.08; // of a stick
const REST = 0.35; // a control that is nearer to 0 than this has been at rest
const RUMBLE_TIME = 150; // [ms], after which the motors stop by themselves
const RUMBLE_AGAIN = 90; // [ms] between two commands to the motors, unless they change
const RUMBLE_STEP = 0.02;

/**
 * What drives what, by the numbers of the W3C's "standard" layout. Stick back and stick right are
 * positive, as on the robot's side. `axis` is a stick, `button` a button or trigger; `sign` turns
 * it round; several entries of a command add up.
 */
export const MAPPING = {
  axes: [
    [{ axis: 0 }], // x: left stick
    [{ axis: 1 }], // y: left stick
    [{ axis: 3, sign: -1 }], // z: right stick, up is up
    [{ button: 7 }, { button: 6, sign: -1 }], // mast: right trigger up, left trigger down
    [{ button: 12 }, { button: 13, sign: -1 }], // mast: cross up and down
  ],
  orientation: [
    [], // roll
    [{ button: 15 }, { button: 14, sign: -1 }], // pitch: cross right and left
    [{ axis: 2 }], // yaw: right stick
  ],
  buttons: { engage: 5, clutch: 4, hold: 1, reset: 9, estop: 8, mast: 0 },
};

/** In words, for the page. */
export const GAMEPAD_HELP =
  "RB engages, LB clutch, B hold, Start reset, Back e-stop, A: the stick's up and down is the mast";

export class GamepadSource {
  constructor() {
    this.kind = "gamepad";
    /** @type {number | null} index of the pad in use */
    this.index = null;
    this.id = "";
    this.gone = false; // since the last reading
    /** @type {Set<string>} controls that have been at rest */
    this.rested = new Set();
    this.shaken = { low: 0, high: 0, at: -Infinity };
  }

  get name() {
    return this.id.replace(/\s*\(.*/, "") || "gamepad";
  }

  /** @returns {Gamepad | null} the pad in use, or the first one that is there */
  pad() {
    const pads = [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected);
    const same = pads.find((pad) => pad.index === this.index && pad.id === this.id);
    if (same) return same;
    const pad = pads.find((one) => one.mapping === "standard") ?? pads[0] ?? null;
    this.gone ||= this.index !== null;
    this.index = pad ? pad.index : null;
    if (pad) this.id = pad.id;
    this.rested.clear();
    return pad;
  }

  /** @returns {import("./input.js").Reading | null} null: there is none, or it was another before */
  read() {
    const pad = this.pad();
    const gone = this.gone;
    this.gone = false;
    if (!pad || gone) return null;
    const reading = atRest();
    reading.axes = MAPPING.axes.map((parts) => this.#sum(pad, parts));
    reading.orientation = MAPPING.orientation.map((parts) => this.#sum(pad, parts));
    for (const [name, index] of Object.entries(MAPPING.buttons)) {
      reading.buttons[name] = this.#pressed(pad, index);
    }
    return reading;
  }

  /**
   * @param {Gamepad} pad
   * @param {Array<{axis?: number, button?: number, sign?: number}>} parts
   */
  #sum(pad, parts) {
    const values = parts.map(({ axis, button, sign = 1 }) => {
      const raw = axis === undefined ? pad.buttons[button ?? -1]?.value : pad.axes[axis];
      return sign * this.#alive(axis === undefined ? `b${button}` : `a${axis}`, raw);
    });
    return clamp(values.reduce((sum, value) => sum + value, 0), -1, 1);
  }

  /**
   * The value of a control without its dead zone, 0 until it has been at rest.
   * @param {string} name
   * @param {number | undefined} raw
   */
  #alive(name, raw) {
    if (raw === undefined || !Number.isFinite(raw)) return 0;
    if (Math.abs(raw) < REST) this.rested.add(name);
    if (!this.rested.has(name) || Math.abs(raw) < DEAD_ZONE) return 0;
    return (Math.sign(raw) * (Math.min(Math.abs(raw), 1) - DEAD_ZONE)) / (1 - DEAD_ZONE);
  }

  /**
   * @param {Gamepad} pad
   * @param {number} index
   */
  #pressed(pad, index) {
    const down = pad.buttons[index]?.pressed ?? false;
    if (!down) this.rested.add(`p${index}`);
    return down && (this.rested.has(`p${index}`) || index === MAPPING.buttons.estop);
  }

  /**
   * Shake the motors for a short while; say it again to go on.
   * @param {number} low 0 to 1
   * @param {number} high 0 to 1
   */
  rumble(low, high) {
    const now = performance.now();
    const same = Math.max(Math.abs(low - this.shaken.low), Math.abs(high - this.shaken.high)) < RUMBLE_STEP;
    const resting = low === 0 && high === 0;
    if (same && (resting || now - this.shaken.at < RUMBLE_AGAIN)) return;
    this.shaken = { low, high, at: now };
    const effect = { startDelay: 0, duration: RUMBLE_TIME, strongMagnitude: low, weakMagnitude: high };
    this.pad()?.vibrationActuator?.playEffect("dual-rumble", effect)?.catch?.(() => {});
  }
}
