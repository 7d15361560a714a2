// Materials of parts, as far as they sound and feel different.

import type { Material } from "../link/protocol";

export type { Material };

export interface MaterialProperties {
  /** Speed of sound along a bar, metres a second: the square root of Young's modulus by density. */
  readonly sound_m_per_s: number;
  /** Share of a mode's energy that is lost in a radian, mounted in an assembly: bare metal rings ten times longer. */
  readonly loss: number;
  /** How long a strike at 1 m/s takes, seconds: the shorter, the more of the high modes sound. */
  readonly contact_s: number;
  /** Length of the roughness that a sliding tool meets, metres. */
  readonly roughness_m: number;
}

export const MATERIALS: Readonly<Record<Material, MaterialProperties>> = {
  steel: { sound_m_per_s: 5050, loss: 0.0015, contact_s: 6e-5, roughness_m: 5e-5 },
  aluminium: { sound_m_per_s: 5100, loss: 0.003, contact_s: 9e-5, roughness_m: 6e-5 },
  plastic: { sound_m_per_s: 1500, loss: 0.04, contact_s: 3e-4, roughness_m: 1e-4 },
  rubber: { sound_m_per_s: 100, loss: 0.25, contact_s: 3e-3, roughness_m: 4e-4 },
};

/** Words by which materials are named in parts lists, the more particular ones first. */
const WORDS: readonly (readonly [Material, RegExp])[] = [
  ["rubber", /rubber|gummi|\b(epdm|h?nbr|fkm|viton)\b|silicone|elastomer/],
  ["plastic", /plast|nylon|polyamid|polypropylen|polycarbonat|resin|\b(abs|peek|pom|pp|p[aepc]\d*)\b/],
  ["aluminium", /alumin|\balu\b|\balsi|\ben aw\b|magnesium/],
];

/** The material of a name; steel if the name is absent or unknown. */
export function materialOf(name: string | null): Material {
  const lower = (name ?? "").toLowerCase();
  return WORDS.find(([, pattern]) => pattern.test(lower))?.[0] ?? "steel";
}
