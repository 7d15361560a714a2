// Sections as numbers: their axis, their range, which are drawn. Pure.

import type { Section } from "../link/protocol";
import { type Box, distance, isEmpty, type Vec3 } from "../math/vectors";

/** The world axis nearest to the view direction, pointing away from the eye: the near side is cut away. */
export function axisAlong(forward: Vec3): Vec3 {
  const sizes = forward.map(Math.abs);
  const k = sizes.indexOf(Math.max(...sizes));
  const normal: Vec3 = [0, 0, 0];
  normal[k] = Math.sign(forward[k] ?? 1) || 1;
  return normal;
}

/** 1 if a cut keeps the far side along its axis, -1 for the near side: `sense * offset` is its place on the axis. */
export function senseOf(normal: Vec3): 1 | -1 {
  const sizes = normal.map(Math.abs);
  return (normal[sizes.indexOf(Math.max(...sizes))] ?? 0) < 0 ? -1 : 1;
}

/** The least and the greatest offset at which a cut across `normal` meets the mock-up. */
export function offsetRange(lower: Vec3, upper: Vec3, normal: Vec3): [number, number] {
  let least = 0;
  let most = 0;
  for (const k of [0, 1, 2] as const) {
    const ends = [normal[k] * lower[k], normal[k] * upper[k]];
    least += Math.min(...ends);
    most += Math.max(...ends);
  }
  return [least, most];
}

/** The drawn cuts: the active ones, the dragged one at its dragged place. */
export function drawnSections(
  sections: readonly Section[],
  draft: { id: number; normal: Vec3; offset: number } | null,
): { id: number; normal: Vec3; offset: number }[] {
  return sections
    .filter((section) => section.is_on)
    .map((section) => (draft?.id === section.id ? draft : section))
    .map(({ id, normal, offset }) => ({ id, normal: [...normal] as Vec3, offset }));
}

/** The faces of a section box, by their places here: the lower ones along x, y, z, then the upper ones. */
export const BOX_FACES = [0, 1, 2, 3, 4, 5] as const;
export type BoxFace = (typeof BOX_FACES)[number];

/** The axis of a face, and whether it is the upper one. */
export const axisOf = (face: BoxFace): 0 | 1 | 2 => (face % 3) as 0 | 1 | 2;
export const isUpper = (face: BoxFace): boolean => face >= 3;

/** The planes of a box's faces: kept is what lies inside all of them. */
export const boxPlanes = (box: Box): { normal: Vec3; offset: number }[] =>
  BOX_FACES.map((face) => {
    const k = axisOf(face);
    const sense = isUpper(face) ? -1 : 1;
    const normal: Vec3 = [0, 0, 0];
    normal[k] = sense;
    return { normal, offset: sense * (isUpper(face) ? box.upper : box.lower)[k] };
  });

/** Air between parts and the section box round them, a share of their diagonal: their own faces are not cut. */
const MARGIN = 0.02;
/** A box is at least so thick, a share of its diagonal. */
const LEAST = 1e-3;

/** A section box round a box of parts; null round nothing. */
export function boxRound(parts: Box): Box | null {
  if (isEmpty(parts)) return null;
  const margin = Math.max(MARGIN * distance(parts.lower, parts.upper), 1e-4);
  return {
    lower: parts.lower.map((value) => value - margin) as Vec3,
    upper: parts.upper.map((value) => value + margin) as Vec3,
  };
}

/** A box with one face elsewhere along its axis; it cannot pass the opposite one. */
export function withFace(box: Box, face: BoxFace, place: number): Box {
  const k = axisOf(face);
  const least = LEAST * distance(box.lower, box.upper);
  const [lower, upper]: [Vec3, Vec3] = [[...box.lower], [...box.upper]];
  if (isUpper(face)) upper[k] = Math.max(place, lower[k] + least);
  else lower[k] = Math.min(place, upper[k] - least);
  return { lower, upper };
}
