/**
 * What the operator does, from whichever source he uses, sent at a steady rate.
 *
 * One source is in use at a time: the one that he moved last, and while he engages, none other. A
 * source that disappears, a hidden page, a lost connection or lost control release the dead-man
 * button, and it counts again only after it has been let go.
 */

const PERIOD = 25; // between two messages [ms]
const BUSY = 0.15; // an axis beyond this is a source in use
const PULSE = 250; // how long such a button is down, however short its press [ms]
const ALWAYS = ["hold", "estop"]; // buttons that count from every source
const PULSED = ["hold", "reset", "estop"]; // buttons that nobody may miss

/**
 * What a source says: axes (5) and orientation (3) in [-1, 1], and the buttons that are down.
 * @typedef {{axes: number[], orientation: number[], buttons: Record<string, boolean>}} Reading
 */

/**
 * A keyboard, a gamepad, the screen. `read` returns null where it is not there.
 * @typedef {{kind: string, name: string, read: () => Reading | null}} Source
 */

/** @returns {Reading} of a source that nobody touches */
export function atRest() {
  return { axes: [0, 0, 0, 0, 0], orientation: [0, 0, 0], buttons: {} };
}

/** @param {Reading} reading */
function isBusy(reading) {
  const moved = [...reading.axes, ...reading.orientation].some((value) => Math.abs(value) > BUSY);
  return moved || Object.values(reading.buttons).some(Boolean);
}

export class OperatorInput extends EventTarget {
  /**
   * Events: "input" after every reading; "notice" with words, when something was released.
   * @param {(message: object) => void} send
   * @param {Source[]} sources the one that is to be in use first stands first
   */
  constructor(send, sources) {
    super();
    this.send = send;
    this.sources = sources;
    this.active = sources.find((source) => source.read() !== null) ?? sources[0];
    this.mine = false; // whether this page holds control
    this.blocked = true; // engage has to be let go first
    this.reading = atRest(); // as it was sent
    this.words = ""; // why engage was released
    /** @type {Map<string, number>} until when a button is down */
    this.pulses = new Map();
    setInterval(() => this.tick(), PERIOD);
    addEventListener("station-input", () => this.tick()); // a key or a finger: at once
  }

  /** @param {boolean} mine */
  control(mine) {
    if (mine === this.mine) return;
    this.mine = mine;
    this.block(""); // before and after
  }

  /**
   * Let go of the dead-man button, at once and until it is pressed anew.
   * @param {string} words why
   */
  block(words) {
    const held = this.reading.buttons.engage === true;
    this.blocked = true;
    this.words = words;
    this.tick();
    if (words && held) this.#tell("notice", `engage released: ${words}`);
  }

  /**
   * Press a button for a moment.
   * @param {string} name
   */
  press(name) {
    this.pulses.set(name, performance.now() + PULSE);
    this.tick();
  }

  /** Read all sources, and say what the one in use does. */
  tick() {
    const readings = new Map(this.sources.map((source) => [source, source.read()]));
    this.#choose(readings);
    const said = readings.get(this.active) ?? atRest();
    const buttons = { ...said.buttons };
    for (const reading of readings.values()) {
      for (const name of ALWAYS) if (reading?.buttons[name]) buttons[name] = true;
    }
    this.#prolong(buttons);
    if (!buttons.engage && !document.hidden) this.blocked = false;
    if (this.blocked || document.hidden) buttons.engage = false;
    if (buttons.engage) this.words = "";
    this.reading = { axes: [...said.axes], orientation: [...said.orientation], buttons };
    if (this.mine) this.send({ type: "input", ...this.reading, device: this.active.name });
    this.#tell("input", this.reading);
  }

  /**
   * Keep down what was pressed a moment ago.
   * @param {Record<string, boolean>} buttons
   */
  #prolong(buttons) {
    const now = performance.now();
    for (const name of PULSED) {
      if (buttons[name]) this.pulses.set(name, now + PULSE);
      buttons[name] = now < (this.pulses.get(name) ?? 0);
    }
  }

  /** @param {Map<Source, Reading | null>} readings */
  #choose(readings) {
    const mine = readings.get(this.active);
    const others = this.sources.filter((source) => source !== this.active && readings.get(source));
    if (!mine) {
      const lost = this.active.name;
      const engaged = this.reading.buttons.engage === true;
      this.active = others.find((source) => source.kind === "keyboard") ?? others[0] ?? this.active;
      this.blocked = true;
      this.words = `${lost} is gone`;
      this.#tell("notice", engaged ? `${lost} is gone: engage released` : `${lost} is gone`);
      return;
    }
    if (isBusy(mine)) return;
    const next = others.find((source) => isBusy(/** @type {Reading} */ (readings.get(source))));
    if (next) {
      this.active = next;
      this.#tell("notice", `input: ${next.name}`);
    }
  }

  /**
   * @param {string} type
   * @param {unknown} detail
   */
  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
