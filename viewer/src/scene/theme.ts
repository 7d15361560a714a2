// The colours behind the shapes, and of their edges.

import { Vector3, Vector4 } from "three";

export type Theme = "dark" | "light";

export interface Colours {
  above: Vector3;
  below: Vector3;
  line: Vector3;
}

/** The colour of see-through parts: lighter than a dark background, darker than a light one. */
const GHOSTS: Record<Theme, Vector4> = {
  dark: new Vector4(0.62, 0.7, 0.8, 0.035),
  light: new Vector4(0.16, 0.22, 0.3, 0.06),
};

const COLOURS: Record<Theme, Colours> = {
  dark: {
    above: new Vector3(0.17, 0.2, 0.24),
    below: new Vector3(0.075, 0.085, 0.1),
    line: new Vector3(0.03, 0.04, 0.05),
  },
  light: {
    above: new Vector3(0.97, 0.98, 0.99),
    below: new Vector3(0.82, 0.85, 0.89),
    line: new Vector3(0.16, 0.18, 0.22),
  },
};

/** 0xRRGGBB as three numbers from 0 to 1. */
export const channels = (colour: number): [number, number, number] => [
  ((colour >> 16) & 255) / 255,
  ((colour >> 8) & 255) / 255,
  (colour & 255) / 255,
];

export const coloursOf = (theme: Theme): Colours => COLOURS[theme];
export const ghostOf = (theme: Theme): Vector4 => GHOSTS[theme];
