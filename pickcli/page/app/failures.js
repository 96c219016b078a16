// What went wrong, drawn where it did: the bodies that met, how deep, and the grasp that was refused.
import * as THREE from "three";

const LABELS = 2; // of the most frequent reasons
const LENGTH = 0.16; // m of the arrow of a grasp
const AXES = { x: 0, y: 1, z: 2 };

export class Failures {
  constructor(stage) {
    this.stage = stage;
    this.group = new THREE.Group();
    stage.overlay.add(this.group);
  }

  clear() {
    this.group.clear();
    this.stage.labels.clear("failure");
    this.stage.clearHighlights();
  }

  /** Draws one reason, or several. */
  show(marks) {
    this.clear();
    const drawn = new Set(); // arrows that would cover each other
    const labels = marks.map((mark, k) => {
      const met = this.stage.highlight(mark.names ?? [], "bad");
      const key = JSON.stringify(mark.grasp ?? [mark.names, k]);
      if (drawn.has(key)) return null;
      drawn.add(key);
      const at = mark.grasp ? this.#arrow(mark.grasp, drawn.size - 1) : middleOf(met);
      return at && { mark, at };
    }).filter(Boolean);
    labels.sort((a, b) => (b.mark.count ?? 1) - (a.mark.count ?? 1));
    labels.slice(0, LABELS).forEach(({ mark, at }, k) => this.stage.labels.set(`failure ${k}`, words(mark), at, "bad"));
    this.stage.changed();
  }

  /** An arrow at the face that a refused grasp was to take. Returns the point where it begins. */
  #arrow({ item, face, kind }, k) {
    const mesh = this.stage.items.get(item);
    if (!mesh) return null;
    const out = outward(mesh, face, kind);
    mesh.geometry.computeBoundingBox();
    const size = mesh.geometry.boundingBox.getSize(new THREE.Vector3());
    const local = out.clone().applyQuaternion(mesh.quaternion.clone().invert());
    const reach = (Math.abs(local.x) * size.x + Math.abs(local.y) * size.y + Math.abs(local.z) * size.z) / 2;
    const surface = mesh.getWorldPosition(new THREE.Vector3()).addScaledVector(out, reach);
    const from = surface.clone().addScaledVector(out, LENGTH * (1 + 0.12 * k));
    const arrow = new THREE.ArrowHelper(out.clone().negate(), from, from.distanceTo(surface), "#d62728", 0.045, 0.028);
    for (const part of [arrow.line, arrow.cone]) {
      part.material.depthTest = false;
      part.renderOrder = 2;
    }
    this.group.add(arrow);
    return from;
  }
}

function words({ title, depth, count }) {
  return [title, depth ? `, ${(1e3 * depth).toFixed(1)} mm deep` : "", count > 1 ? ` (${count} times)` : ""].join("");
}

/** The direction (in the world) that a face of an item looks to; of round faces the one a grasp comes from. */
function outward(mesh, face, kind) {
  if (face[1] in AXES) {
    const axis = new THREE.Vector3().setComponent(AXES[face[1]], face[0] === "-" ? -1 : 1);
    return axis.applyQuaternion(mesh.quaternion);
  }
  if (kind === "frontal") return new THREE.Vector3(-1, 0, 0);
  return new THREE.Vector3(0, kind === "side" ? 1 : 0, kind === "side" ? 0 : 1);
}

function middleOf(meshes) {
  if (!meshes.length) return null;
  const smallest = meshes.map((mesh) => new THREE.Box3().setFromObject(mesh)).sort((a, b) => volume(a) - volume(b))[0];
  return smallest.getCenter(new THREE.Vector3());
}

function volume(box) {
  const size = box.getSize(new THREE.Vector3());
  return size.x * size.y * size.z;
}
