/** Who is there and who holds control; and the log of events. */

import { byId, make, write } from "./dom.js";

const LOG_LENGTH = 200;
const SEVERITIES = ["info", "hold", "fault", "stop"];
const MARKS = ["\u2022", "\u2016", "\u25b2", "\u2b22"]; // a shape for each severity

/** Who holds control. */
export class People {
  /** @param {(message: object) => void} send */
  constructor(send) {
    this.send = send;
    byId("take").addEventListener("click", () => send({ type: "control", action: "take" }));
    byId("release").addEventListener("click", () => send({ type: "control", action: "release" }));
  }

  /** @param {{you: number, holder: number | null, mine: boolean, clients: Array<{id: number, name: string}>}} control */
  update({ you, holder, mine, clients }) {
    document.body.dataset.mine = String(mine);
    const who = mine ? "You control the arm" : holder === null ? "Nobody controls the arm" : `Person ${holder} controls the arm`;
    write(byId("holder"), who);
    button("take", !mine, holder === null, holder === null ? "" : "only its holder can release or give it");
    button("release", mine, true, "");
    byId("clients").replaceChildren(...clients.map((client) => this.#row(client, you, holder, mine)));
  }

  #row({ id, name }, you, holder, mine) {
    const role = id === holder ? "controls" : "watches";
    const row = make("li", {}, make("span", {}, `Person ${id}${id === you ? " (you)" : ""}: ${role}${name && id === holder ? ` with ${name}` : ""}`));
    if (mine && id !== you) {
      const give = make("button", { type: "button" }, "Give control");
      give.addEventListener("click", () => this.send({ type: "control", action: "give", to: id }));
      row.append(give);
    }
    return row;
  }
}

/**
 * @param {string} id
 * @param {boolean} shown
 * @param {boolean} enabled
 * @param {string} title
 */
function button(id, shown, enabled, title) {
  const element = /** @type {HTMLButtonElement} */ (byId(id));
  element.hidden = !shown;
  element.disabled = !enabled;
  element.title = title;
}

/** What has happened, newest first. */
export class Log {
  constructor() {
    this.list = byId("log");
    this.time = 0; // simulated [s]
  }

  /**
   * @param {string} words
   * @param {number} [severity] 0 said only, 1 hold, 2 fault, 3 emergency stop
   * @param {string} [side]
   * @param {number} [t] [s]
   */
  add(words, severity = 0, side = "console", t = this.time) {
    const row = make(
      "li",
      { class: SEVERITIES[severity] ?? "info" },
      make("time", {}, `${t.toFixed(1)} s`),
      make("span", { class: "log-mark", "aria-hidden": "true" }, MARKS[severity] ?? MARKS[0]),
      make("span", { class: "log-side" }, side),
      make("span", { class: "log-words" }, words),
    );
    this.list.prepend(row);
    while (this.list.childElementCount > LOG_LENGTH) this.list.lastElementChild?.remove();
  }
}
