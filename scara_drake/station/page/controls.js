/** Buttons, sliders, what the stick does, and the whole screen. */

import { byId, clamp, make, told, write } from "./dom.js";
import { GAMEPAD_HELP } from "./gamepad.js";
import { KEYBOARD_HELP } from "./keyboard.js";

const HELP = { gamepad: GAMEPAD_HELP, keyboard: KEYBOARD_HELP, touch: "drag the stick and the lift, hold to engage" };
const SETTING_PERIOD = 100; // between two values of a slider that is dragged [ms]
const LABELS = {
  delay_up: "Delay up",
  delay_down: "Delay down",
  force_scale: "Force",
  motion_scale: "Motion",
  gain_scale: "Gains",
};

/** Buttons that act in the moment they are pressed, and what is held and moved. */
export class Buttons {
  /** @param {import("./input.js").OperatorInput} input */
  constructor(input) {
    for (const name of ["hold", "reset", "estop"]) {
      const button = byId(name);
      button.addEventListener("pointerdown", () => input.press(name));
      button.addEventListener("click", () => input.press(name)); // Enter, or a screen reader
    }
    input.addEventListener("input", () => this.#show(input));
  }

  /** @param {import("./input.js").OperatorInput} input */
  #show(input) {
    const { axes, buttons } = input.reading;
    for (const name of ["engage", "clutch", "hold", "reset", "estop"]) {
      byId(name).classList.toggle("down", buttons[name] === true);
    }
    for (const name of ["engage", "clutch"]) {
      byId(name).setAttribute("aria-pressed", String(buttons[name] === true));
    }
    move(byId("stick"), axes[0], axes[1]);
    move(byId("lift"), 0, -axes[2]);
    const { active, words, mine, blocked } = input;
    const again = blocked ? "let engage go, then press it anew" : "engage anew";
    const why = words && mine ? `${words}: ${again}` : HELP[active.kind];
    const watching = "You watch. Take control to operate the arm";
    write(byId("source"), mine ? `${capital(active.name)}. ${capital(why)}` : watching);
    document.body.dataset.source = active.kind;
  }
}

/** @param {string} text */
function capital(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/**
 * Put the knob of a stick where it is, -1 to 1.
 * @param {HTMLElement} stick
 * @param {number} x
 * @param {number} y
 */
function move(stick, x, y) {
  stick.style.setProperty("--x", clamp(x, -1, 1).toFixed(3));
  stick.style.setProperty("--y", clamp(y, -1, 1).toFixed(3));
}

/** Sliders of what may be changed during a run. */
export class Settings {
  /** @param {(message: object) => void} send */
  constructor(send) {
    this.send = send;
    /** @type {Map<string, {slider: HTMLInputElement, number: Element, unit: string, sent: number, timer: number}>} */
    this.rows = new Map();
  }

  /** @param {Array<{name: string, words: string, unit: string, lower: number, upper: number, value: number}>} facts */
  build(facts) {
    this.rows.clear();
    byId("settings").replaceChildren(...facts.map((fact) => this.#row(fact)));
  }

  #row({ name, words, unit, lower, upper, value }) {
    const slider = /** @type {HTMLInputElement} */ (
      make("input", { type: "range", id: `set-${name}`, min: `${lower}`, max: `${upper}`, step: "0.01", title: words })
    );
    slider.value = String(value);
    const number = make("output", { class: "number", for: slider.id });
    const row = { slider, number, unit, sent: -Infinity, timer: 0 };
    slider.addEventListener("input", () => this.#change(name, row));
    slider.addEventListener("dblclick", () => {
      slider.value = String(value); // as at the start
      this.#change(name, row);
    });
    this.rows.set(name, row);
    this.#tell(row);
    const label = make("label", { for: slider.id, title: words }, LABELS[name] ?? words);
    return make("div", { class: "setting" }, label, slider, number);
  }

  #change(name, row) {
    this.#tell(row);
    clearTimeout(row.timer);
    const send = () => {
      row.sent = performance.now();
      this.send({ type: "setting", name, value: row.slider.valueAsNumber });
    };
    row.timer = setTimeout(send, Math.max(0, row.sent + SETTING_PERIOD - performance.now()));
    row.touched = performance.now();
  }

  #tell({ slider, number, unit }) {
    const value = slider.valueAsNumber;
    write(number, unit === "s" ? told(1000 * value, 0, "ms") : `\u00d7\u202f${value.toFixed(2)}`);
    slider.setAttribute("aria-valuetext", number.textContent ?? "");
    const share = (value - Number(slider.min)) / (Number(slider.max) - Number(slider.min));
    slider.style.setProperty("--share", share.toFixed(3));
  }

  /**
   * Show what holds; a slider that has just been moved is left alone.
   * @param {Record<string, number>} values
   */
  update(values) {
    for (const [name, row] of this.rows) {
      const settled = performance.now() - (row.touched ?? -Infinity) > 1000;
      if (!settled || values[name] === undefined) continue;
      if (Math.abs(row.slider.valueAsNumber - values[name]) < 0.006) continue;
      row.slider.value = String(values[name]);
      this.#tell(row);
    }
  }

  /** @param {boolean} on */
  enable(on) {
    for (const { slider } of this.rows.values()) slider.disabled = !on;
  }
}

/**
 * The buttons of the camera, and whether pictures are delayed as the force is.
 * @param {Array<import("./views.js").CameraView>} views
 * @param {boolean} delayed
 * @param {(view: import("./views.js").CameraView) => void} choose
 * @param {(message: object) => void} send
 */
export function buildViews(views, delayed, choose, send) {
  const buttons = views.map((view, index) => {
    const button = make("button", { type: "button", title: `key: ${index + 1}` }, capital(view.name));
    button.addEventListener("click", () => {
      for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
      choose(view);
    });
    return button;
  });
  const late = make("button", { type: "button", class: "delayed", title: "pictures as old as the force that you feel" });
  const show = () => {
    late.setAttribute("aria-pressed", String(delayed));
    write(late, delayed ? "Delayed" : "Not delayed");
  };
  late.addEventListener("click", () => {
    delayed = !delayed;
    send({ type: "view", delayed });
    show();
  });
  show();
  byId("views").replaceChildren(...buttons, late);
  buttons[0]?.click();
}

/**
 * The whole screen. Where the browser keeps Escape for itself, leaving by it is an emergency stop.
 * @param {() => void} stop
 */
export function setUpFullscreen(stop) {
  const button = byId("fullscreen");
  let asked = false;
  button.addEventListener("click", async () => {
    asked = true;
    if (document.fullscreenElement) return document.exitFullscreen();
    await document.documentElement.requestFullscreen?.();
    return navigator.keyboard?.lock?.(["Escape"]).catch(() => {});
  });
  document.addEventListener("fullscreenchange", () => {
    const full = document.fullscreenElement !== null;
    if (!full && !asked) stop();
    asked = false;
    button.setAttribute("aria-pressed", String(full));
    write(button, full ? "Leave full screen" : "Full screen");
  });
}

/** Keys 1 to 9 choose a camera, 0 the whole screen. */
export function setUpKeys() {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const digit = /^Digit(\d)$/.exec(event.code)?.[1];
    if (digit === "0") byId("fullscreen").click();
    else if (digit) byId("views").querySelectorAll("button")[Number(digit) - 1]?.click();
  });
}
