// Compiles the programs of the first picture while the mock-up is still loading: a device compiles at the first draw.

import type { Box } from "../math/vectors";
import { Pieces, pieceBytes } from "./chunks";
import type { Eye } from "./eye";
import type { Kept, PieceMaterials } from "./kept";
import { PartTable } from "./parts";
import type { SharedUniforms } from "./uniforms";

/** Draws a triangle without a size into `kept`, and forgets it. */
export function warmUp(kept: Kept, materials: PieceMaterials, uniforms: SharedUniforms, eye: Eye): void {
  const box: Box = { lower: [0, 0, 0], upper: [0, 0, 0] };
  const size = { triangles: 1, vertices: 1, first: 0, small: false, parts: 1, ...box };
  const table = new PartTable([box], [0, 0, 0]);
  const pieces = new Pieces({ pieces: [{ ...size, bytes: pieceBytes(size, 2) }], part_bytes: 2 }, materials.solid);
  const piece = pieces.add(0, new ArrayBuffer(pieceBytes(size, 2)));
  uniforms.states.value = table.statesTexture;
  uniforms.places.value = table.placesTexture;
  uniforms.colours.value = table.coloursTexture;
  kept.begin([piece], [], 1);
  kept.draw(eye, Number.POSITIVE_INFINITY);
  kept.forget();
  pieces.dispose();
  table.dispose();
}
