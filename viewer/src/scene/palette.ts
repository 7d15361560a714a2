// The colours of the parts as a texture: as in the mock-up, toned down so that highlights stay visible.

import { DataTexture, NearestFilter, RGBAFormat, UnsignedByteType } from "three";

// The width that the shaders know.
const WIDTH = 1024;
// The darkest and the lightest channel that is drawn, of 255: on black no edge and no shade is seen, on white no light.
const DARKEST = 44;
const LIGHTEST = 232;
// How much of a colour is taken towards its grey: pure colours are reserved for touched, near and selected parts.
const MUTED = 0.15;

/** A stated colour (0xRRGGBB) as drawn, 0 to 255; null for none. */
export function toned(stated: unknown): [number, number, number] | null {
  if (!Number.isInteger(stated) || (stated as number) < 0 || (stated as number) > 0xffffff) return null;
  const levels = [16, 8, 0].map((shift) => ((stated as number) >> shift) & 255) as [number, number, number];
  const grey = 0.3 * levels[0] + 0.59 * levels[1] + 0.11 * levels[2];
  return levels.map((level) => {
    const muted = level + MUTED * (grey - level);
    return Math.round(DARKEST + ((LIGHTEST - DARKEST) * muted) / 255);
  }) as [number, number, number];
}

/** The opacity of a texel that stands for a part in a finding: its ghost has the colour, too. */
export const TINTED = 153;

/** Puts colours (0xRRGGBB) in place of some parts' own; the map returned puts these back. */
export function tint(texture: DataTexture, colours: ReadonlyMap<number, number>): Map<number, Uint8Array> {
  const data = texture.image.data as Uint8Array;
  const before = new Map<number, Uint8Array>();
  for (const [part, colour] of colours) {
    if (4 * part + 4 > data.length) continue;
    before.set(part, data.slice(4 * part, 4 * part + 4));
    data.set([(colour >> 16) & 255, (colour >> 8) & 255, colour & 255, TINTED], 4 * part);
  }
  texture.needsUpdate = true;
  return before;
}

/** Undoes `tint`. */
export function untint(texture: DataTexture, before: ReadonlyMap<number, Uint8Array>): void {
  for (const [part, texel] of before) (texture.image.data as Uint8Array).set(texel, 4 * part);
  texture.needsUpdate = true;
}

/** A texel a part, by its id; of no opacity where the part has no colour, and the shader gives one. */
export function paletteTexture(count: number, stated: readonly unknown[] | undefined): DataTexture {
  const data = new Uint8Array(4 * Math.max(1, Math.ceil(count / WIDTH)) * WIDTH);
  for (let part = 0; stated && part < Math.min(count, stated.length); part++) {
    const colour = toned(stated[part]);
    if (colour) data.set([...colour, 255], 4 * part);
  }
  const texture = new DataTexture(data, WIDTH, data.length / (4 * WIDTH), RGBAFormat, UnsignedByteType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.generateMipmaps = false;
  texture.needsUpdate = true;
  return texture;
}
