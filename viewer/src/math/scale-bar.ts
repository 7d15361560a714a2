// The scale bar: a round length in the shown unit, at most as long as there is room.

import { formatLength, metresOf, type Unit } from "./units";

const STEPS = [5, 2, 1] as const;

/** The longest length of 1, 2 or 5 times a power of ten units that `most_px` pixels show; null where nothing is shown. */
export function scaleBar(
  metres_per_px: number,
  most_px: number,
  unit: Unit,
): { width_px: number; metres: number; text: string } | null {
  const most = (metres_per_px * most_px) / metresOf(unit);
  if (!(most > 0) || !Number.isFinite(most)) return null;
  const decade = 10 ** Math.floor(Math.log10(most));
  const step = STEPS.find((each) => each * decade <= most * (1 + 1e-9)) ?? 1;
  const metres = step * decade * metresOf(unit);
  const figure = step * decade;
  // Below the digits of a length, the figure as it is.
  const text = figure < 0.1 ? `${Number(figure.toPrecision(1))} ${unit}` : formatLength(metres, unit);
  return { width_px: metres / metres_per_px, metres, text };
}
