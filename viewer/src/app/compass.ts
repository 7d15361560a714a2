// The view cube, the triad of axes, the scale bar and the legend of the heat map: repainted when the camera, the
// unit or the theme is another one.

import type { Workbench } from "../actions/workbench";
import {
  CUBE_PX,
  drawCube,
  drawTriad,
  hitCube,
  isSameSide,
  layCube,
  nearestSide,
  neighbourSide,
  sideName,
  TRIAD_PX,
} from "../input/view-cube";
import { HEAT_REACH_M } from "../math/heat-field";
import { scaleBar } from "../math/scale-bar";
import { formatLength, type Unit } from "../math/units";
import type { Point, Vec3 } from "../math/vectors";

/** The elements they are painted on. */
export interface CompassElements {
  /** A button, with the cube's canvas in it. */
  readonly cube: HTMLButtonElement;
  readonly triad: HTMLCanvasElement;
  readonly scale: HTMLElement;
  /** What the colours of the heat map mean. */
  readonly legend: HTMLElement;
}

const SCALE_PX = 130;
/** A picture smaller than this has no room for them. */
const LEAST_WIDTH = 340;
const LEAST_HEIGHT = 260;
/** A press on the cube that moves more than this turns the view. */
const CLICK_PX = 3;
const TURN_PER_PX = 0.012;

const KEYS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowRight: [1, 0],
  ArrowLeft: [-1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

export class Compass {
  private painted = "";
  /** The side under the pointer. */
  private lit: Vec3 | null = null;
  private pressed: { at: Point; isDrag: boolean } | null = null;

  constructor(
    private readonly wb: Workbench,
    private readonly over: CompassElements,
  ) {
    const { cube } = over;
    cube.addEventListener("pointerdown", (event) => this.press(event));
    cube.addEventListener("pointermove", (event) => this.move(event));
    cube.addEventListener("pointerup", () => {
      // The click that follows belongs to the press: it is looked at there.
      setTimeout(() => {
        this.pressed = null;
      });
    });
    cube.addEventListener("pointercancel", () => {
      this.pressed = null;
    });
    cube.addEventListener("pointerleave", () => this.light(null));
    cube.addEventListener("click", (event) => this.click(event));
    cube.addEventListener("keydown", (event) => this.key(event));
  }

  paint(): void {
    const { store, stage } = this.wb;
    const { camera } = stage;
    const isShown = store.manifest.peek() !== null && camera.width >= LEAST_WIDTH && camera.height >= LEAST_HEIGHT;
    const theme = store.theme.peek();
    const unit = store.unit.peek();
    const heat = stage.heatAccuracy;
    const key = isShown
      ? [
          ...camera.right,
          ...camera.top,
          camera.reach,
          camera.height,
          camera.isParallel,
          unit,
          theme,
          heat,
          this.lit,
        ].join()
      : "";
    if (key === this.painted) return;
    this.painted = key;
    const { cube, triad, scale } = this.over;
    for (const each of [cube, triad, scale, this.over.legend]) each.hidden = !isShown;
    if (!isShown) return;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const canvas = cube.firstElementChild as HTMLCanvasElement;
    const onCube = contextOf(canvas, CUBE_PX, ratio);
    if (onCube) drawCube(onCube, camera, this.wb.up, this.lit, theme, ratio);
    const onTriad = contextOf(triad, TRIAD_PX, ratio);
    if (onTriad) drawTriad(onTriad, camera, theme, ratio);
    const bar = scaleBar(camera.metresPerPixel(camera.reach), SCALE_PX, unit);
    scale.hidden = !bar;
    this.paintLegend(heat, unit);
    if (!bar) return;
    scale.style.width = `${bar.width_px.toFixed(1)}px`;
    scale.textContent = camera.isParallel ? bar.text : `≈ ${bar.text}`;
    scale.title = camera.isParallel
      ? "Exact everywhere in the picture: parallel projection"
      : "At the depth of the point that the view turns about; nearer things look larger. Press O for parallel projection.";
  }

  private paintLegend(accuracy: number | null, unit: Unit): void {
    const { legend } = this.over;
    legend.hidden = accuracy === null;
    if (accuracy === null) return;
    const reach = formatLength(HEAT_REACH_M, unit);
    legend.textContent = `0 – ${reach} from the tool`;
    legend.title = `Visible surfaces within ${reach} of the tool, by their distance to it; a line every ${formatLength(HEAT_REACH_M / 4, unit)}. Accurate to about ${formatLength(accuracy, unit)}; the figures at the lines are exact.`;
  }

  private press(event: PointerEvent): void {
    if (event.button !== 0) return;
    this.pressed = { at: { x: event.clientX, y: event.clientY }, isDrag: false };
    this.over.cube.setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    const { pressed } = this;
    if (!pressed) {
      this.light(hitCube(layCube(this.wb.stage.camera, this.wb.up), { x: event.offsetX, y: event.offsetY }));
      return;
    }
    const [dx, dy] = [event.clientX - pressed.at.x, event.clientY - pressed.at.y];
    if (!pressed.isDrag && Math.hypot(dx, dy) <= CLICK_PX) return;
    const { camera } = this.wb.stage;
    camera.orbit(dx * TURN_PER_PX, dy * TURN_PER_PX, camera.arrived.target);
    this.pressed = { at: { x: event.clientX, y: event.clientY }, isDrag: true };
    this.light(null);
    this.wb.redraw();
  }

  private click(event: MouseEvent): void {
    const { camera } = this.wb.stage;
    // By a key there is no place: the nearest side then.
    const isKey = event.detail === 0;
    if (!isKey && this.pressed?.isDrag) return;
    const at = { x: event.offsetX, y: event.offsetY };
    const side = isKey ? nearestSide(camera.arrived, this.wb.up) : hitCube(layCube(camera, this.wb.up), at);
    if (side) this.go(side);
  }

  private key(event: KeyboardEvent): void {
    const way = KEYS[event.key];
    if (!way || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    event.stopPropagation();
    const { camera } = this.wb.stage;
    this.go(neighbourSide(nearestSide(camera.arrived, this.wb.up), ...way));
  }

  private go(side: Vec3): void {
    this.wb.viewFrom(side);
    const name = sideName(side);
    this.over.cube.setAttribute("aria-label", `View cube: ${name}`);
    this.wb.say(`View: ${name}`);
  }

  private light(side: Vec3 | null): void {
    if (isSameSide(side, this.lit)) return;
    this.lit = side;
    this.over.cube.title = side ? `View from: ${sideName(side)}` : CUBE_HINT;
    this.wb.redraw();
  }
}

export const CUBE_HINT = "View cube: click a face, an edge or a corner; drag to turn; arrow keys";

function contextOf(canvas: HTMLCanvasElement, size_px: number, ratio: number): CanvasRenderingContext2D | null {
  const size = Math.round(size_px * ratio);
  if (canvas.width !== size) canvas.width = canvas.height = size;
  return canvas.getContext("2d");
}

/** Makes the elements. */
export function makeCompass(): CompassElements {
  const cube = document.createElement("button");
  cube.type = "button";
  cube.className = "view-cube";
  cube.hidden = true;
  cube.title = CUBE_HINT;
  cube.setAttribute("aria-label", "View cube");
  const canvas = document.createElement("canvas");
  canvas.setAttribute("aria-hidden", "true");
  cube.append(canvas);
  const triad = document.createElement("canvas");
  triad.className = "triad";
  triad.hidden = true;
  triad.setAttribute("aria-hidden", "true");
  const scale = document.createElement("div");
  scale.className = "scale-bar";
  scale.hidden = true;
  const legend = document.createElement("div");
  legend.className = "heat-legend";
  legend.hidden = true;
  return { cube, triad, scale, legend };
}
