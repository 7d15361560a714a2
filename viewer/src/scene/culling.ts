// Which boxes a camera can see.

import type { Box } from "../math/vectors";

/**
 * The side planes of the frustum of `clipFromWorld` (column by column, as three keeps it): 4 rows of (normal, offset),
 * inside where normal . x + offset >= 0. Near and far are left out: they never cut anything of the scene.
 */
export function sidePlanes(clipFromWorld: ArrayLike<number>): Float64Array {
  const planes = new Float64Array(16);
  const at = (row: number, column: number) => clipFromWorld[4 * column + row] as number;
  for (let plane = 0; plane < 4; plane++) {
    const axis = plane >> 1;
    const sign = plane & 1 ? -1 : 1;
    for (let column = 0; column < 4; column++) planes[4 * plane + column] = at(3, column) + sign * at(axis, column);
  }
  return planes;
}

/** Whether some of `box` may lie inside all planes. Never false for a box that is seen. */
export function mayBeSeen(box: Box, planes: Float64Array): boolean {
  for (let plane = 0; plane < planes.length; plane += 4) {
    let most = planes[plane + 3] as number;
    for (let axis = 0; axis < 3; axis++) {
      const normal = planes[plane + axis] as number;
      most += normal * ((normal > 0 ? box.upper[axis] : box.lower[axis]) as number);
    }
    if (most < 0) return false;
  }
  return true;
}

/** Whether all of `box` is cut away by one of `sections` (kept where normal . x >= offset). */
export function isCutAway(box: Box, sections: readonly { normal: readonly number[]; offset: number }[]): boolean {
  return sections.some(({ normal, offset }) => {
    let most = 0;
    for (let axis = 0; axis < 3; axis++) {
      const n = normal[axis] as number;
      most += n * ((n > 0 ? box.upper[axis] : box.lower[axis]) as number);
    }
    return most < offset;
  });
}
