// From the page's camera to three's, and to the uniforms that follow from it.

import { type Box, dot, subtract, type Vec3 } from "../math/vectors";
import type { CameraRig } from "./camera";
import { sidePlanes } from "./culling";
import type { Eye } from "./eye";
import { type SharedUniforms, setProjection } from "./uniforms";

export interface Aim {
  camera: CameraRig;
  /** All that is to be seen, world metres. */
  box: Box;
  /** Where the scene's origin lies, world metres. */
  middle: Vec3;
  isReversed: boolean;
  /** Device pixels. */
  picture: { width: number; height: number; pixelRatio: number };
}

/** Moves `eye` to the camera. */
export function aim(eye: Eye, uniforms: SharedUniforms, { camera, box, middle, isReversed, picture }: Aim): void {
  const { near, far } = camera.range(box, isReversed);
  const half = camera.isParallel ? camera.reach * Math.tan(camera.fov / 2) : null;
  Object.assign(eye, { fov: (camera.fov * 180) / Math.PI, aspect: picture.width / picture.height, near, far, half });
  eye.position.set(...subtract(camera.position, middle));
  eye.up.set(...camera.top);
  eye.lookAt(...subtract(camera.target, middle));
  eye.updateProjectionMatrix();
  eye.updateMatrixWorld();
  setProjection(uniforms, eye.projectionMatrix, isReversed, picture.width, picture.height, camera.isParallel);
  uniforms.pixelRatio.value = picture.pixelRatio;
  uniforms.nearest.value = camera.isParallel ? -Infinity : near;
  uniforms.parallel.value = camera.isParallel ? camera.reach : 0;
  uniforms.sky.value.set(dot(camera.up, camera.right), dot(camera.up, camera.top), -dot(camera.up, camera.forward));
}

/** The side planes of what `eye` sees, for boxes in world metres. */
export function eyePlanes(eye: Eye, middle: Vec3): Float64Array {
  const planes = sidePlanes(eye.projectionMatrix.clone().multiply(eye.matrixWorldInverse).elements);
  for (let k = 0; k < planes.length; k += 4) {
    const normal: Vec3 = [planes[k] as number, planes[k + 1] as number, planes[k + 2] as number];
    planes[k + 3] = (planes[k + 3] as number) - dot(normal, middle);
  }
  return planes;
}
