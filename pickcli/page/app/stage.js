// The 3-D view: what stands, items, lines, points, lights, labels, and what the pointer is over. It draws when something changed.
import * as THREE from "three";
import { unpack } from "./data.js";
import { styled } from "./palette.js";
import { RobotView } from "./robot.js";
import { edgesOf, geometryOf, place, printedMaterials } from "./shapes.js";

const GHOST = 0.18; // opacity of the robot while one looks past it
const HIGHLIGHT = { chosen: "#1f6feb", bad: "#d62728" };
const POINTING = 5; // pixels by which the pointer may miss a line

export class Stage {
  constructor(canvas, labels, contents) {
    this.canvas = canvas;
    this.contents = contents;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(42, 1, 0.02, 60);
    this.camera.up.set(0, 0, 1);
    this.solids = new THREE.Group(); // everything that one can point at
    this.lines = new THREE.Group();
    this.overlay = new THREE.Group(); // paths and failures
    this.scene.add(this.solids, this.lines, this.overlay);
    this.named = new Map(); // meshes by the name of their link, body or item
    this.items = new Map();
    this.seenThrough = [];
    this.marked = [];
    this.labels = new Labels(labels, this);
    this.#light();
    this.#build(contents);
    this.recolour();
    this.changed();
  }

  #light() {
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#8d93a0", 2.1));
    const sun = new THREE.DirectionalLight("#ffffff", 1.5);
    sun.position.set(-3, -2.5, 5);
    const fill = new THREE.DirectionalLight("#ffffff", 0.5);
    fill.position.set(4, 3, 2);
    this.scene.add(sun, fill);
  }

  #build({ robot, groups = [], items = [], nodes = [], lines = [] }) {
    for (const group of groups) this.#addGroup(group);
    if (robot) {
      this.robot = new RobotView(robot);
      this.solids.add(this.robot.group);
      for (const mesh of this.robot.meshes) this.#name(mesh);
    }
    for (const item of items) this.#addItem(item);
    this.#addNodes(nodes);
    for (const line of lines) this.#addLine(line);
    this.bounds = new THREE.Box3().setFromObject(this.solids);
    const reach = Math.max(4, Math.ceil(this.bounds.getSize(new THREE.Vector3()).length()));
    this.grid = new THREE.GridHelper(2 * reach, 4 * reach).rotateX(Math.PI / 2);
    this.scene.add(this.grid);
  }

  #addGroup(group) {
    const at = place(new THREE.Group(), group.pose);
    for (const body of group.bodies) {
      const { opacity } = group;
      const material = new THREE.MeshLambertMaterial({ color: body.shape.colour || group.colour });
      const mesh = place(new THREE.Mesh(geometryOf(body.shape), material), body.pose);
      mesh.userData = { kind: group.name, name: body.name, opacity };
      if (opacity < 1) this.seenThrough.push(mesh);
      this.#name(mesh);
      at.add(mesh);
    }
    at.add(edgesOf(group.bodies, group.opacity < 0.3 ? 0.3 : 0.5, "#3a3f47"));
    this.solids.add(at);
    this.seeThrough(true);
  }

  #addItem(item) {
    const mesh = new THREE.Mesh(geometryOf(item.shape), new THREE.MeshLambertMaterial({ color: item.colour }));
    place(mesh, item.pose);
    mesh.userData = { kind: "item", name: item.id, item };
    mesh.add(edgesOf([{ shape: item.shape, pose: [0, 0, 0, 0, 0, 0, 1] }], 0.45, "#1b2027"));
    this.items.set(item.id, mesh);
    this.#name(mesh);
    this.solids.add(mesh);
  }

  #addNodes(nodes) {
    const ball = new THREE.SphereGeometry(0.012, 12, 8);
    this.nodes = new THREE.Group();
    for (const node of nodes) {
      const mesh = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ color: node.colour }));
      mesh.position.set(...node.point);
      mesh.userData = { kind: "configuration", name: node.name };
      this.nodes.add(mesh);
    }
    this.lines.add(this.nodes);
  }

  #addLine(line) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(unpack(line.points).values), 3));
    const drawn = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: line.colour, transparent: true, opacity: 0.55 }));
    drawn.userData = { kind: "path", name: line.name };
    this.lines.add(drawn);
  }

  #name(mesh) {
    const { name } = mesh.userData;
    if (!this.named.has(name)) this.named.set(name, []);
    this.named.get(name).push(mesh);
  }

  /** Prints the names of items on them: not before the first frame, which need not wait for that. */
  printNames() {
    for (const mesh of this.items.values()) {
      const { item } = mesh.userData;
      if (item.shape.kind === "box") mesh.material = printedMaterials(item.name, item.colour, item.shape.size);
    }
    this.changed();
  }

  /** Lets one look through shelves, or not. */
  seeThrough(isOn) {
    this.isSeenThrough = isOn;
    for (const { material, userData } of this.seenThrough) {
      material.transparent = isOn;
      material.opacity = isOn ? userData.opacity : 1;
      material.depthWrite = !isOn;
      material.needsUpdate = true;
    }
    this.changed();
  }

  /** Lets one look through the links of the arm that stand between the view and a point; null: through none. */
  lookPast(point) {
    const { position } = this.camera;
    const sight = point && new THREE.Line3(position, point);
    const nearest = new THREE.Vector3();
    for (const mesh of this.robot?.meshes ?? []) {
      if (mesh.userData.isTool) continue;
      mesh.geometry.boundingSphere ?? mesh.geometry.computeBoundingSphere();
      const sphere = mesh.geometry.boundingSphere.clone().applyMatrix4(mesh.matrixWorld);
      const isBetween = sight !== null && sight.closestPointToPoint(sphere.center, true, nearest).distanceTo(sphere.center) < sphere.radius;
      setGhost(mesh.material, isBetween);
    }
    this.changed();
  }

  /** Marks links, bodies and items by name. Returns the meshes that were found. */
  highlight(names, how = "chosen") {
    const found = names.flatMap((name) => this.named.get(name) ?? []);
    for (const mesh of found) {
      for (const material of [mesh.material].flat()) {
        material.userData.colour ??= material.color.clone();
        material.color.set(HIGHLIGHT[how]).lerp(material.userData.colour, 0.2);
        material.emissive.set(HIGHLIGHT[how]);
        material.emissiveIntensity = 0.35;
        if (mesh.userData.opacity < 1 && this.isSeenThrough) material.opacity = 0.6;
      }
    }
    this.marked.push(...found);
    this.changed();
    return found;
  }

  clearHighlights() {
    for (const mesh of this.marked) {
      for (const material of [mesh.material].flat()) {
        material.color.copy(material.userData.colour ?? material.color);
        material.emissive.set(0);
        if (mesh.userData.opacity < 1 && this.isSeenThrough) material.opacity = mesh.userData.opacity;
      }
    }
    this.marked = [];
    this.changed();
  }

  /** The first thing under a point of the canvas: what one looks through only where nothing else is. */
  at(x, y) {
    const { width, height } = this.canvas.getBoundingClientRect();
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    ray.params.Line.threshold = (POINTING / height) * this.camera.position.distanceTo(this.target ?? this.scene.position) * 0.7;
    const isNamed = ({ object }) => object.isMesh && object.userData.kind;
    const solids = ray.intersectObject(this.solids, true).filter(isNamed);
    const opaque = solids.find(({ object }) => !(object.userData.opacity < 0.5 && this.isSeenThrough));
    const line = ray.intersectObject(this.lines, true).find(({ object }) => object.userData.name);
    if (line && !(opaque && opaque.distance < line.distance)) return line.object.userData;
    return (opaque ?? solids[0])?.object.userData ?? null;
  }

  recolour() {
    this.scene.background = new THREE.Color(styled("sky"));
    this.grid.material.color = new THREE.Color(styled("grid"));
    this.grid.material.vertexColors = false;
    this.grid.material.needsUpdate = true;
    this.changed();
  }

  /** Has the view drawn anew with the next frame. */
  changed() {
    this.isStale = true;
  }

  /** Draws the view if something changed. Returns whether it did. */
  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width !== this.width || height !== this.height) this.#resize(width, height);
    if (!this.isStale || !width || !height) return false;
    this.isStale = false;
    this.renderer.render(this.scene, this.camera);
    this.labels.draw(width, height);
    return true;
  }

  #resize(width, height) {
    [this.width, this.height] = [width, height];
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.isStale = true;
  }
}

function setGhost(material, isOn) {
  if (material.transparent === isOn) return;
  material.transparent = isOn;
  material.opacity = isOn ? GHOST : 1;
  material.depthWrite = !isOn;
  material.needsUpdate = true;
}

/** Words at points of the world, over the view. */
class Labels {
  constructor(element, stage) {
    this.element = element;
    this.stage = stage;
    this.shown = new Map();
  }

  /** Puts words at a point, or where an object is; null takes them away. */
  set(key, text, at, style = "") {
    let label = this.shown.get(key);
    if (text === null) {
      label?.span.remove();
      this.shown.delete(key);
    } else {
      if (!label) {
        label = { span: this.element.appendChild(document.createElement("span")) };
        this.shown.set(key, label);
      }
      label.span.textContent = text;
      label.span.className = style;
      label.at = at;
    }
    this.stage.changed();
  }

  clear(prefix) {
    for (const key of [...this.shown.keys()]) if (key.startsWith(prefix)) this.set(key, null);
  }

  draw(width, height) {
    const point = new THREE.Vector3();
    const farthest = 1.15 * this.stage.camera.position.distanceTo(this.stage.target) + 0.15; // of names that would cover each other
    for (const { span, at } of this.shown.values()) {
      if (at.isObject3D) at.getWorldPosition(point);
      else point.copy(at);
      const isFar = span.className === "far" && point.distanceTo(this.stage.camera.position) > farthest;
      point.project(this.stage.camera);
      const isSeen = !isFar && point.z < 1 && Math.abs(point.x) < 1.1 && Math.abs(point.y) < 1.1;
      span.style.display = isSeen ? "" : "none";
      const [x, y] = [((point.x + 1) * width) / 2, ((1 - point.y) * height) / 2];
      span.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -130%)`;
    }
  }
}
