// The path of the tool as a line, coloured by how near the robot is to what it may not touch.
import * as THREE from "three";
import { placeIn, rowAt, unpack } from "./data.js";
import { distanceColour } from "./palette.js";

const STEP = 0.02; // s between two points of a path
const MOST = 4000; // points of it
const PLAIN = [0.35, 0.5, 0.72];

export class ToolPath {
  constructor(stage, replay, clearance) {
    this.stage = stage;
    this.replay = replay;
    this.clearance = clearance && readClearance(clearance);
    this.line = null;
  }

  /** Draws the path between two times. */
  show(t_start, t_end) {
    this.hide();
    const n = Math.min(Math.ceil((t_end - t_start) / STEP), MOST);
    if (n < 1) return;
    const times = Array.from({ length: n + 1 }, (_, i) => t_start + (i / n) * (t_end - t_start));
    const geometry = new THREE.LineGeometry();
    geometry.setPositions(this.replay.tips(times));
    geometry.setColors(times.flatMap((t) => this.#colour(t)));
    const material = new THREE.LineMaterial({ vertexColors: true, linewidth: 3.5, worldUnits: false });
    this.line = new THREE.Line2(geometry, material);
    this.stage.overlay.add(this.line);
    this.stage.changed();
  }

  hide() {
    if (!this.line) return;
    this.stage.overlay.remove(this.line);
    this.line.geometry.dispose();
    this.line.material.dispose();
    this.line = null;
    this.stage.changed();
  }

  #colour(t) {
    if (!this.clearance) return PLAIN;
    const rgb = distanceColour(this.clearance.at(t));
    return new THREE.Color().setRGB(...rgb, THREE.SRGBColorSpace).toArray();
  }
}

/** The clearance of the document, to be asked by time. */
export function readClearance({ times, values, pairs, names = [], kept, most, steady = [] }) {
  const [t, distances, nearest] = [unpack(times).values, unpack(values), unpack(pairs)];
  return {
    kept, most, times: t,
    steady: steady.length ? `\nleft out, as near for long: ${steady.join("; ")}` : "",
    values: distances.values,
    at: (time) => rowAt(t, distances, time)[0],
    nearest: (time) => names[nearest.values[placeIn(t, time)[0]]] ?? "",
  };
}
