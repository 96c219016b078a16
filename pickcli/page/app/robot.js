// The robot: links hanging on joints, moved by the positions of the joints.
import * as THREE from "three";
import { edgesOf, geometryOf, place } from "./shapes.js";

const STEEL = "#d4d8de";

export class RobotView {
  /** Builds the tree of a document's robot. */
  constructor(robot) {
    this.group = place(new THREE.Group(), robot.pose);
    this.meshes = [];
    this.frames = robot.links.map((link) => this.#link(link));
    this.group.add(this.frames[0]);
    const moved = new Map((robot.moved ?? []).map((name, k) => [name, k]));
    this.joints = [];
    for (const joint of robot.joints ?? []) {
      const frame = place(new THREE.Group(), joint.pose);
      this.frames[joint.parent].add(frame);
      frame.add(this.frames[joint.child]);
      if (moved.has(joint.name)) {
        this.joints.push({ column: moved.get(joint.name), child: this.frames[joint.child], isSliding: joint.type === "prismatic", axis: new THREE.Vector3(...joint.axis) });
      }
    }
    this.tip = place(new THREE.Object3D(), robot.tip);
    this.frames[robot.tip_link].add(this.tip);
    this.set(robot.start ?? []);
  }

  #link(link) {
    const frame = new THREE.Group();
    const bodies = link.bodies ?? [];
    for (const body of bodies) {
      const material = new THREE.MeshLambertMaterial({ color: body.shape.colour || STEEL });
      const mesh = place(new THREE.Mesh(geometryOf(body.shape), material), body.pose);
      mesh.userData = { kind: "link", name: link.name, isTool: Boolean(link.is_tool) };
      this.meshes.push(mesh);
      frame.add(mesh);
    }
    if (bodies.some((body) => body.shape.kind !== "mesh")) {
      frame.add(edgesOf(bodies.filter((body) => body.shape.kind !== "mesh"), 0.25, "#1b2027"));
    }
    return frame;
  }

  /** Moves every joint to its position, rad or m, in the order of the document's columns. */
  set(positions) {
    for (const { column, child, isSliding, axis } of this.joints) {
      if (isSliding) child.position.copy(axis).multiplyScalar(positions[column]);
      else child.quaternion.setFromAxisAngle(axis, positions[column]);
    }
    this.group.updateMatrixWorld(true);
  }
}
