/** The operator's station: connects what the server says to the panels, and the sources to it. */

import { Connection } from "./connection.js";
import { Buttons, Settings, buildViews, setUpFullscreen, setUpKeys } from "./controls.js";
import { byId, write } from "./dom.js";
import { GamepadSource } from "./gamepad.js";
import { OperatorInput } from "./input.js";
import { KeyboardSource } from "./keyboard.js";
import { Log, People } from "./people.js";
import { Plots } from "./plots.js";
import { Scene } from "./scene.js";
import { StatusPanel } from "./status.js";
import { TouchSource } from "./touch.js";

const connection = new Connection();
const send = (message) => connection.send(message);
const log = new Log();
const [scene, plots, status] = [new Scene(send), new Plots(), new StatusPanel()];
const [settings, people] = [new Settings(send), new People(send)];
const [pad, keyboard, touch] = [new GamepadSource(), new KeyboardSource(), new TouchSource()];
const fingers = matchMedia("(pointer: coarse)").matches;
const input = new OperatorInput(send, fingers ? [pad, touch, keyboard] : [pad, keyboard, touch]);
new Buttons(input);

/**
 * What hangs over everything, or nothing.
 * @param {string} [title]
 * @param {string} [words]
 */
function banner(title = "", words = "") {
  write(byId("banner-title"), title);
  write(byId("banner-words"), words);
  byId("banner").hidden = title === "";
}

/** @param {any} control */
function control(control) {
  people.update(control);
  input.control(control.mine);
  for (const button of document.querySelectorAll(".operate button")) button.disabled = !control.mine;
  settings.enable(control.mine);
  if (!control.mine) pad.rumble(0, 0);
}

/**
 * @param {string} type
 * @param {(detail: any) => void} callback
 */
function on(type, callback) {
  connection.addEventListener(type, (event) => callback(/** @type {CustomEvent} */ (event).detail));
}

on("hello", (hello) => {
  banner();
  document.body.dataset.online = "true";
  document.title = `${hello.scenario} - scara_drake station`;
  write(byId("scenario"), hello.scenario);
  scene.clear();
  plots.clear();
  status.build(hello);
  settings.build(hello.settings);
  buildViews(hello.views, hello.delayed, (view) => scene.camera?.choose(view), send);
  control(hello.control);
  status.forget("STARTING", "the run is about to begin");
  log.add("connected");
});

on("telemetry", (telemetry) => {
  log.time = telemetry.t;
  status.update(telemetry);
  settings.update(telemetry.settings);
  plots.add(telemetry);
  if (input.mine) pad.rumble(telemetry.rumble[0], telemetry.rumble[1]);
});

on("picture", (picture) => scene.add(picture));
on("control", control);
on("event", (event) => {
  const remedy = event.remedy && event.severity > 0 ? ` - ${event.remedy}` : "";
  log.add(event.sentence + remedy, event.severity, event.side, event.t);
});
on("refused", ({ words }) => log.add(words, 1));

on("ended", ({ good, lines, files }) => {
  input.block("the run is over");
  byId("ended-title").textContent = good ? "The run is over" : "The run is over, and did not go well";
  byId("ended-lines").textContent = [...lines, ...files].join("\n");
  /** @type {HTMLDialogElement} */ (byId("ended")).showModal();
});

on("lost", (words) => {
  const known = document.body.dataset.online === "true";
  document.body.dataset.online = "false";
  input.block("the connection was lost");
  control({ you: -1, holder: null, mine: false, clients: [] });
  byId("take").disabled = true;
  if (connection.over) return status.forget("THE END", "the run is over");
  status.forget("NOT CONNECTED");
  banner("Connection lost", `${words}. The arm holds by itself.`);
  if (known) log.add("connection lost", 2);
});

on("silent", (silent) => {
  if (silent) input.block("the server is silent");
  banner(silent ? "The server is silent" : "", silent ? "What you see is old. The arm holds." : "");
});

input.addEventListener("notice", (event) => log.add(event.detail));

document.addEventListener("visibilitychange", () => {
  if (!document.hidden) return;
  keyboard.clear();
  touch.clear();
  pad.rumble(0, 0);
  input.block("this page was hidden");
});

addEventListener("pagehide", leave);
addEventListener("beforeunload", leave);

/** The page closes: nobody holds control any more. */
function leave() {
  input.block("");
  pad.rumble(0, 0);
  if (input.mine) send({ type: "control", action: "release" });
}

setUpFullscreen(() => input.press("estop"));
setUpKeys();
connection.open();
