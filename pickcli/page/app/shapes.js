// Geometries of the document's shapes, and what is printed on items.
import * as THREE from "three";
import { unpack } from "./data.js";

const ROUND = 32; // sides of what is round
const CREASE = 0.6; // rad between flat triangles, up to which an edge is smooth in the light
const PRINT = 340; // pixels of a printed face per m^0.5, and the most that a side has
const PRINT_MOST = 256;

/** The geometry of a shape, centred on its frame. */
export function geometryOf(shape) {
  const [a, b, c] = shape.size ?? [];
  if (shape.kind === "box") return new THREE.BoxGeometry(a, b, c);
  if (shape.kind === "sphere") return new THREE.SphereGeometry(a, ROUND, ROUND / 2);
  if (shape.kind === "cylinder") return new THREE.CylinderGeometry(a, a, b, ROUND).rotateX(Math.PI / 2);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(unpack(shape.corners).values), 3));
  geometry.setIndex(Array.from(unpack(shape.triangles).values));
  if (shape.is_smooth) return THREE.toCreasedNormals(geometry, CREASE);
  const flat = geometry.toNonIndexed();
  flat.computeVertexNormals();
  return flat;
}

/** Puts an object where a pose of the document says. */
export function place(object, pose) {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
  return object;
}

/** Edges of some bodies as one object; round ones and meshes show theirs only where they are sharp. */
export function edgesOf(bodies, opacity, colour) {
  const positions = [];
  const at = new THREE.Object3D();
  const corner = new THREE.Vector3();
  for (const body of bodies) {
    place(at, body.pose).updateMatrix();
    const points = new THREE.EdgesGeometry(geometryOf(body.shape), 40).getAttribute("position");
    for (let i = 0; i < points.count; i++) {
      corner.fromBufferAttribute(points, i).applyMatrix4(at.matrix);
      positions.push(corner.x, corner.y, corner.z);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(positions), 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }));
}

/** Materials of a box's six faces with a name printed on them, in the order of BoxGeometry. */
export function printedMaterials(name, colour, size) {
  const [x, y, z] = size;
  const prints = new Map();
  const print = (width, height) => {
    const key = `${width} ${height}`;
    if (!prints.has(key)) {
      const map = printed(name, colour, width, height);
      prints.set(key, new THREE.MeshLambertMaterial({ map }));
    }
    return prints.get(key);
  };
  return [print(z, y), print(z, y), print(x, z), print(x, z), print(x, y), print(x, y)];
}

function printed(name, colour, width, height) {
  const canvas = document.createElement("canvas");
  const scale = Math.min(PRINT / Math.sqrt(Math.max(width, height)), PRINT_MOST / Math.max(width, height));
  canvas.width = Math.max(16, Math.round(width * scale));
  canvas.height = Math.max(16, Math.round(height * scale));
  const ink = canvas.getContext("2d");
  ink.fillStyle = colour;
  ink.fillRect(0, 0, canvas.width, canvas.height);
  ink.fillStyle = brightness(colour) > 0.55 ? "rgba(0,0,0,.72)" : "rgba(255,255,255,.9)";
  ink.translate(canvas.width / 2, canvas.height / 2);
  const isUpright = canvas.height > canvas.width;
  if (isUpright) ink.rotate(-Math.PI / 2);
  const [across, high] = isUpright ? [canvas.height, canvas.width] : [canvas.width, canvas.height];
  const lines = inLines(name, across > 3 * high ? 1 : across > 1.4 * high ? 2 : 3);
  const longest = Math.max(...lines.map((line) => line.length));
  const font = Math.min((0.9 * across) / (0.56 * longest), (0.8 * high) / (1.15 * lines.length));
  ink.font = `600 ${font}px system-ui, sans-serif`;
  ink.textAlign = "center";
  ink.textBaseline = "middle";
  lines.forEach((line, k) => ink.fillText(line, 0, (k - (lines.length - 1) / 2) * 1.15 * font));
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

function inLines(text, most) {
  const words = text.split(" ");
  const wanted = Math.ceil(text.length / Math.min(most, words.length));
  const lines = [""];
  for (const word of words) {
    const last = lines[lines.length - 1];
    if (last && last.length + word.length > wanted && lines.length < most) lines.push(word);
    else lines[lines.length - 1] = last ? `${last} ${word}` : word;
  }
  return lines;
}

function brightness(colour) {
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);
  return 0.3 * r + 0.59 * g + 0.11 * b;
}
