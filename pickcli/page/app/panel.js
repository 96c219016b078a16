// The panel beside the view: facts, what was clicked on, attempts, reasons, score, charts and tables.

export class Panel {
  constructor(element, contents, actions) {
    this.element = element;
    this.actions = actions;
    this.#head(contents);
    this.chosen = this.#add("div");
    this.reasons = this.#add("div");
    if (contents.marks?.length) this.showReasons("Reasons against it", contents.marks);
    if (contents.chapters?.length) this.#chapters(contents.chapters);
    for (const table of contents.tables ?? []) this.#table(table);
    for (const chart of contents.charts ?? []) this.#chart(chart);
    if (contents.pictures?.length) this.#pictures(contents.pictures);
  }

  /** Tells what was clicked on; null for nothing. */
  choose(thing) {
    this.chosen.replaceChildren();
    if (!thing) return;
    const card = node("div", "card", node("h3", "", thing.name.replaceAll("_", " ")));
    card.append(factList([{ label: "is", value: thing.item ? "an item" : thing.kind === "obstacle" ? "an obstacle" : thing.kind === "link" ? "a link of the robot" : thing.kind === "path" ? "a path of the tool" : thing.kind === "configuration" ? "a named configuration" : `part of the ${thing.kind}` }, ...(thing.item?.facts ?? [])]));
    this.chosen.append(node("h2", "", "Chosen"), card);
  }

  /** Lists reasons, of an attempt under its row; a click draws one of them alone. */
  showReasons(title, marks, k = -1) {
    this.reasons.replaceChildren();
    this.chapterRows?.[k]?.after(this.reasons);
    if (!marks.length) return;
    const rows = marks.map((mark) => {
      const row = node("button", `row ${mark.tone ?? ""}`, mark.title);
      if (mark.count > 1) row.prepend(node("span", "end", `${mark.count} times`));
      row.append(node("small", "", mark.detail));
      row.onclick = () => this.actions.showMark(mark);
      return row;
    });
    this.reasons.className = k < 0 ? "" : "inner";
    this.reasons.append(...(title ? [node("h2", "", title)] : []), node("div", "rows", ...rows));
  }

  /** Marks the attempt that is played. */
  setChapter(k) {
    this.chapterRows?.forEach((row, i) => row.classList.toggle("is-now", i === k));
    this.chapterRows?.[k]?.scrollIntoView({ block: "nearest" });
  }

  #head({ title, subtitle, facts = [] }) {
    this.#add("h1", title);
    this.#add("div", subtitle).className = "quiet";
    if (facts.length) this.element.append(factList(facts));
  }

  #chapters(chapters) {
    this.chapterRows = chapters.map((chapter, k) => {
      const row = node("button", `row ${chapter.tone ?? ""}`, node("span", "end", `${chapter.t_start.toFixed(1)} s`), chapter.title);
      row.append(node("small", "", [chapter.outcome, chapter.detail].filter(Boolean).join(": ")));
      row.onclick = () => this.actions.showChapter(k);
      return row;
    });
    this.element.append(node("h2", "", "Attempts"), node("div", "rows", ...this.chapterRows));
  }

  #chart({ title, kinds, bars }) {
    const most = Math.max(...bars.map(({ counts }) => counts.reduce((a, b) => a + b, 0)), 1);
    const rows = bars.flatMap(({ name, counts }) => {
      const total = counts.reduce((a, b) => a + b, 0);
      const bar = node("div", "bar", ...counts.map((count, k) => {
        const part = node("i");
        part.style.cssText = `width:${(100 * count) / most}%;background:${kinds[k][1]}`;
        part.title = `${kinds[k][0]}: ${count}`;
        return part;
      }));
      return [node("span", "", name), bar, node("span", "quiet", String(total))];
    });
    const keys = node("div", "keys", ...kinds.flatMap(([kind, colour]) => {
      const swatch = node("i");
      swatch.style.background = colour;
      return [swatch, kind];
    }));
    this.element.append(node("h2", "", title), node("div", "bars", ...rows), keys);
  }

  #table({ title, columns, rows, tones = [] }) {
    const isNumber = columns.map((_, k) => rows.every((row) => /^[-+−]?[\d.]*( ?[%a-z]+)?$/.test(row[k]) && row[k] !== ""));
    const cell = (tag, text, k) => node(tag, isNumber[k] ? "number" : "", text);
    const head = node("tr", "", ...columns.map((text, k) => cell("th", text, k)));
    const body = rows.map((row, i) => node("tr", tones[i] ?? "", ...row.map((text, k) => cell("td", text, k))));
    this.element.append(node("h2", "", title), node("table", "", node("thead", "", head), node("tbody", "", ...body)));
  }

  /** Small pictures; a click shows one of them as wide as the window. */
  #pictures(pictures) {
    const figures = pictures.map(({ title, data }) => {
      const image = node("img");
      image.src = data;
      image.alt = title;
      const large = node("dialog", "picture", image.cloneNode());
      large.onclick = () => large.close();
      image.onclick = () => large.showModal();
      return node("figure", "", node("figcaption", "quiet", title), image, large);
    });
    this.element.append(node("h2", "", "Pictures of looks"), ...figures);
  }

  #add(tag, text = "") {
    return this.element.appendChild(node(tag, "", text));
  }
}

function factList(facts) {
  const list = node("dl");
  for (const { label, value, tone } of facts) list.append(node("dt", "", label ?? ""), node("dd", tone ?? "", value));
  return list;
}

/** An element with a class and children; text is never read as HTML. */
export function node(tag, style = "", ...children) {
  const element = document.createElement(tag);
  if (style.trim()) element.className = style.trim();
  element.append(...children.filter((child) => child !== ""));
  return element;
}
