/** What the arm does and why not: state, reason, remedy, numbers and bars. */

import { byId, clamp, make, told, toldMilliseconds, write } from "./dom.js";

// From the one that stops most to the one that stops least.
const RANK = ["E-STOP", "FAULT", "HOLD", "IDLE", "CLUTCH", "ACTIVE"];
const SLOW = 0.95; // a real-time factor below it is told
const LATE = 0.001; // a p99 of lateness above it is told [s]
const NEAR_LIMIT = 0.03; // of a joint's range
const HIGH_EFFORT = 0.85;
const FORCE_STEPS = [20, 50, 100, 200, 300, 400, 600, 800, 1000, 1500, 2000, 3000, 5000, 10000]; // of the bar [N]

/**
 * @typedef {{state: number, name: string, reason: number, words: string, remedy: string}} Status
 */

/**
 * The supervisor that stops more; of two alike, the one that has a reason.
 * @param {Status} operator
 * @param {Status} robot
 * @returns {Status}
 */
export function decisive(operator, robot) {
  const [ours, its] = [operator, robot].map((status) => RANK.indexOf(status.name));
  if (ours !== its) return ours < its ? operator : robot;
  return operator.words || !robot.words ? operator : robot;
}

export class StatusPanel {
  constructor() {
    this.slowScene = 0.2; // [s]
    this.forceFull = FORCE_STEPS[0];
    /** @type {Array<{name: string, value: number}>} */
    this.marks = [];
    /** @type {Array<any>} */
    this.joints = [];
  }

  /** @param {any} hello */
  build(hello) {
    this.slowScene = hello.slow_scene;
    this.marks = hello.max_force === null ? [] : [{ name: "limit", value: hello.max_force }];
    this.#scaleForce(Math.max(FORCE_STEPS[0], ...this.marks.map((mark) => mark.value * 1.05)));
    this.joints = hello.joints.map(jointRow);
    byId("joints").replaceChildren(...this.joints.map((joint) => joint.row));
  }

  /** @param {any} telemetry */
  update(telemetry) {
    this.#state(telemetry.operator, telemetry.robot);
    this.#facts(telemetry);
    this.#force(telemetry.force_size);
    this.joints.forEach((joint, index) => {
      showJoint(joint, telemetry.q[index], telemetry.effort_share[index]);
    });
    write(byId("task"), telemetry.task);
    byId("task").hidden = !telemetry.task;
  }

  /**
   * Nothing is known of the arm.
   * @param {string} name
   * @param {string} [words]
   */
  forget(name, words = "") {
    this.#show("NONE", name, words, "");
    write(byId("side-operator"), "");
    write(byId("side-robot"), "");
  }

  /**
   * @param {Status} operator
   * @param {Status} robot
   */
  #state(operator, robot) {
    const shown = decisive(operator, robot);
    const shape = shown.name.replace("-", "");
    this.#show(shape, shown.name, shown.words, shown.remedy);
    write(byId("side-operator"), `your side: ${operator.name}`);
    write(byId("side-robot"), `robot: ${robot.name}`);
  }

  #show(shape, name, words, remedy) {
    document.body.dataset.state = shape;
    byId("state-shape").setAttribute("href", `#shape-${shape}`);
    write(byId("state"), name);
    write(byId("scene-state"), name);
    write(byId("reason"), words || FALLBACK[shape] || "");
    write(byId("remedy"), remedy || NEXT[shape] || "");
  }

  #facts({ t, realtime_factor: factor, late_ticks: late, p99, lag }) {
    write(byId("time"), told(t, 1, "s"));
    write(byId("realtime"), factor === null ? "-" : `${factor.toFixed(2)}\u202f\u00d7`);
    write(byId("late"), p99 === null ? `${late}` : `${late} (${toldMilliseconds(Math.max(p99, 0))})`);
    write(byId("lag"), toldMilliseconds(lag));
    byId("fact-realtime").classList.toggle("warn", factor !== null && factor < SLOW);
    byId("fact-late").classList.toggle("warn", p99 !== null && p99 > LATE);
    byId("fact-lag").classList.toggle("warn", lag !== null && lag > this.slowScene);
  }

  /** @param {number | null} size [N] */
  #force(size) {
    const newtons = size ?? 0;
    if (newtons > this.forceFull) this.#scaleForce(newtons);
    const bar = byId("force-bar");
    bar.style.setProperty("--share", clamp(newtons / this.forceFull, 0, 1).toFixed(4));
    bar.setAttribute("aria-valuenow", newtons.toFixed(1));
    const beyond = this.marks.filter((mark) => newtons >= mark.value).at(-1);
    bar.dataset.level = beyond ? beyond.name : "";
    bar.classList.toggle("beyond", beyond !== undefined && beyond === this.marks.at(-1));
    write(byId("force-size"), told(size, 1, "N"));
  }

  /** @param {number} largest that has to be on the bar [N] */
  #scaleForce(largest) {
    this.forceFull = FORCE_STEPS.find((step) => step >= largest) ?? largest;
    byId("force-bar").setAttribute("aria-valuemax", String(this.forceFull));
    const mark = ({ name, value }, kind) => {
      const element = make("span", { class: `mark ${kind}` }, name);
      element.style.setProperty("--at", (value / this.forceFull).toFixed(4));
      return element;
    };
    const scale = [0, 0.5, 1].map((share) => {
      const name = share === 1 ? `${this.forceFull} N` : `${share * this.forceFull}`;
      return mark({ name, value: share * this.forceFull }, share === 1 ? "scale last" : "scale");
    });
    const limits = this.marks.map((one) => mark(one, "limit"));
    byId("force-marks").replaceChildren(...(limits.length ? [scale[0], scale[2]] : scale), ...limits);
  }
}

// What to say where the supervisor has no words.
const FALLBACK = {
  IDLE: "nobody has engaged: the arm stands where it is",
  ACTIVE: "the arm follows the operator",
  CLUTCH: "the stick moves alone",
};
const NEXT = { IDLE: "hold the engage button" };

/** @param {any} facts of a joint */
function jointRow(facts) {
  const position = make("div", { class: "bar range", role: "meter", "aria-label": `position of ${facts.name}` }, make("span", { class: "pin" }));
  const effort = make("div", { class: "bar effort", role: "meter", "aria-label": `effort of ${facts.name}` }, make("span", { class: "fill" }));
  position.setAttribute("aria-valuemin", String(facts.lower));
  position.setAttribute("aria-valuemax", String(facts.upper));
  effort.setAttribute("aria-valuemin", "-100");
  effort.setAttribute("aria-valuemax", "100");
  const [value, share] = [make("output", { class: "number" }), make("output", { class: "number" })];
  const cell = (content, kind) => make("td", { class: kind }, content);
  const name = make("th", { scope: "row" }, facts.name.replace("theta", "\u03b8"));
  const row = make("tr", {}, name, cell(position, "wide"), cell(value, "figure"), cell(effort, "wide"), cell(share, "figure"));
  return { facts, row, position, value, effort, share };
}

/**
 * @param {any} joint of `jointRow`
 * @param {number | null} q [m, rad]
 * @param {number | null} effort share of the limit
 */
function showJoint(joint, q, effort) {
  const { lower, upper, unit } = joint.facts;
  const share = q === null ? 0.5 : clamp((q - lower) / (upper - lower), 0, 1);
  joint.position.style.setProperty("--share", share.toFixed(4));
  joint.position.setAttribute("aria-valuenow", String(q ?? 0));
  joint.position.classList.toggle("warn", Math.min(share, 1 - share) < NEAR_LIMIT);
  write(joint.value, unit === "rad" ? told(q === null ? null : (q * 180) / Math.PI, 0, "\u00b0") : told(q, 2, unit));
  const level = clamp(effort ?? 0, -1, 1);
  joint.effort.style.setProperty("--share", level.toFixed(4));
  joint.effort.style.setProperty("--size", Math.abs(level).toFixed(4));
  joint.effort.setAttribute("aria-valuenow", (100 * level).toFixed(0));
  joint.effort.classList.toggle("negative", level < 0);
  joint.effort.classList.toggle("warn", Math.abs(level) > HIGH_EFFORT);
  write(joint.share, effort === null ? "-" : told(100 * Math.abs(effort), 0, "%"));
}
