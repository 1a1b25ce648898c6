/** The last seconds of force, error and delay, by uPlot. */

import { byId, make, told, write } from "./dom.js";

const SPAN = 10; // [s] of simulated time
const PERIOD = 100; // between two pictures [ms]
const CURVES = [
  { name: "force", unit: "N", digits: 1, color: "#ff9d5c", least: 5, of: (t) => t.force_size },
  { name: "tool error", unit: "mm", digits: 1, color: "#b79cff", least: 2, of: (t) => scaled(t.tool_error) },
  { name: "delay, there and back", unit: "ms", digits: 0, color: "#5cc8ff", least: 20, of: (t) => scaled(roundTrip(t)) },
];

/** @param {number | null} value in m or s */
function scaled(value) {
  return value === null ? null : 1000 * value;
}

/** @param {{delay_up: number | null, delay_down: number | null}} t */
function roundTrip(t) {
  return t.delay_up === null && t.delay_down === null ? null : (t.delay_up ?? 0) + (t.delay_down ?? 0);
}

export class Plots {
  constructor() {
    this.place = byId("plots");
    /** @type {number[]} */
    this.times = [];
    this.curves = CURVES.map((curve) => this.#make(curve));
    this.changed = false;
    setInterval(() => this.#draw(), PERIOD);
    new ResizeObserver(() => this.#fit()).observe(this.place);
  }

  /** Forget everything: another run, or another connection. */
  clear() {
    this.times.length = 0;
    for (const { values } of this.curves) values.length = 0;
    this.changed = true;
  }

  /** @param {any} telemetry */
  add(telemetry) {
    const last = this.times.at(-1);
    if (last !== undefined && telemetry.t <= last) return; // the simulation stands still
    this.times.push(telemetry.t);
    for (const curve of this.curves) curve.values.push(curve.of(telemetry));
    const old = this.times.findIndex((time) => time >= telemetry.t - SPAN);
    this.times.splice(0, old);
    for (const curve of this.curves) curve.values.splice(0, old);
    this.changed = true;
  }

  #make(curve) {
    const number = make("output", { class: "number" }, "-");
    const box = make("div", { class: "plot-box" });
    const head = make("div", { class: "row-head" }, make("h2", {}, curve.name), number);
    this.place.append(make("figure", { class: "plot", "aria-label": curve.name }, head, box));
    const axis = {
      stroke: "#8fa1b3",
      font: "11px system-ui, sans-serif",
      grid: { stroke: "#22303d", width: 1 },
      ticks: { show: false },
    };
    const options = {
      width: 200,
      height: 90,
      legend: { show: false },
      cursor: { show: false },
      padding: [6, 8, 0, 0],
      scales: { x: { time: false }, y: { range: (_, __, high) => [0, Math.max(1.15 * (high ?? 0), curve.least)] } },
      axes: [
        { ...axis, size: 18, gap: 2, space: 40, values: (_, ticks) => ticks.map((tick) => `${tick}`) },
        { ...axis, size: 38, gap: 4, space: 24 },
      ],
      series: [{}, { stroke: curve.color, width: 1.6, fill: `${curve.color}22`, points: { show: false } }],
    };
    return { ...curve, values: [], number, box, plot: new globalThis.uPlot(options, [[], []], box) };
  }

  #fit() {
    for (const { box, plot } of this.curves) {
      const { clientWidth: width, clientHeight: height } = box;
      if (width > 0 && height > 0) plot.setSize({ width, height });
    }
  }

  #draw() {
    if (!this.changed || document.hidden) return;
    this.changed = false;
    const end = this.times.at(-1) ?? 0;
    for (const { plot, values, number, digits, unit } of this.curves) {
      plot.batch(() => {
        plot.setData([this.times, values], true);
        plot.setScale("x", { min: end - SPAN, max: end });
      });
      write(number, told(values.at(-1), digits, unit));
    }
  }
}
