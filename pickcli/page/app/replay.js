// The clock of a page, and where everything is at a time.
import * as THREE from "three";
import { rowAt, unpack } from "./data.js";

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];

export class Replay {
  constructor(stage, motion) {
    this.stage = stage;
    this.duration = motion.duration;
    this.times = unpack(motion.times).values;
    this.positions = unpack(motion.positions);
    this.carried = motion.carried ?? [];
    this.tracks = (motion.tracks ?? []).map(({ item, times, poses }) => ({ item, times: unpack(times).values, poses: unpack(poses) }));
    this.starts = new Map(stage.contents.items?.map((item) => [item.id, item.pose]));
    this.t = 0;
    this.speed = 1;
    this.isPlaying = false;
    this.listeners = [];
    this.row = [];
    this.ends = this.carried.map((span) => this.#carriedPose(span, span.t_end));
    this.#apply();
  }

  /** Calls a function with the time whenever it changes. */
  onChange(listener) {
    this.listeners.push(listener);
  }

  seek(t) {
    this.t = Math.min(this.duration, Math.max(0, t));
    this.#apply();
    for (const listener of this.listeners) listener(this.t);
  }

  play(isPlaying = !this.isPlaying) {
    if (isPlaying && this.t >= this.duration) this.seek(0);
    this.isPlaying = isPlaying;
    for (const listener of this.listeners) listener(this.t);
  }

  /** Lets some seconds of the reader's time pass. */
  pass(seconds) {
    if (!this.isPlaying) return;
    const t = this.t + seconds * this.speed;
    if (t >= this.duration) this.isPlaying = false;
    this.seek(t);
  }

  faster(steps) {
    const k = SPEEDS.indexOf(this.speed) + steps;
    this.speed = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, k))];
    for (const listener of this.listeners) listener(this.t);
  }

  /** Where the tip of the tool is at some times: (x, y, z) in a row. */
  tips(times) {
    const { robot } = this.stage;
    const points = new Float32Array(3 * times.length);
    const at = new THREE.Vector3();
    times.forEach((t, i) => {
      robot.set(rowAt(this.times, this.positions, t));
      robot.tip.getWorldPosition(at).toArray(points, 3 * i);
    });
    robot.set(this.row);
    return points;
  }

  #apply() {
    const { robot } = this.stage;
    rowAt(this.times, this.positions, this.t, this.row);
    robot.set(this.row);
    // An item may ride on a belt until it is carried.
    for (const track of this.tracks) {
      this.#put(track.item, matrixOf(rowAt(track.times, track.poses, this.t)));
    }
    this.carried.forEach((span, k) => {
      if (this.t < span.t_start && this.tracks.some((track) => track.item === span.item)) return;
      const isFirst = !this.carried.slice(0, k).some((other) => other.item === span.item);
      if (this.t >= span.t_start && this.t < span.t_end) this.#put(span.item, this.#hanging(span));
      else if (this.t >= span.t_end) this.#put(span.item, this.ends[k]);
      else if (isFirst) this.#put(span.item, matrixOf(this.starts.get(span.item)));
    });
    this.stage.changed();
  }

  #hanging(span) {
    return new THREE.Matrix4().multiplyMatrices(this.stage.robot.tip.matrixWorld, matrixOf(span.pose));
  }

  #carriedPose(span, t) {
    this.stage.robot.set(rowAt(this.times, this.positions, t));
    return this.#hanging(span);
  }

  #put(item, matrix) {
    const mesh = this.stage.items.get(item);
    if (mesh) matrix.decompose(mesh.position, mesh.quaternion, mesh.scale);
  }
}

function matrixOf(pose) {
  const [x, y, z, ...turn] = pose;
  const one = new THREE.Vector3(1, 1, 1);
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(...turn).normalize(), one);
}
