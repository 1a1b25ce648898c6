/**
 * The camera of the scene: where it stands and looks, and what it rides on.
 *
 * Meshcat's scene has z up; three.js, inside it, has y up.
 */

/** @typedef {{name: string, eye: number[], target: number[], up: number[], zoom: number, frame: string}} CameraView */

const ASPECT = 1.45; // width to height that a view is made for

/** Moves the camera of a Meshcat viewer. */
export class Camera {
  /** @param {any} viewer MeshCat.Viewer */
  constructor(viewer) {
    this.viewer = viewer;
    this.vector = () => viewer.camera.position.clone(); // three.js itself is hidden in the viewer
    /** @type {CameraView | null} */
    this.view = null;
  }

  /**
   * Choose a view; one that is not carried can be turned with the mouse afterwards.
   * @param {CameraView} view
   */
  choose(view) {
    this.view = view;
    this.fit();
    this.viewer.controls.enabled = view.frame === "";
    this.#place(view);
  }

  /** Show as much on a narrow screen as on a wide one. */
  fit() {
    const { camera } = this.viewer;
    camera.zoom = (this.view?.zoom ?? 1) * Math.min(1, camera.aspect / ASPECT);
    camera.updateProjectionMatrix();
    this.viewer.set_dirty();
  }

  /** Before a picture: go along with what carries the camera, or where the mouse wants it. */
  update() {
    if (this.view?.frame) this.#place(this.view);
    else this.viewer.controls.update();
  }

  /** @param {CameraView} view */
  #place(view) {
    const { camera, controls } = this.viewer;
    const matrix = this.#carrier(view.frame)?.matrixWorld;
    const point = (xyz) => {
      const inside = this.vector().set(...xyz);
      return matrix ? inside.applyMatrix4(matrix) : this.#yUp(inside);
    };
    const eye = point(view.eye);
    const target = point(view.target);
    const up = this.vector().set(...view.up);
    camera.up.copy(matrix ? up.transformDirection(matrix) : this.#yUp(up));
    camera.position.copy(eye);
    controls.target.copy(target);
    camera.lookAt(target);
  }

  /** @param {string} path */
  #carrier(path) {
    if (!path) return null;
    let node = this.viewer.scene_tree;
    for (const name of path.split("/").filter(Boolean)) {
      node = node.children[name];
      if (!node) return null; // it is not there yet
    }
    node.object.updateWorldMatrix(true, false);
    return node.object;
  }

  #yUp(vector) {
    return vector.set(vector.x, vector.z, -vector.y);
  }
}
