/**
 * The Meshcat scene, fed by the server picture by picture.
 *
 * It is drawn only when something is new, and a picture is answered when it is on the screen: so
 * the server knows how much this page can draw, and sends no more.
 */

import { byId } from "./dom.js";
import { Camera } from "./views.js";

const MAX_PIXELS = 1.5; // of the screen for one of the page, on a graphics card
const SOFTWARE = /swiftshader|llvmpipe|software/i;
// A command with a script in it is not for this page, and the camera and the sky are its own.
const COMMANDS = new Set(["set_object", "set_transform", "set_property", "delete"]);
const OWN = /^\/?(Axes|Background|Cameras|Lights|Render Settings)\b/;
const SKY = { top_color: [0.1, 0.135, 0.175], bottom_color: [0.27, 0.33, 0.4] };
const LIGHTS = { SpotLight: 30, PointLightNegativeX: 22, PointLightPositiveX: 22, AmbientLight: 0.45, FillLight: 0.6 };

export class Scene {
  /** @param {(message: object) => void} send */
  constructor(send) {
    this.send = send;
    /** @type {ArrayBuffer[]} pictures that are not drawn yet */
    this.waiting = [];
    /** @type {number[]} frames that were drawn and are not on the screen yet */
    this.drawn = [];
    this.place = byId("scene");
    this.viewer = this.#makeViewer();
    this.camera = this.viewer && new Camera(this.viewer);
    if (!this.viewer) return;
    new ResizeObserver(() => this.#fit()).observe(this.place);
    requestAnimationFrame(() => this.#animate());
  }

  /** @param {ArrayBuffer} picture */
  add(picture) {
    if (this.viewer) this.waiting.push(picture);
    else this.send({ type: "drawn", frame: new DataView(picture).getUint32(0, true) });
  }

  /** A new connection sends the whole scene anew. */
  clear() {
    this.waiting = [];
    this.drawn = [];
    if (this.viewer?.scene_tree.children.drake) this.viewer.delete_path(["drake"]);
  }

  #makeViewer() {
    const { THREE, Viewer } = globalThis.MeshCat ?? {};
    try {
      const renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: "high-performance" });
      const software = SOFTWARE.test(graphics(renderer.getContext()));
      this.place.append(renderer.domElement);
      const viewer = new Viewer(this.place, false, renderer);
      viewer.gui.domElement.remove(); // its folders of everything are not for an operator
      renderer.setPixelRatio(software ? 1 : Math.min(devicePixelRatio, MAX_PIXELS));
      for (const [name, color] of Object.entries(SKY)) {
        viewer.set_property(["Background", "<object>"], name, color);
      }
      for (const [name, power] of Object.entries(LIGHTS)) {
        viewer.set_property(["Lights", name, "<object>"], "intensity", power);
      }
      viewer.set_property(["Axes"], "visible", false);
      viewer.set_property(["Grid", "<object>"], "material.opacity", 0.2);
      viewer.set_property(["Grid", "<object>"], "material.transparent", true);
      return viewer;
    } catch (error) {
      console.error(error);
      const message = byId("scene-message");
      message.textContent = "No picture: this browser has no WebGL. All else works.";
      message.hidden = false;
      return null;
    }
  }

  #fit() {
    this.viewer.set_3d_pane_size();
    this.camera.fit();
  }

  #animate() {
    requestAnimationFrame(() => this.#animate());
    // What was drawn before this call is on the screen now.
    for (const frame of this.drawn.splice(0)) this.send({ type: "drawn", frame });
    for (const picture of this.waiting.splice(0)) this.#apply(picture);
    if (!this.viewer.needs_render && this.drawn.length === 0) return;
    const { renderer, scene, camera } = this.viewer;
    this.camera.update();
    renderer.render(scene, camera);
    this.viewer.needs_render = false;
  }

  /** @param {ArrayBuffer} picture the number of the frame, and each command behind its length */
  #apply(picture) {
    const view = new DataView(picture);
    for (let at = 4; at + 4 <= picture.byteLength; ) {
      const length = view.getUint32(at, true);
      this.#command(new Uint8Array(picture, at + 4, length));
      at += 4 + length;
    }
    this.drawn.push(view.getUint32(0, true));
  }

  /** @param {Uint8Array} bytes */
  #command(bytes) {
    try {
      const command = this.viewer.decode({ data: bytes });
      if (COMMANDS.has(command.type) && !OWN.test(command.path)) this.viewer.handle_command(command);
    } catch (error) {
      console.error("a command of the scene", error);
    }
  }
}

/**
 * What draws, in the browser's words.
 * @param {WebGLRenderingContext} gl
 */
function graphics(gl) {
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  return names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
}
