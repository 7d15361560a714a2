// Measuring by clicks: the picks of a measure, the point under the pointer, and the final command.

import type { Commands, MeasureType, Snapped } from "../link/protocol";
import { add, distance, dot, type Point, scale, subtract, type Vec3 } from "../math/vectors";
import type { MeasurePick } from "../model/store";
import type { Workbench } from "./workbench";

/** The prompts of each measure, pick by pick. */
export const PICKS: Readonly<Record<MeasureType, readonly string[]>> = {
  point: ["Click the first point", "Click the second point"],
  edge: ["Click near an edge"],
  angle: ["Click the first face", "Click the second face"],
  parts: ["Click the first part", "Click the second part"],
};

export const MEASURE_TITLES: Readonly<Record<MeasureType, string>> = {
  point: "Point to point",
  edge: "Edge",
  angle: "Angle",
  parts: "Part to part",
};

/** The pick under a pixel, as measuring needs it. */
type Seen = Pick<Snapped, "point" | "type" | "part" | "triangle" | "corners">;

/** How near in the picture a corner or an edge draws the point to it. */
const SNAP_PX = 10;

/** Begins a measure, or ends measuring if the same one is active. */
export function startMeasuring(wb: Workbench, type: MeasureType): void {
  const { measuring, panel } = wb.store;
  if (measuring.peek()?.type === type) {
    stopMeasuring(wb);
    return;
  }
  measuring.value = { type, picks: [] };
  panel.value = "measures";
  wb.say(PICKS[type][0] ?? "");
}

/** Begins point to point with the first point at a pixel. */
export async function measureFrom(wb: Workbench, at: Point): Promise<void> {
  if (wb.store.measuring.peek()) stopMeasuring(wb);
  startMeasuring(wb, "point");
  await clickMeasure(wb, at);
}

export function stopMeasuring(wb: Workbench): void {
  wb.store.measuring.value = null;
  wb.store.snap.value = null;
  wb.redraw();
}

let is_asking = false;

/** Shows the pick of a click; one question at a time, so that a slow answer delays nothing. */
export function hoverMeasure(wb: Workbench, at: Point): void {
  if (!wb.store.measuring.peek() || is_asking) return;
  is_asking = true;
  snapAt(wb, at)
    .then((snapped) => {
      if (wb.store.measuring.peek()) wb.store.snap.value = snapped && { point: snapped.point, type: snapped.type };
      wb.redraw();
    })
    .catch(() => {
      wb.store.snap.value = null;
    })
    .finally(() => {
      is_asking = false;
    });
}

/** Takes the pick under the pointer; the last pick makes the measure. */
export async function clickMeasure(wb: Workbench, at: Point): Promise<void> {
  try {
    const snapped = await snapAt(wb, at);
    if (snapped) await takePick(wb, pickOf(snapped));
    else wb.say("Nothing to measure there");
  } catch (error) {
    wb.tell(error);
  }
}

async function takePick(wb: Workbench, pick: MeasurePick): Promise<void> {
  const now = wb.store.measuring.peek();
  if (!now) return;
  const picks = [...now.picks, pick];
  const next = PICKS[now.type][picks.length];
  if (next !== undefined) {
    wb.store.measuring.value = { ...now, picks };
    wb.say(next);
    return;
  }
  wb.store.measuring.value = { ...now, picks: [] };
  const done = await wb.run("measure_add", measureArgs(now.type, picks));
  const made = wb.document?.measures.at(-1);
  if (done && made) wb.say(`${made.name} measured`);
}

const pickOf = ({ part, triangle, point, corners }: Seen): MeasurePick => ({
  part,
  triangle,
  point,
  edge: nearestEdge(corners, point),
});

/** The edge of a triangle that is nearest to a point in its plane. */
export function nearestEdge(corners: readonly [Vec3, Vec3, Vec3], point: Vec3): [Vec3, Vec3] {
  const edges: [Vec3, Vec3][] = [
    [corners[0], corners[1]],
    [corners[1], corners[2]],
    [corners[2], corners[0]],
  ];
  const away = ([start, end]: [Vec3, Vec3]): number => {
    const along = subtract(end, start);
    const share = dot(subtract(point, start), along) / Math.max(dot(along, along), Number.MIN_VALUE);
    return distance(point, add(start, scale(along, Math.min(1, Math.max(0, share)))));
  };
  return edges.reduce((best, edge) => (away(edge) < away(best) ? edge : best));
}

/** The arguments of `measure_add`. */
export function measureArgs(type: MeasureType, picks: readonly MeasurePick[]): Commands["measure_add"] {
  switch (type) {
    case "point":
      return { type, points: picks.map((pick) => pick.point) };
    case "edge":
      return { type, points: picks[0]?.edge ?? [] };
    case "angle":
      return { type, triangles: picks.map((pick) => pick.triangle) };
    case "parts":
      return { type, parts: picks.map((pick) => pick.part) };
  }
}

/** Without a server: the point by the picture's depth, on no face that is known. */
const seenAt = (part: number, point: Vec3): Seen => ({
  point,
  type: "face",
  part,
  triangle: -1,
  corners: [point, point, point],
});

/** The exact point that a pixel sees, drawn to a corner or an edge that is near it in the picture. */
async function snapAt(wb: Workbench, at: Point): Promise<Seen | null> {
  const { camera } = wb.stage;
  if ((wb.document?.explode ?? 0) > 0) throw new Error("The view is exploded: put the mock-up together to measure it");
  const picked = wb.stage.pick(at.x, at.y);
  if (!picked) return null;
  if (!wb.link) return picked.held ? null : seenAt(picked.part, picked.point);
  const { origin, direction } = camera.ray(at.x, at.y);
  const within = SNAP_PX * camera.metresPerPixel(camera.project(picked.point).depth);
  return wb.ask("snap", { origin, direction, within });
}
