// The faces of a box, by their places, and their planes. Pure.

import type { Box, Vec3 } from "./vectors";

/** The faces of a box, by their places here: the lower ones along x, y, z, then the upper ones. */
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
