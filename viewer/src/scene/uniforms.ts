// The uniforms that several programs read: one object each, so that a change reaches all of them.

import { type IUniform, Matrix4, type Texture, Vector2, Vector3, Vector4 } from "three";

/** Six cuts, and the six faces of the section box. */
export const MAX_SECTIONS = 12;
/** A cut takes so much more away, a share of the mock-up's diagonal: a face in its plane is gone as a whole. */
export const CUT_SLACK = 1e-6;

const vectors = (count: number) => Array.from({ length: count }, () => new Vector4());

export function sharedUniforms() {
  return {
    states: { value: null as Texture | null },
    places: { value: null as Texture | null },
    colours: { value: null as Texture | null },
    /** The colour of a part that is seen through, and its opacity where it faces the eye. */
    ghost: { value: new Vector4() },
    /** The colours of other people. */
    others: { value: [new Vector3(), new Vector3(), new Vector3()] },
    /** The vertical, view coordinates. */
    sky: { value: new Vector3(0, 1, 0) },
    /** Section planes: world coordinates less the middle, and view coordinates. */
    cutPlanes: { value: vectors(MAX_SECTIONS) },
    viewPlanes: { value: vectors(MAX_SECTIONS) },
    keptDepth: { value: null as Texture | null },
    keptId: { value: null as Texture | null },
    /** Texels of the kept layer a pixel. */
    keptScale: { value: new Vector2(1, 1) },
    /** x * stored depth + y is 1 / distance in perspective, the distance in parallel projection. */
    depthLine: { value: new Vector2(1, 0) },
    fragmentOffset: { value: new Vector2() },
    /** The direction of a pixel, view coordinates: (pixel * xy + zw, -1). */
    rayOf: { value: new Vector4() },
    hasKept: { value: false },
    /** Device pixels. */
    resolution: { value: new Vector2(1, 1) },
    pixelRatio: { value: 1 },
    nearest: { value: 0.001 },
    /** 0: perspective; parallel projection: the distance of the target, to which slacks are relative. */
    parallel: { value: 0 },
  } satisfies Record<string, IUniform>;
}

export type SharedUniforms = ReturnType<typeof sharedUniforms>;

const inverse = new Matrix4();

/** Sets what follows from the projection: a matrix of three, and whether its depth is reversed. */
export function setProjection(
  uniforms: SharedUniforms,
  projection: Matrix4,
  isReversed: boolean,
  width: number,
  height: number,
  isParallel = false,
): void {
  const e = projection.elements;
  const [scale, offset] = [e[14] as number, e[10] as number];
  if (isParallel) {
    // clip z = offset * z + scale with z = -d: stored (reversed) = scale - offset * d; else 2 s - 1 is that.
    if (isReversed) uniforms.depthLine.value.set(-1 / offset, scale / offset);
    else uniforms.depthLine.value.set(-2 / offset, (scale + 1) / offset);
  }
  // clip z = offset * z + scale, clip w = -z: stored (reversed, 0 to 1) = scale / d - offset.
  else if (isReversed) uniforms.depthLine.value.set(1 / scale, offset / scale);
  // Stored 0 to 1 of -1 to 1: 2 s - 1 = scale / d - offset.
  else uniforms.depthLine.value.set(2 / scale, (offset - 1) / scale);
  inverse.copy(projection).invert();
  const i = inverse.elements;
  const [x, y] = [i[0] as number, i[5] as number];
  uniforms.rayOf.value.set((2 * x) / width, (2 * y) / height, (i[12] as number) - x, (i[13] as number) - y);
  uniforms.resolution.value.set(width, height);
}
