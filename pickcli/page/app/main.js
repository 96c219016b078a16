// Puts a page together: reads its document, builds the parts, and brings keys and pointer to them.
import { Cameras } from "./cameras.js";
import { readDocument } from "./data.js";
import { Failures } from "./failures.js";
import { distanceGradient } from "./palette.js";
import { node, Panel } from "./panel.js";
import { ToolPath } from "./path.js";
import { Replay } from "./replay.js";
import { Stage } from "./stage.js";
import { Timeline } from "./timeline.js";

const KEYS = [
  ["space", "play or pause"], ["← →", "0.1 s back or on; with shift 1 s"], ["↑ ↓", "faster or slower"], [", .", "previous or next segment"],
  ["[ ]", "previous or next attempt"], ["1 2 3 4", "whole cell, follow the tool, out of the tool, into the bin"], ["S", "look through shelves"],
  ["N", "names of items"], ["P", "path of the tool"], ["L", "lanes"], ["wheel", "zoom, in the lanes too"], ["esc", "choose nothing"], ["?", "these keys"],
];

const byId = (id) => document.getElementById(id);

class Page {
  constructor(contents) {
    this.contents = contents;
    this.chapters = contents.chapters ?? [];
    this.panel = new Panel(byId("panel"), contents, {
      showMark: (mark) => this.showMark(mark),
      showChapter: (k) => this.showChapter(k),
    });
    this.chapter = -1;
    if (contents.robot) this.#openView(contents);
    else document.body.classList.add("is-flat");
    this.#help();
  }

  #openView(contents) {
    this.stage = new Stage(byId("view"), byId("labels"), contents);
    this.cameras = new Cameras(this.stage, contents.focus);
    this.failures = new Failures(this.stage);
    if (contents.motion) this.#openReplay(contents);
    this.#toolbar();
    this.#legend(contents);
    this.#pointer();
    document.addEventListener("keydown", (event) => this.#key(event));
    document.addEventListener("click", ({ detail, target }) => detail && target.closest("button")?.blur()); // space plays on
    document.addEventListener("change", ({ target }) => target.blur());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.stage.recolour();
      this.timeline?.draw();
    });
    if (contents.marks?.length) this.failures.show(contents.marks);
    for (const each of contents.nodes ?? []) {
      if (each.is_main && !contents.motion) this.stage.labels.set(`node ${each.name}`, each.name, this.stage.nodes.children[contents.nodes.indexOf(each)], "node");
    }
    this.stage.nodes.visible = !contents.motion;
    const first = () => {
      this.#frame(performance.now());
      this.firstFrame = performance.now();
      requestAnimationFrame((now) => this.#afterFirstFrame(now));
    };
    requestAnimationFrame(first);
  }

  #openReplay(contents) {
    byId("timeline").hidden = false;
    this.replay = new Replay(this.stage, contents.motion);
    this.path = new ToolPath(this.stage, this.replay, contents.clearance);
    this.timeline = new Timeline(this.replay, contents, { lanes: byId("lanes"), playhead: byId("playhead"), controls: byId("controls"), tip: byId("tip") });
    this.replay.onChange((t) => {
      this.cameras.update();
      this.#setChapter(t);
    });
  }

  #afterFirstFrame(now) {
    this.stage.printNames();
    if (this.contents.marks?.length) this.failures.show(this.contents.marks); // on the printed faces, too
    if (this.path && this.contents.motion.is_path_drawn) this.path.show(0, this.replay.duration);
    if (this.replay) this.#setChapter(this.replay.t);
    this.last = now;
    const tick = (time) => {
      this.#frame(time);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  #frame(now) {
    this.replay?.pass(Math.min(0.25, (now - (this.last ?? now)) / 1000));
    this.last = now;
    this.stage.draw();
  }

  #setChapter(t) {
    if (!this.chapters.length) return;
    const k = this.chapters.findLastIndex(({ t_start }) => t >= t_start - 1e-6);
    if (k !== this.chapter) this.#openChapter(k);
  }

  /** Shows an attempt: its path, its failures, and its row in the panel. */
  #openChapter(k) {
    this.chapter = k;
    this.panel.setChapter(k);
    if (k < 0) return;
    const { t_start, t_end, marks = [] } = this.chapters[k];
    if (this.path && this.isPathShown !== false && !this.contents.motion.is_path_drawn) this.path.show(t_start, t_end);
    this.failures.show(marks);
    this.panel.showReasons("", marks, k);
  }

  showChapter(k) {
    if (!this.chapters[k]) return;
    this.replay.seek(this.chapters[k].t_start);
    this.#openChapter(k); // others may begin at the same time
  }

  showMark(mark) {
    if (mark.t !== undefined && this.replay) this.replay.seek(mark.t);
    this.failures.show([mark]);
  }

  #choose(thing) {
    this.failures.clear();
    this.panel.choose(thing);
    if (!thing) return;
    const [mesh] = this.stage.highlight([thing.name]);
    if (mesh) this.stage.labels.set("failure chosen", thing.name, mesh, "chosen");
  }

  #toolbar() {
    const bar = byId("toolbar");
    const button = (text, title, press, isToggle = false) => {
      const made = node("button", "", text);
      made.title = title;
      made.onclick = () => press(made);
      if (isToggle) made.setAttribute("aria-pressed", isToggle === "on");
      return made;
    };
    const views = [button("Cell", "the whole cell (1)", () => this.look(1))];
    if (this.replay) views.push(button("Follow", "follow the tool (2)", () => this.look(2)), button("Tool", "out of the tool (3)", () => this.look(3)));
    this.views = views;
    bar.append(node("span", "group", ...views));
    if (this.contents.places?.length) bar.append(this.#placeChoice());
    this.toggles = {
      s: button("Shelf", "look through shelves (S)", () => this.toggle("s"), "on"),
      n: button("Names", "names of items (N)", () => this.toggle("n"), true),
      p: button("Path", "path of the tool (P)", () => this.toggle("p"), "on"),
    };
    if (this.stage.seenThrough.length) bar.append(this.toggles.s);
    if (this.stage.items.size) bar.append(this.toggles.n);
    if (this.path) bar.append(this.toggles.p);
    bar.append(button("?", "keys (?)", () => byId("help").showModal()));
    this.#pressed(1);
  }

  #placeChoice() {
    this.placeChoice = node("select");
    this.placeChoice.ariaLabel = "look into a place";
    this.placeChoice.title = "look into a place (4: that of the item)";
    this.placeChoice.add(new Option("Look into …", ""));
    for (const { name } of this.contents.places) this.placeChoice.add(new Option(name.replaceAll("_", " "), name));
    this.placeChoice.onchange = () => this.look(4, this.placeChoice.value);
    return this.placeChoice;
  }

  /** Chooses a camera: 1 the whole cell, 2 following the tool, 3 out of it, 4 into a place. */
  look(k, name = "") {
    if (k === 1) this.cameras.overview(this.contents.focus);
    if (k === 2 && this.replay) this.cameras.follow();
    if (k === 3 && this.replay) this.cameras.ride();
    if (k === 4) {
      const { places = [] } = this.contents;
      const wanted = places.find((place) => place.name === (name || this.#placeNow())) ?? places[0];
      if (!wanted) return;
      this.placeChoice.value = wanted.name;
      this.cameras.lookInto(wanted);
    } else if (this.placeChoice) this.placeChoice.value = "";
    this.#pressed(k);
  }

  #pressed(k) {
    this.views.forEach((view, i) => view.setAttribute("aria-pressed", i + 1 === k));
  }

  /** The place of the item that is picked now. */
  #placeNow() {
    const chapter = this.chapters[this.chapter];
    if (chapter?.place) return chapter.place;
    const item = this.contents.motion?.carried?.[0]?.item;
    return this.contents.items?.find(({ id }) => id === item)?.facts?.[0]?.value ?? "";
  }

  /** Shows or hides: s shelves, n names, p the path. */
  toggle(key) {
    const isOn = this.toggles[key].getAttribute("aria-pressed") !== "true";
    this.toggles[key].setAttribute("aria-pressed", isOn);
    if (key === "s") this.stage.seeThrough(isOn);
    if (key === "n") for (const [id, mesh] of this.stage.items) this.stage.labels.set(`name ${id}`, isOn ? mesh.userData.item.name : null, mesh, "far");
    if (key === "p") {
      this.isPathShown = isOn;
      const { t_start, t_end } = this.chapters[this.chapter] ?? { t_start: 0, t_end: this.replay.duration };
      if (isOn) this.path.show(t_start, t_end);
      else this.path.hide();
    }
  }

  #legend({ clearance, legend = [] }) {
    const parts = legend.flatMap(([name, colour]) => {
      const swatch = node("i", "swatch");
      swatch.style.background = colour;
      return [swatch, name];
    });
    if (clearance) {
      const ramp = node("i", "ramp");
      ramp.style.background = distanceGradient();
      parts.push("path of the tool: clearance 0", ramp, `${1e3 * clearance.most} mm`);
    }
    byId("legend").append(...parts);
  }

  #pointer() {
    const [view, pointed] = [byId("view"), byId("pointed")];
    let pressed = null;
    view.addEventListener("pointermove", (event) => {
      const thing = event.buttons ? null : this.stage.at(event.offsetX, event.offsetY);
      pointed.hidden = !thing?.name;
      if (!thing?.name) return;
      pointed.textContent = thing.name.replaceAll("_", " ");
      pointed.style.left = `${event.offsetX}px`;
      pointed.style.top = `${event.offsetY}px`;
    });
    view.addEventListener("pointerleave", () => (pointed.hidden = true));
    view.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
    view.addEventListener("pointerup", (event) => {
      const hasMoved = !pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4;
      if (!hasMoved) this.#choose(this.stage.at(event.offsetX, event.offsetY));
    });
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, input, dialog *")) return;
    if (event.target.matches("button") && (event.key === " " || event.key === "Enter")) return; // it is pressed
    const act = this.#action(event);
    if (!act) return;
    event.preventDefault();
    act();
  }

  #action({ key, shiftKey }) {
    const { replay } = this;
    const step = shiftKey ? 1 : 0.1;
    const steps = { ArrowLeft: -step, ArrowRight: step };
    if (key >= "1" && key <= "4") return () => this.look(+key);
    if (key === "?") return () => byId("help").showModal();
    if (key === "Escape") return () => this.#choose(null);
    if (key.toLowerCase() in this.toggles && this.toggles[key.toLowerCase()].isConnected) return () => this.toggle(key.toLowerCase());
    if (!replay) return null;
    if (key === " ") return () => replay.play();
    if (key in steps) return () => replay.seek(replay.t + steps[key]);
    if (key === "ArrowUp") return () => replay.faster(1);
    if (key === "ArrowDown") return () => replay.faster(-1);
    if (key === "Home") return () => replay.seek(0);
    if (key === "End") return () => replay.seek(replay.duration);
    if (key === "." || key === ",") return () => this.#step(this.contents.lanes?.[0]?.spans ?? [], key === "." ? 1 : -1);
    if (key === "]" || key === "[") return () => this.#step(this.chapters, key === "]" ? 1 : -1);
    if (key.toLowerCase() === "l") return () => this.timeline.fold();
    return null;
  }

  /** Goes to the next start of a span, or to the one before. */
  #step(spans, way) {
    const starts = spans.map(({ t_start }) => t_start);
    const next = way > 0 ? starts.find((t) => t > this.replay.t + 1e-3) : starts.findLast((t) => t < this.replay.t - 1e-3);
    if (next !== undefined) this.replay.seek(next);
  }

  #help() {
    const rows = KEYS.map(([key, what]) => node("tr", "", node("td", "", node("kbd", "", key)), node("td", "", what)));
    const close = node("button", "", "Close");
    close.onclick = () => byId("help").close();
    byId("help").append(node("table", "", ...rows), close);
  }
}

globalThis.apcPage = new Page(await readDocument(byId("document")));
