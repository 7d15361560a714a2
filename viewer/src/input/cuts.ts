// Handles of the cuts: an arrow at each, along its normal, to drag it. Laid out and hit in the picture's
// pixels; drawn as elements over it.

import { add, type Box, centre, dot, isEmpty, type Point, scale, type Vec3 } from "../math/vectors";
import { BOX_FACES, type BoxFace, boxPlanes } from "../model/sections";
import { clipBox, planeInBox, type SectionPlane } from "../scene/sections";
import { distanceToLine, type GizmoView } from "./gizmo";

export interface CutHandle {
  /** Of the cut; a face of the section box: -1 for the first one, and so on down. */
  readonly id: number;
  readonly normal: Vec3;
  readonly offset: number;
  /** On the cut, world. */
  readonly center: Vec3;
  /** Where the arrow lies, pixels of the picture, from one tip to the other. */
  readonly line: readonly [Point, Point];
}

export type CutPlane = SectionPlane & { readonly id: number };

const ARROW_PX = 34;
/** An arrow that points at the eye is drawn upright: up and down then moves the cut. */
const LEAST_PX = 12;
const REACH_PX = 11;

/** The middle of `box` in a cut, clipped by the other cuts; beside the box, the point on the cut nearest to it. */
export function cutCenter(cut: SectionPlane, others: readonly SectionPlane[], box: Box): Vec3 {
  const left = clipBox(box, others);
  const polygon = isEmpty(left) ? [] : planeInBox(cut, left);
  if (polygon.length > 0) return scale(polygon.reduce(add, [0, 0, 0] as Vec3), 1 / polygon.length);
  const middle = centre(box);
  return add(middle, scale(cut.normal, cut.offset - dot(cut.normal, middle)));
}

/** The handles of the cuts that are drawn, and of the faces of the section box; none of those behind the eye. */
export function layCuts(
  cuts: readonly CutPlane[],
  box: Box,
  view: GizmoView,
  sectionBox: Box | null = null,
): CutHandle[] {
  const faces = sectionBox ? boxPlanes(sectionBox) : [];
  const handles = isEmpty(box)
    ? []
    : cuts.flatMap((cut) => {
        const others = [...cuts.filter((each) => each.id !== cut.id), ...faces];
        return layArrow(cut, cutCenter(cut, others, box), view);
      });
  if (!sectionBox) return handles;
  return [
    ...handles,
    ...BOX_FACES.flatMap((face) => {
      const { normal, offset } = faces[face] as SectionPlane;
      const middle = centre(sectionBox);
      const center = add(middle, scale(normal, offset - dot(normal, middle)));
      const outward = scale(normal, -1);
      return layArrow({ id: -1 - face, normal, offset }, center, view, outward);
    }),
  ];
}

/** The face of the section box that a handle moves; null: it moves a cut. */
export const faceOf = ({ id }: Pick<CutHandle, "id">): BoxFace | null => (id < 0 ? ((-1 - id) as BoxFace) : null);

/** `outward`: the arrow begins in the middle and points there, so that those of a small box stay apart. */
function layArrow(
  { id, normal, offset }: CutPlane,
  center: Vec3,
  view: GizmoView,
  outward: Vec3 | null = null,
): CutHandle[] {
  const middle = view.project(center);
  if (!middle.isAhead) return [];
  const tip = view.project(add(center, scale(outward ?? normal, ARROW_PX * view.metresPerPixel(middle.depth))));
  let [dx, dy] = [tip.x - middle.x, tip.y - middle.y];
  if (Math.hypot(dx, dy) < LEAST_PX) [dx, dy] = [0, -ARROW_PX];
  const line: [Point, Point] = [
    outward ? { x: middle.x, y: middle.y } : { x: middle.x - dx, y: middle.y - dy },
    { x: middle.x + dx, y: middle.y + dy },
  ];
  return [{ id, normal, offset, center, line }];
}

/** The handle at a pixel: the nearest within reach. */
export function hitCut(handles: readonly CutHandle[], at: Point): CutHandle | null {
  let found: CutHandle | null = null;
  let nearest = REACH_PX;
  for (const handle of handles) {
    const distance = distanceToLine(handle.line, at);
    if (distance > nearest) continue;
    nearest = distance;
    found = handle;
  }
  return found;
}

/** Puts an arrow for each handle into `place`; `lit`: the one under the pointer. */
export function drawCuts(place: HTMLElement, handles: readonly CutHandle[], lit: number | null): void {
  while (place.children.length > handles.length) place.lastElementChild?.remove();
  for (const [k, { id, line }] of handles.entries()) {
    let arrow = place.children[k] as HTMLElement | undefined;
    if (!arrow) {
      arrow = document.createElement("div");
      place.append(arrow);
    }
    const [from, to] = line;
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    arrow.className = `cut-arrow${id < 0 ? " of-face" : ""}${id === lit ? " lit" : ""}`;
    arrow.dataset.cut = String(id);
    arrow.style.width = `${Math.hypot(dx, dy)}px`;
    arrow.style.transform = `translate(${from.x}px, ${from.y}px) rotate(${Math.atan2(dy, dx)}rad)`;
  }
}
