// The labels of marks: elements over the canvas, placed so that none covers another, the gizmo or the page's own controls.
// A line leads from a label to the point that it belongs to.

import type { Vec3 } from "../math/vectors";
import type { CameraRig } from "./camera";

/** A figure and the world point it belongs to. Of two in one place the higher rank stays nearer. */
export interface Anchor {
  key: string;
  point: Vec3;
  text: string;
  kind: "near" | "hit" | "measure" | "hand" | `person-${number}`;
  rank: number;
}

/** A label in the picture, CSS pixels: its anchor, and its size. */
export interface Figure {
  x: number;
  y: number;
  width: number;
  height: number;
  /** From its point to its upper left corner in the last picture: where it stays if it can. */
  before?: Offset | null;
}

/** A rectangle of the picture, from its upper left corner. */
export interface Area {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

export interface Offset {
  dx: number;
  dy: number;
}

/** What labels keep clear of: always, and where there is room. */
export interface Taken {
  always: readonly Area[];
  better: readonly Area[];
}

const GAP = 4;
// How far the middle of a label may be from its point, beyond half its own size, and in which directions; in this order.
const REACHES = [10, 34, 60, 90, 130, 180];
const WAYS: readonly (readonly [number, number])[] = [
  [0, -1],
  [0, 1],
  [1, -0.6],
  [-1, -0.6],
  [1, 0.6],
  [-1, 0.6],
  [1, 0],
  [-1, 0],
];
// A label this near to its point needs no line.
const LEAST_LEAD = 7;

export const NOTHING_TAKEN: Taken = { always: [], better: [] };

const doOverlap = (a: Area, b: Area, gap: number): boolean =>
  a.left < b.right + gap && b.left < a.right + gap && a.top < b.bottom + gap && b.top < a.bottom + gap;

/**
 * The upper left corners of `figures` in a picture of `width` x `height` CSS pixels: near their points, inside the picture,
 * not over one another nor over what is taken. The first has the first choice. Null where no place was free.
 */
export function layOut(
  figures: readonly Figure[],
  width: number,
  height: number,
  taken: Taken = NOTHING_TAKEN,
): ({ left: number; top: number } | null)[] {
  const placed: Area[] = [];
  return figures.map((figure) => {
    if (figure.x < 0 || figure.y < 0 || figure.x > width || figure.y > height) return null;
    const places = [...candidates(figure, width, height)];
    const isFree = (area: Area, others: readonly Area[]) =>
      area.top >= GAP && area.bottom <= height - GAP && !others.some((other) => doOverlap(area, other, GAP));
    const clear = [...placed, ...taken.always];
    const found =
      places.find((area) => isFree(area, [...clear, ...taken.better])) ?? places.find((area) => isFree(area, clear));
    if (!found) return null;
    placed.push(found);
    return { left: found.left, top: found.top };
  });
}

function* candidates({ x, y, width, height, before }: Figure, most: number, tall: number): Generator<Area> {
  const area = (left: number, top: number): Area => {
    const within = Math.max(GAP, Math.min(most - width - GAP, left));
    const down = Math.max(GAP, Math.min(tall - height - GAP, top));
    return { left: within, top: down, right: within + width, bottom: down + height };
  };
  if (before) yield area(x + before.dx, y + before.dy);
  for (const reach of REACHES)
    for (const [right, down] of WAYS)
      yield area(
        x - width / 2 + right * (reach + (right === 0 ? 0 : width / 2)),
        y - height / 2 + down * (reach + height / 2),
      );
}

/** The most pixels of a label's text: names of strangers would cover the picture. */
export const MOST_TEXT_PX = 240;

/** A text that is at most so wide, cut in the middle: names often differ at their ends. By letters, not by halves of one. */
export function cutMiddle(text: string, most: number, widthOf: (text: string) => number): string {
  if (widthOf(text) <= most) return text;
  const letters = Array.from(text);
  const kept = (count: number): string => {
    const tail = Math.floor(count / 2);
    return `${letters.slice(0, count - tail).join("")}…${tail > 0 ? letters.slice(-tail).join("") : ""}`;
  };
  let [fits, breaks] = [0, letters.length];
  while (breaks - fits > 1) {
    const middle = (fits + breaks) >> 1;
    if (widthOf(kept(middle)) <= most) fits = middle;
    else breaks = middle;
  }
  return kept(fits);
}

/** Texts that are shorter than this are never wide. */
const SURELY_NARROW = 12;

interface Shown {
  text: string;
  element: HTMLElement;
  lead: HTMLElement;
  width: number;
  height: number;
  before: Offset | null;
}

/** What labels of a class have in common: pixels around the text, and of the whole height. */
interface Look {
  font: string;
  around: number;
  height: number;
}

/** Keeps one element a figure in `container`, which lies over the canvas. Classes: `mark`, `mark-` + kind; `lead`. */
export class LabelLayer {
  readonly #container: HTMLElement;
  readonly #elements = new Map<string, Shown>();
  readonly #looks = new Map<string, Look>();
  readonly #ruler = document.createElement("canvas").getContext("2d");

  constructor(container: HTMLElement) {
    this.#container = container;
  }

  update(anchors: readonly Anchor[], camera: CameraRig, taken: Taken): void {
    const shown = anchors.filter((anchor) => anchor.text !== "").sort((a, b) => b.rank - a.rank);
    const keys = new Set(shown.map((anchor) => anchor.key));
    for (const [key, { element, lead }] of this.#elements) {
      if (keys.has(key)) continue;
      element.remove();
      lead.remove();
      this.#elements.delete(key);
    }
    const elements = shown.map((anchor) => this.#element(anchor));
    const figures = shown.map((anchor, k) => {
      const at = camera.project(anchor.point);
      const { width, height, before } = elements[k] as Shown;
      return { x: at.isAhead ? at.x : -1, y: at.y, width, height, before };
    });
    layOut(figures, camera.width, camera.height, taken).forEach((place, k) => {
      show(elements[k] as Shown, figures[k] as Figure, place);
    });
  }

  dispose(): void {
    for (const { element, lead } of this.#elements.values()) {
      element.remove();
      lead.remove();
    }
    this.#elements.clear();
  }

  #element(anchor: Anchor): Shown {
    let known = this.#elements.get(anchor.key);
    if (!known) {
      const [element, lead] = [document.createElement("span"), document.createElement("span")];
      for (const each of [element, lead]) {
        each.style.position = "absolute";
        each.style.left = each.style.top = "0";
      }
      // Lines below all labels.
      this.#container.prepend(lead);
      this.#container.append(element);
      known = { text: "", element, lead, width: 0, height: 0, before: null };
      this.#elements.set(anchor.key, known);
    }
    const className = `mark mark-${anchor.kind}`;
    if (known.text !== anchor.text || known.element.className !== className) {
      known.text = anchor.text;
      known.element.className = className;
      known.lead.className = `lead lead-${anchor.kind}`;
      this.#write(known);
    }
    return known;
  }

  /** Writes the text, cut if it is wide, and its size. The browser is asked once a class: it lays out the page for that. */
  #write(shown: Shown): void {
    const { element, text } = shown;
    const ruler = this.#ruler;
    const look = this.#looks.get(element.className);
    if (ruler) ruler.font = look?.font ?? getComputedStyle(element).font;
    const widthOf = (each: string) => ruler?.measureText(each).width ?? 0;
    const written = ruler && text.length > SURELY_NARROW ? cutMiddle(text, MOST_TEXT_PX, widthOf) : text;
    element.textContent = written;
    if (ruler && look) {
      shown.width = Math.ceil(widthOf(written)) + look.around;
      shown.height = look.height;
      return;
    }
    shown.width = element.offsetWidth;
    shown.height = element.offsetHeight;
    if (!ruler || shown.width === 0) return;
    const around = Math.max(0, shown.width - Math.floor(widthOf(written)));
    this.#looks.set(element.className, { font: ruler.font, around, height: shown.height });
  }
}

function show(shown: Shown, { x, y, width, height }: Figure, place: { left: number; top: number } | null): void {
  const { element, lead } = shown;
  element.style.visibility = place ? "visible" : "hidden";
  shown.before = place && { dx: place.left - x, dy: place.top - y };
  if (place) element.style.transform = `translate(${Math.round(place.left)}px, ${Math.round(place.top)}px)`;
  // From the point to the nearest place of the label.
  const toX = place ? Math.min(Math.max(x, place.left), place.left + width) : x;
  const toY = place ? Math.min(Math.max(y, place.top), place.top + height) : y;
  const far = Math.hypot(toX - x, toY - y);
  const isLed = place !== null && far > LEAST_LEAD;
  lead.style.visibility = isLed ? "visible" : "hidden";
  if (!isLed) return;
  lead.style.width = `${far.toFixed(1)}px`;
  lead.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) rotate(${Math.atan2(toY - y, toX - x).toFixed(4)}rad)`;
}
