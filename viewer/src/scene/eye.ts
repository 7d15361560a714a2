// The camera that three draws with: of perspective or of parallel projection.

import { PerspectiveCamera } from "three";

export class Eye extends PerspectiveCamera {
  /** Half the height of what parallel projection shows, metres; null: perspective. */
  half: number | null = null;

  override updateProjectionMatrix(): void {
    if (this.half === null || this.half === undefined) {
      super.updateProjectionMatrix();
      return;
    }
    let [left, top] = [-this.half * this.aspect, this.half];
    let [width, height] = [-2 * left, 2 * top];
    const { view } = this;
    if (view?.enabled) {
      left += (view.offsetX * width) / view.fullWidth;
      top -= (view.offsetY * height) / view.fullHeight;
      width *= view.width / view.fullWidth;
      height *= view.height / view.fullHeight;
    }
    const { near, far, coordinateSystem, reversedDepth } = this;
    this.projectionMatrix.makeOrthographic(
      left,
      left + width,
      top,
      top - height,
      near,
      far,
      coordinateSystem,
      reversedDepth,
    );
    this.projectionMatrixInverse.copy(this.projectionMatrix).invert();
  }
}
