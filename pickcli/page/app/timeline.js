// The lanes under the view: chapters, segments, devices and curves over time, to be scrubbed and zoomed.
import { placeIn, rowAt, unpack } from "./data.js";
import { readClearance } from "./path.js";
import { curveColour, distanceColour, spanColour, styled } from "./palette.js";
import { SPEEDS } from "./replay.js";

const GUTTER = 104; // pixels for headings
const AXIS = 20;
const SPAN = 17;
const CURVE = 34;
const GAP = 3;
const LOWEST = 4; // pixels of the clearance of what touches
const SHORTEST = 0.2; // s, the least that is shown

export class Timeline {
  constructor(replay, contents, { lanes, playhead, controls, tip }) {
    this.replay = replay;
    this.element = lanes;
    this.canvas = lanes.querySelector("canvas");
    this.playhead = playhead;
    this.tip = tip;
    this.clearance = contents.clearance && readClearance(contents.clearance);
    this.rows = rowsOf(contents, this.clearance);
    this.marks = [...(contents.marks ?? []), ...(contents.chapters ?? []).flatMap((chapter) => chapter.marks ?? [])].filter((mark) => mark.t !== undefined);
    this.view = [0, replay.duration];
    this.height = AXIS + this.rows.reduce((sum, row) => sum + row.height + GAP, 0);
    this.#controls(controls);
    this.#pointer();
    replay.onChange(() => this.#moved());
    new ResizeObserver(() => this.draw()).observe(lanes);
  }

  /** Draws all lanes anew: their size, their colours or the times shown have changed. */
  draw() {
    const width = this.element.clientWidth;
    const ratio = Math.min(window.devicePixelRatio, 2);
    this.width = width - GUTTER - 12;
    this.canvas.width = width * ratio;
    this.canvas.height = this.height * ratio;
    this.canvas.style.height = `${this.height}px`;
    this.playhead.style.height = `${this.height}px`;
    const ink = this.canvas.getContext("2d");
    ink.scale(ratio, ratio);
    ink.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    ink.textBaseline = "middle";
    this.#axis(ink);
    let y = AXIS;
    for (const row of this.rows) {
      row.top = y;
      ink.fillStyle = styled("quiet");
      ink.textAlign = "right";
      ink.fillText(row.name, GUTTER - 8, y + Math.min(row.height, CURVE) / 2);
      ink.save();
      ink.beginPath();
      ink.rect(GUTTER, y, this.width, row.height);
      ink.clip();
      row.draw(ink, this, y);
      ink.restore();
      y += row.height + GAP;
    }
    this.#drawMarks(ink);
    this.#moved();
  }

  x(t) {
    const [a, b] = this.view;
    return GUTTER + ((t - a) / (b - a)) * this.width;
  }

  t(x) {
    const [a, b] = this.view;
    return a + ((x - GUTTER) / this.width) * (b - a);
  }

  /** Shows a stretch of time, and all of it where that is the whole. */
  zoom(a, b) {
    const span = Math.min(this.replay.duration, Math.max(SHORTEST, b - a));
    const start = Math.min(Math.max(0, a), this.replay.duration - span);
    this.view = [start, start + span];
    this.draw();
  }

  #axis(ink) {
    const [a, b] = this.view;
    const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120].find((s) => (s / (b - a)) * this.width > 62) ?? 300;
    ink.textAlign = "center";
    for (let k = Math.ceil(a / step); k * step <= b; k++) {
      const x = this.x(k * step);
      ink.fillStyle = styled("line");
      ink.fillRect(x, AXIS - 5, 1, this.height);
      ink.fillStyle = styled("quiet");
      ink.fillText(`${+(k * step).toFixed(2)} s`, x, 8);
    }
  }

  #drawMarks(ink) {
    ink.fillStyle = styled("bad");
    for (const { t } of this.marks) {
      const x = this.x(t);
      if (x < GUTTER) continue;
      ink.fillRect(x - 0.75, AXIS - 4, 1.5, this.height);
      ink.beginPath();
      ink.moveTo(x - 5, AXIS - 12);
      ink.lineTo(x + 5, AXIS - 12);
      ink.lineTo(x, AXIS - 3);
      ink.fill();
    }
  }

  #moved() {
    const { replay } = this;
    const [a, b] = this.view;
    if (replay.isPlaying && (replay.t > b || replay.t < a)) this.zoom(replay.t, replay.t + b - a);
    const x = this.x(replay.t);
    this.playhead.style.transform = `translateX(${x.toFixed(1)}px)`;
    this.playhead.style.display = x < GUTTER - 1 || x > GUTTER + this.width + 1 ? "none" : "";
    this.clockText.textContent = `${replay.t.toFixed(2)} / ${replay.duration.toFixed(2)} s`;
    this.playButton.textContent = replay.isPlaying ? "Pause" : "Play";
    this.playButton.setAttribute("aria-pressed", replay.isPlaying);
    this.speedChoice.value = String(replay.speed);
    this.nowText.textContent = this.rows.flatMap((row) => row.now?.(replay.t) ?? []).join("  ·  ");
  }

  #controls(element) {
    this.playButton = element.appendChild(document.createElement("button"));
    this.playButton.id = "play";
    this.playButton.title = "play or pause (space)";
    this.playButton.onclick = () => this.replay.play();
    this.speedChoice = element.appendChild(document.createElement("select"));
    this.speedChoice.title = "speed (up and down)";
    this.speedChoice.ariaLabel = "speed";
    for (const speed of SPEEDS) this.speedChoice.add(new Option(`${speed} ×`, String(speed)));
    this.speedChoice.onchange = () => this.replay.faster(SPEEDS.indexOf(+this.speedChoice.value) - SPEEDS.indexOf(this.replay.speed));
    this.clockText = element.appendChild(document.createElement("output"));
    this.nowText = element.appendChild(document.createElement("span"));
    this.nowText.className = "now";
    const fold = element.appendChild(document.createElement("button"));
    fold.textContent = "Lanes";
    fold.title = "show or hide the lanes (L)";
    fold.setAttribute("aria-pressed", true);
    fold.onclick = () => this.fold();
    this.foldButton = fold;
  }

  fold() {
    this.element.hidden = !this.element.hidden;
    this.foldButton.setAttribute("aria-pressed", !this.element.hidden);
    if (!this.element.hidden) this.draw();
  }

  #pointer() {
    const { element } = this;
    let isScrubbing = false;
    const scrub = (event) => this.replay.seek(this.t(event.clientX - element.getBoundingClientRect().left));
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || event.offsetX > element.clientWidth) return;
      isScrubbing = true;
      element.setPointerCapture(event.pointerId);
      this.replay.play(false);
      scrub(event);
    });
    element.addEventListener("pointermove", (event) => {
      if (isScrubbing) scrub(event);
      this.#point(event);
    });
    element.addEventListener("pointerup", () => (isScrubbing = false));
    element.addEventListener("pointerleave", () => (this.tip.hidden = true));
    element.addEventListener("dblclick", () => this.zoom(0, this.replay.duration));
    element.addEventListener("wheel", (event) => {
      const [a, b] = this.view;
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        event.preventDefault();
        const by = ((event.deltaX || event.deltaY) / this.width) * (b - a);
        this.zoom(a + by, b + by);
      } else if (event.ctrlKey || event.metaKey || element.scrollHeight <= element.clientHeight + 1) {
        event.preventDefault();
        const at = this.t(event.clientX - element.getBoundingClientRect().left);
        const factor = Math.exp(event.deltaY * 0.0015);
        this.zoom(at - (at - a) * factor, at + (b - at) * factor);
      }
    }, { passive: false });
  }

  /** Tells what is under the pointer. */
  #point(event) {
    const box = this.element.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top + this.element.scrollTop];
    const row = this.rows.find(({ top, height }) => y >= top && y < top + height);
    const told = x >= GUTTER ? row?.tell(this.t(x)) : null;
    this.tip.hidden = !told;
    if (!told) return;
    this.tip.textContent = `${this.t(x).toFixed(3)} s\n${told}`;
    const { width, height } = this.tip.getBoundingClientRect();
    this.tip.style.left = `${Math.min(event.clientX + 14, innerWidth - width - 8)}px`;
    this.tip.style.top = `${Math.max(8, event.clientY - height - 12)}px`;
  }
}

function rowsOf({ lanes = [], signals = [], chapters = [] }, clearance) {
  const rows = [];
  if (chapters.length) rows.push(chapterRow(chapters));
  rows.push(...lanes.map(laneRow));
  const [pressure, others] = [signals.filter(isPressure), signals.filter((signal) => !isPressure(signal))];
  rows.push(...pressure.map(signalRow));
  if (clearance) rows.push(clearanceRow(clearance));
  rows.push(...others.map(signalRow));
  return rows;
}

function isPressure(signal) {
  return signal.low === 0;
}

function chapterRow(chapters) {
  const spans = chapters.map(({ t_start, t_end, title, outcome, tone, detail }) => ({
    t_start, t_end, label: title, colour: tone || "quiet", detail: [outcome, detail].filter(Boolean).join(": "),
  }));
  return laneRow({ name: "attempts", spans });
}

function laneRow({ name, spans = [] }) {
  const at = (t) => spans.find((span) => t >= span.t_start && t < Math.max(span.t_end, span.t_start + 1e-3));
  return {
    name, height: SPAN,
    draw(ink, line, y) {
      for (const span of spans) {
        const [a, b] = [line.x(span.t_start), line.x(span.t_end)];
        if (span.colour === "mark") {
          ink.fillStyle = styled("text");
          ink.fillRect(a - 1, y + 2, 2, SPAN - 4);
          label(ink, span.label, a + 5, y, line.width, styled("text"));
          continue;
        }
        ink.fillStyle = spanColour(span.colour);
        ink.fillRect(a, y + (span.colour === "off" ? SPAN / 2 - 1 : 1), Math.max(1, b - a - 1), span.colour === "off" ? 2 : SPAN - 2);
        if (span.colour !== "off") label(ink, span.label, Math.max(a, GUTTER) + 5, y, b - Math.max(a, GUTTER) - 8, inkOn(ink.fillStyle));
      }
    },
    tell(t) {
      const span = at(t) ?? spans.findLast(({ colour, t_start }) => colour === "mark" && t >= t_start && t < t_start + 0.2);
      return span ? [`${name}: ${span.label}`, span.detail].filter(Boolean).join("\n") : null;
    },
    now: (t) => (name === "segments" || name === "attempts" ? at(t)?.label ?? [] : []),
  };
}

function label(ink, text, x, y, room, colour) {
  if (room < 14) return;
  let shown = text;
  while (shown.length > 1 && ink.measureText(shown).width > room) shown = shown.slice(0, -1);
  if (shown.length < Math.min(text.length, 3)) return;
  ink.fillStyle = colour;
  ink.textAlign = "left";
  ink.fillText(shown, x, y + SPAN / 2 + 0.5);
}

function inkOn(colour) {
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));
  return 0.3 * r + 0.59 * g + 0.11 * b > 140 ? "#14171c" : "#ffffff";
}

function signalRow(signal) {
  const times = unpack(signal.times).values;
  const table = unpack(signal.values);
  const { curves, scales, units = [], low, high, limit } = signal;
  const level = (value, y) => y + CURVE - ((value - low) / (high - low)) * CURVE;
  return {
    name: signal.name, height: CURVE,
    draw(ink, line, y) {
      frame(ink, line, y);
      ink.strokeStyle = styled("quiet");
      ink.setLineDash([3, 3]);
      for (const value of limit === undefined ? [] : low < 0 ? [-limit, limit] : [limit]) rule(ink, line, level(value, y));
      ink.setLineDash([]);
      const rows = visible(times, line);
      curves.forEach((_, k) => {
        ink.strokeStyle = curves.length > 1 ? curveColour(k) : styled("accent");
        ink.lineWidth = 1.2;
        ink.beginPath();
        rows.forEach((i, n) => {
          const isApart = limit !== undefined && n > 0 && times[i] - times[rows[n - 1]] > apart(rows);
          const point = [line.x(times[i]), level(table.values[i * table.columns + k], y)];
          if (isApart) ink.moveTo(...point);
          else ink.lineTo(...point);
        });
        ink.stroke();
      });
      const peak = largest(times, table, line);
      if (limit !== undefined && low < 0) note(ink, line, y, `peak ${(100 * peak).toFixed(0)} %`);
    },
    tell(t) {
      const row = rowAt(times, table, t);
      return curves.map((name, k) => {
        const unit = units[k] ?? signal.unit;
        const value = `${(row[k] * scales[k]).toPrecision(3)} ${unit}`;
        return low < 0 ? `${name}: ${value} (${(100 * row[k]).toFixed(0)} % ${signal.unit})` : `${name}: ${value}`;
      }).join("\n");
    },
  };
}

function clearanceRow(clearance) {
  const { times, values, most, kept } = clearance;
  const level = (distance, y) => y + CURVE - (Math.sqrt(Math.max(0, distance) / most)) * (CURVE - 2);
  return {
    name: "clearance", height: CURVE,
    draw(ink, line, y) {
      frame(ink, line, y);
      const rows = visible(times, line);
      rows.forEach((i, k) => {
        const next = rows[k + 1] ?? i;
        if (times[next] - times[i] > apart(rows)) return;
        const rgb = distanceColour(values[i]).map((part) => Math.round(255 * part));
        ink.fillStyle = `rgb(${rgb.join(",")})`;
        const top = Math.min(level(values[i], y), y + CURVE - LOWEST);
        ink.fillRect(line.x(times[i]), top, Math.max(0.8, line.x(times[next]) - line.x(times[i]) + 0.4), y + CURVE - top);
      });
      ink.strokeStyle = styled("bad");
      ink.setLineDash([3, 3]);
      rule(ink, line, level(kept, y));
      ink.setLineDash([]);
      note(ink, line, y, `${(1e3 * kept).toFixed(0)} mm kept`);
    },
    tell(t) {
      const distance = clearance.at(t);
      if (distance >= most - 1e-3) return `nothing within ${(1e3 * most).toFixed(0)} mm`;
      return `${(1e3 * distance).toFixed(1)} mm, from below\n${clearance.nearest(t)}${clearance.steady}`;
    },
  };
}

function frame(ink, line, y) {
  ink.fillStyle = styled("ground");
  ink.fillRect(GUTTER, y, line.width, CURVE);
  ink.lineWidth = 1;
}

function rule(ink, line, y) {
  ink.beginPath();
  ink.moveTo(GUTTER, y);
  ink.lineTo(GUTTER + line.width, y);
  ink.stroke();
}

function note(ink, line, y, text) {
  ink.textAlign = "right";
  ink.fillStyle = styled("quiet");
  ink.fillText(text, GUTTER + line.width - 5, y + 8);
}

/** Rows of a table that are in view, two for each pixel at most: of each pixel the first and the last. */
function visible(times, line) {
  const [a, b] = line.view;
  const first = placeIn(times, a)[0];
  const last = Math.min(placeIn(times, b)[0] + 1, times.length - 1);
  const step = Math.max(1, Math.floor((last - first) / (2 * line.width)));
  const rows = [];
  for (let i = first; i <= last; i += step) rows.push(i);
  return rows;
}

/** Seconds from which two rows belong to two motions. */
function apart(rows) {
  return 0.15 + 0.05 * (rows.length > 1 ? rows[1] - rows[0] : 1);
}

function largest(times, { columns, values }, line) {
  const rows = visible(times, line);
  let most = 0;
  for (let i = rows[0] * columns; i < (rows[rows.length - 1] + 1) * columns; i++) most = Math.max(most, Math.abs(values[i]));
  return most;
}
