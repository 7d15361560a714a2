// Lengths and angles as people read and type them. Inside, everything is metres and radians.

import type { Unit } from "../link/protocol";

export type { Unit };

export const UNITS: readonly Unit[] = ["mm", "cm", "m", "in"];

export const UNIT_NAMES: Readonly<Record<Unit, string>> = {
  mm: "millimetres",
  cm: "centimetres",
  m: "metres",
  in: "inches",
};

const METRES: Readonly<Record<string, number>> = {
  mm: 1e-3,
  cm: 1e-2,
  m: 1,
  in: 0.0254,
  um: 1e-6,
  µm: 1e-6,
  '"': 0.0254,
};
const RADIANS: Readonly<Record<string, number>> = { deg: Math.PI / 180, "°": Math.PI / 180, rad: 1 };
// So many digits after the point show a hundredth of a millimetre in each unit.
const DECIMALS: Readonly<Record<Unit, number>> = { mm: 2, cm: 3, m: 5, in: 4 };

/** How many metres one `unit` is. */
export const metresOf = (unit: Unit): number => METRES[unit] ?? 1;

/** A number without the zeros at its end, and never "-0". */
function trimmed(value: number, decimals: number): string {
  const text = value.toFixed(decimals);
  const short = text.includes(".") ? text.replace(/\.?0+$/, "") : text;
  return short === "-0" ? "0" : short;
}

/** The figure alone, in `unit`, for an input. */
export const lengthFigure = (metres: number, unit: Unit): string => trimmed(metres / metresOf(unit), DECIMALS[unit]);

/** Distances that can be asked for, metres: least and greatest. */
export const DISTANCES_M = [0, 1000] as const;

/** The figure of a length that was typed, with the digits that are kept. */
export function keptFigure(metres: number, unit: Unit): string {
  const value = metres / metresOf(unit);
  const digits = value === 0 ? 0 : Math.ceil(Math.log10(Math.abs(value)));
  return trimmed(value, Math.min(100, Math.max(0, 12 - digits)));
}

/** A length with its unit; NaN reads as a dash. */
export const formatLength = (metres: number, unit: Unit): string =>
  Number.isFinite(metres) ? `${lengthFigure(metres, unit)} ${unit}` : "–";

export const angleFigure = (radians: number): string => trimmed((radians * 180) / Math.PI, 2);
export const formatAngle = (radians: number): string => (Number.isFinite(radians) ? `${angleFigure(radians)}°` : "–");

/** A force with its unit. */
export const formatForce = (newtons: number): string =>
  Number.isFinite(newtons) ? `${trimmed(newtons, newtons < 10 ? 2 : 1)} N` : "–";

/** A share as per cent. */
export const formatShare = (share: number): string => `${Math.round(100 * share)} %`;

/** A count with narrow spaces between thousands, at which no line breaks. */
export const formatCount = (count: number): string =>
  Math.round(count)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, "\u202f");

/**
 * A typed length as metres: a number such as `1e-1`, or a fraction such as `3/8` or `1 3/8`, and a unit; `unit` where
 * none is typed.
 *
 * A comma counts as the point. Null where it cannot be read.
 */
export function parseLength(text: string, unit: Unit): number | null {
  return parse(text, METRES, unit);
}

/** A typed angle as radians; degrees if no unit is typed. */
export function parseAngle(text: string): number | null {
  return parse(text, RADIANS, "deg");
}

const DECIMAL = String.raw`\d+(?:[.,]\d*)?|[.,]\d+`;
const FIGURE = new RegExp(
  String.raw`^\s*(?<sign>[+-]?)\s*(?:(?:(?<whole>\d+)\s+)?(?<over>\d+)\s*/\s*(?<under>\d+)|(?<a>${DECIMAL})` +
    String.raw`(?:\s*/\s*(?<b>${DECIMAL})|e(?<power>[+-]?\d+))?)\s*(?<name>[a-zµ°"]*)\s*$`,
  "i",
);

function parse(text: string, units: Readonly<Record<string, number>>, otherwise: string): number | null {
  const found = FIGURE.exec(text)?.groups;
  if (!found) return null;
  const { sign, whole = "0", over, under, a = "", b = "1", power = "0", name } = found;
  const number = (digits: string, ten = "0"): number => Number(`${digits.replace(",", ".")}e${ten}`);
  const size = over ? number(whole) + number(over) / number(under ?? "") : number(a, power) / number(b);
  const value = size * (units[(name || otherwise).toLowerCase()] ?? Number.NaN);
  if (!Number.isFinite(value)) return null;
  return sign === "-" ? -value : value;
}

/** The unit of areas and volumes: square millimetres of a part are too many. */
const WIDE: Readonly<Record<Unit, Unit>> = { mm: "cm", cm: "cm", m: "m", in: "in" };

/** "12.3 cm²". */
export const areaText = (area_m2: number, unit: Unit): string =>
  `${fewDigits(area_m2 / metresOf(WIDE[unit]) ** 2)} ${WIDE[unit]}²`;

/** "4.9 cm³". */
export const volumeText = (volume_m3: number, unit: Unit): string =>
  `${fewDigits(volume_m3 / metresOf(WIDE[unit]) ** 3)} ${WIDE[unit]}³`;

/** Four digits that count, or all before the point. */
const fewDigits = (value: number): string =>
  value >= 1000 ? formatCount(Math.round(value)) : String(Number(value.toPrecision(4)));

/** Seconds as minutes and seconds: "1:05.3". */
export function formatTime(seconds: number): string {
  const tenths = Math.round(10 * Math.max(0, seconds));
  const rest = ((tenths % 600) / 10).toFixed(1).padStart(4, "0");
  return `${Math.floor(tenths / 600)}:${rest}`;
}
