// The handles over the picture, repainted only when they change: the gizmo those of the cuts, the
// view cube with the triad and the scale bar.

import type { Workbench } from "../actions/workbench";
import { type CutHandle, drawCuts } from "../input/cuts";
import { drawGizmo, GIZMO_RADIUS_PX, type Handle } from "../input/gizmo";
import type { Pointer } from "../input/mouse";
import { Compass, type CompassElements } from "./compass";

/** The elements they are painted on. */
export interface HandleElements extends CompassElements {
  readonly gizmo: HTMLCanvasElement;
  readonly cuts: HTMLElement;
}

export class Handles {
  private gizmo_drawn = "";
  private cuts_drawn = "";
  private readonly compass: Compass;

  constructor(
    wb: Workbench,
    private readonly pointer: Pointer,
    private readonly over: HandleElements,
  ) {
    this.compass = new Compass(wb, over);
  }

  paint(): void {
    this.paintGizmo();
    this.paintCuts();
    this.compass.paint();
  }

  private paintGizmo(): void {
    const { pointer } = this;
    const { gizmo } = this.over;
    const context = gizmo.getContext("2d");
    if (!context) return;
    const handles = pointer.handles();
    const middle = handles[0]?.line[0];
    const key = middle ? describe(handles, pointer.handle) : "";
    if (key === this.gizmo_drawn) return;
    this.gizmo_drawn = key;
    gizmo.hidden = !middle;
    if (!middle) return;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const size = Math.round(2 * GIZMO_RADIUS_PX * ratio);
    if (gizmo.width !== size) gizmo.width = gizmo.height = size;
    gizmo.style.transform = `translate(${middle.x - GIZMO_RADIUS_PX}px, ${middle.y - GIZMO_RADIUS_PX}px)`;
    drawGizmo(context, handles, pointer.handle, ratio);
  }

  private paintCuts(): void {
    const { over, pointer } = this;
    const handles = pointer.cuts();
    const key = `${pointer.cut}|${handles.map(describeCut).join(";")}`;
    if (key === this.cuts_drawn) return;
    this.cuts_drawn = key;
    drawCuts(over.cuts, handles, pointer.cut);
  }
}

const describeCut = ({ id, line: [a, b] }: CutHandle): string =>
  `${id},${[a.x, a.y, b.x, b.y].map((value) => value.toFixed(1)).join()}`;

const describe = (handles: readonly Handle[], lit: Handle | null): string =>
  `${lit?.kind}${lit?.axis}|${handles.map(({ line }) => `${line[0]?.x.toFixed(1)},${line[0]?.y.toFixed(1)},${line.at(-1)?.x.toFixed(1)},${line.at(-1)?.y.toFixed(1)}`).join(";")}`;
