// The labels of marks: elements over the canvas, placed so that none covers another.

import type { Vec3 } from "../math/vectors";
import type { CameraRig } from "./camera";

/** A figure and the world point it belongs to. Of two in one place the higher rank stays nearer. */
export interface Anchor {
  key: string;
  point: Vec3;
  text: string;
  kind: "near" | "hit" | "measure";
  rank: number;
}

/** A label in the picture, CSS pixels: its anchor, and its size. */
export interface Figure {
  x: number;
  y: number;
  width: number;
  height: number;
}

const GAP = 4;
// Where a figure may go, in rows above or below its point; tried in this order.
const ROWS = [-1, 1, -2, 2, -3, 3, -4, 4];

/**
 * The upper left corners of `figures` in a picture of `width` x `height` CSS pixels: near their points, inside the picture,
 * not over one another. The first has the first choice. Null where no place was free.
 */
export function layOut(
  figures: readonly Figure[],
  width: number,
  height: number,
): ({ left: number; top: number } | null)[] {
  const taken: { left: number; top: number; right: number; bottom: number }[] = [];
  return figures.map((figure) => {
    if (figure.x < 0 || figure.y < 0 || figure.x > width || figure.y > height) return null;
    for (const row of ROWS) {
      const step = figure.height + GAP;
      const left = Math.max(GAP, Math.min(width - figure.width - GAP, figure.x - figure.width / 2));
      const top = figure.y - figure.height / 2 + row * step;
      const [right, bottom] = [left + figure.width, top + figure.height];
      if (top < GAP || bottom > height - GAP) continue;
      if (
        taken.some((t) => left < t.right + GAP && right + GAP > t.left && top < t.bottom + GAP && bottom + GAP > t.top)
      )
        continue;
      taken.push({ left, top, right, bottom });
      return { left, top };
    }
    return null;
  });
}

/** Keeps one element a figure in `container`, which lies over the canvas. Classes: `mark`, `mark-` + kind. */
export class LabelLayer {
  readonly #container: HTMLElement;
  readonly #elements = new Map<string, { element: HTMLElement; width: number; height: number }>();

  constructor(container: HTMLElement) {
    this.#container = container;
  }

  update(anchors: readonly Anchor[], camera: CameraRig): void {
    const shown = anchors.filter((anchor) => anchor.text !== "").sort((a, b) => b.rank - a.rank);
    const keys = new Set(shown.map((anchor) => anchor.key));
    for (const [key, { element }] of this.#elements) {
      if (keys.has(key)) continue;
      element.remove();
      this.#elements.delete(key);
    }
    const elements = shown.map((anchor) => this.#element(anchor));
    const figures = shown.map((anchor, k) => {
      const at = camera.project(anchor.point);
      const { width, height } = elements[k] as { width: number; height: number };
      return { x: at.isAhead ? at.x : -1, y: at.y, width, height };
    });
    layOut(figures, camera.width, camera.height).forEach((place, k) => {
      const { style } = (elements[k] as { element: HTMLElement }).element;
      style.visibility = place ? "visible" : "hidden";
      if (place) style.transform = `translate(${Math.round(place.left)}px, ${Math.round(place.top)}px)`;
    });
  }

  dispose(): void {
    for (const { element } of this.#elements.values()) element.remove();
    this.#elements.clear();
  }

  #element(anchor: Anchor): { element: HTMLElement; width: number; height: number } {
    let known = this.#elements.get(anchor.key);
    if (!known) {
      const element = document.createElement("span");
      element.style.position = "absolute";
      element.style.left = element.style.top = "0";
      this.#container.append(element);
      known = { element, width: 0, height: 0 };
      this.#elements.set(anchor.key, known);
    }
    const className = `mark mark-${anchor.kind}`;
    if (known.element.textContent !== anchor.text || known.element.className !== className) {
      // Measured only when the text changes: asking for the size makes the browser lay out the page.
      const isLonger =
        known.element.textContent?.length !== anchor.text.length || known.element.className !== className;
      known.element.textContent = anchor.text;
      known.element.className = className;
      if (isLonger || known.width === 0) {
        known.width = known.element.offsetWidth;
        known.height = known.element.offsetHeight;
      }
    }
    return known;
  }
}
