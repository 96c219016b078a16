// Where the view is seen from: freely, following the tool, out of the tool, or into a place.
import * as THREE from "three";

const CLOSE = 0.9; // m from the tool, where it is followed
const FARTHEST = 4.2; // m from the middle of a cell, where the arm is still well seen
const BEFORE = 0.6; // m in front of a mouth, times its width over that of a bin

export class Cameras {
  constructor(stage, focus) {
    this.stage = stage;
    this.controls = new THREE.OrbitControls(stage.camera, stage.canvas);
    Object.assign(this.controls, { zoomToCursor: true, minDistance: 0.05, maxDistance: 25, dampingFactor: 0.2 });
    this.controls.addEventListener("change", () => this.#cleared());
    stage.target = this.controls.target;
    this.mode = "free"; // or "follow", "tool", "place"
    this.last = new THREE.Vector3();
    this.overview(focus);
  }

  /** The whole cell, seen over the robot's left shoulder. */
  overview(focus) {
    const { bounds, camera } = this.stage;
    const middle = bounds.getCenter(new THREE.Vector3());
    const extent = bounds.getSize(new THREE.Vector3()).length();
    if (focus?.length) middle.lerp(new THREE.Vector3(...focus), 0.6);
    this.controls.target.copy(middle);
    const away = new THREE.Vector3(-0.66, 0.62, 0.4).normalize();
    camera.position.copy(middle).addScaledVector(away, Math.min(1.25 * extent, FARTHEST));
    this.mode = "free";
    this.controls.update();
  }

  /** Keeps the tool in the middle; the pointer still turns the view about it. */
  follow() {
    const { camera, robot } = this.stage;
    const tip = robot.tip.getWorldPosition(new THREE.Vector3());
    const away = camera.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(tip);
    camera.position.copy(tip).addScaledVector(away, CLOSE);
    this.last.copy(tip);
    this.mode = "follow";
    this.controls.update();
  }

  /** Looks along the tool, from behind it. */
  ride() {
    this.mode = "tool";
    this.update();
  }

  /** Looks into a place of the document. */
  lookInto(place) {
    const [x, y, z, ...turn] = place.mouth;
    const mouth = new THREE.Vector3(x, y, z);
    const R = new THREE.Quaternion(...turn);
    const direct = (a, b, c) => new THREE.Vector3(a, b, c).applyQuaternion(R);
    const size = Math.max(...place.size, 0.2);
    this.controls.target.copy(mouth).addScaledVector(direct(1, 0, 0), 0.6 * Math.min(size, 0.4));
    const away = direct(-1, 0, 0).multiplyScalar((BEFORE * size) / 0.28).add(direct(0, 0.3 * size, 0));
    if (Math.abs(direct(1, 0, 0).z) < 0.5) away.z += 0.35 * size;
    this.stage.camera.position.copy(mouth).add(away);
    this.mode = "place";
    this.controls.update();
  }

  /** Moves along with the tool. */
  update() {
    const { camera, robot } = this.stage;
    if (!robot) return;
    if (this.mode === "follow") {
      const tip = robot.tip.getWorldPosition(new THREE.Vector3());
      camera.position.add(tip).sub(this.last);
      this.controls.target.copy(tip);
      this.last.copy(tip);
      this.controls.update();
    } else if (this.mode === "tool") {
      const direct = (x, y, z) => new THREE.Vector3(x, y, z).transformDirection(robot.tip.matrixWorld);
      const tip = robot.tip.getWorldPosition(new THREE.Vector3());
      this.controls.target.copy(tip).addScaledVector(direct(0, 0, 1), 0.05);
      const back = direct(0, 0, -1).multiplyScalar(0.42);
      camera.position.copy(tip).add(back).add(new THREE.Vector3(0, 0, Math.abs(back.z) < 0.35 ? 0.16 : 0)).addScaledVector(direct(1, 0, 0), Math.abs(back.z) < 0.35 ? 0 : 0.16);
      this.controls.update();
    }
    this.#cleared();
  }

  /** Nothing of the arm is in the way of what is looked at. */
  #cleared() {
    this.stage.lookPast(this.mode === "free" ? null : this.controls.target);
  }
}
