// The handles over the picture, repainted only when they change: the gizmo those of the cuts, the
// view cube with the triad and the scale bar.

import type { Workbench } from "../actions/workbench";
import { type CutHandle, drawCuts } from "../input/cuts";
import { drawGizmo, GIZMO_RADIUS_PX, type Handle } from "../input/gizmo";
import { areaOf, edgeArrow, pointsOf, slices } from "../input/gizmo-place";
import type { Pointer } from "../input/mouse";
import type { Point } from "../math/vectors";
import type { Area, Taken } from "../scene/labels";
import { Compass, type CompassElements } from "./compass";

/** The elements they are painted on. */
export interface HandleElements extends CompassElements {
  readonly gizmo: HTMLCanvasElement;
  /** The line from the gizmo to the point that it moves. */
  readonly tether: HTMLElement;
  /** The arrow at the picture's edge to a tool out of it: a button. */
  readonly arrow: HTMLButtonElement;
  readonly cuts: HTMLElement;
}

/** The page's controls over the picture. */
const CONTROLS = ".toolbar, .view-cube, .triad, .scale-bar, .heat-legend";
const MEASURED_MS = 500;
/** Room for the letters of the gizmo. */
const LETTER_PX = 22;
const ARROW_PX = 44;
const ARROW_MARGIN_PX = 30;

export class Handles {
  private gizmo_drawn = "";
  private cuts_drawn = "";
  private arrow_drawn = "";
  private readonly compass: Compass;

  private taken: { areas: readonly Area[]; time_ms: number } = { areas: [], time_ms: -Infinity };

  constructor(
    private readonly wb: Workbench,
    private readonly pointer: Pointer,
    private readonly over: HandleElements,
  ) {
    this.compass = new Compass(wb, over);
    pointer.taken = () => this.controls();
    wb.stage.taken = () => this.takenOfLabels();
    over.arrow.addEventListener("click", () => wb.lookAtTool());
  }

  paint(): void {
    this.paintGizmo();
    this.paintCuts();
    this.paintArrow();
    this.compass.paint();
  }

  /** At the begin of a frame, before anything changes the page: to measure later would lay it out once more. */
  measure(): void {
    const now = performance.now();
    if (now - this.taken.time_ms >= MEASURED_MS) this.taken = { areas: this.measured(), time_ms: now };
  }

  /** Where the page's own controls lie over the picture; measured now and then. */
  private controls(): readonly Area[] {
    if (this.taken.time_ms === Number.NEGATIVE_INFINITY) this.measure();
    return this.taken.areas;
  }

  private measured(): readonly Area[] {
    const picture = this.over.gizmo.parentElement?.getBoundingClientRect();
    const found = this.over.gizmo.closest(".picture")?.querySelectorAll(CONTROLS) ?? [];
    const areas = [...found].map((each) => {
      const { left, top, right, bottom } = each.getBoundingClientRect();
      const [x, y] = [picture?.left ?? 0, picture?.top ?? 0];
      return { left: left - x, top: top - y, right: right - x, bottom: bottom - y };
    });
    return areas.filter(({ left, right }) => right > left);
  }

  private takenOfLabels(): Taken {
    const { camera } = this.wb.stage;
    const { pose } = this.wb.hand;
    const handles = this.pointer.handles();
    const gizmo = areaOfLines(handles.map(({ line }) => line));
    const tool = pose ? slices(this.wb.stage.heldCorners(pose)) : [];
    const better = tool.flatMap((slice) => areaOf(pointsOf(slice, camera)) ?? []);
    return { always: [...this.controls(), ...(gizmo ? [gizmo] : [])], better };
  }

  private paintGizmo(): void {
    const { pointer } = this;
    const { gizmo } = this.over;
    const context = gizmo.getContext("2d");
    if (!context) return;
    const handles = pointer.handles();
    const middle = handles[0]?.line[0];
    const { dx: aside, dy: down } = pointer.place_of_gizmo;
    const key = middle ? `${describe(handles, pointer.handle)}|${aside.toFixed(1)},${down.toFixed(1)}` : "";
    if (key === this.gizmo_drawn) return;
    this.gizmo_drawn = key;
    gizmo.hidden = !middle;
    const { dx, dy } = pointer.place_of_gizmo;
    const far = Math.hypot(dx, dy);
    this.over.tether.hidden = !middle || far < 12;
    if (!middle) return;
    // From the knob to the tool.
    this.over.tether.style.width = `${far}px`;
    this.over.tether.style.transform = `translate(${middle.x}px, ${middle.y}px) rotate(${Math.atan2(-dy, -dx)}rad)`;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const size = Math.round(2 * GIZMO_RADIUS_PX * ratio);
    if (gizmo.width !== size) gizmo.width = gizmo.height = size;
    gizmo.style.transform = `translate(${middle.x - GIZMO_RADIUS_PX}px, ${middle.y - GIZMO_RADIUS_PX}px)`;
    drawGizmo(context, handles, pointer.handle, ratio);
  }

  private paintArrow(): void {
    const { camera } = this.wb.stage;
    const target = this.pointer.outOfSight();
    const at = target && edgeArrow(target, camera, ARROW_MARGIN_PX, this.controls());
    const key = at ? `${at.x.toFixed(1)},${at.y.toFixed(1)},${at.angle.toFixed(3)}` : "";
    if (key === this.arrow_drawn) return;
    this.arrow_drawn = key;
    const { arrow } = this.over;
    arrow.hidden = !at;
    if (!at) return;
    arrow.style.transform = `translate(${at.x - ARROW_PX / 2}px, ${at.y - ARROW_PX / 2}px)`;
    const icon = arrow.firstElementChild as HTMLElement;
    icon.style.transform = `rotate(${at.angle}rad)`;
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

/** The rectangle around lines of pixels; null for none. */
function areaOfLines(lines: readonly (readonly Point[])[]): Area | null {
  const area = areaOf(lines.flat());
  return (
    area && {
      left: area.left - LETTER_PX,
      right: area.right + LETTER_PX,
      top: area.top - LETTER_PX,
      bottom: area.bottom + LETTER_PX,
    }
  );
}
