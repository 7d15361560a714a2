// The newest of many measurements.

const KEPT = 200;

/** The last `KEPT` values, the oldest first. */
export class Recent {
  readonly values: number[] = [];

  add(value: number): void {
    this.values.push(value);
    if (this.values.length > KEPT) this.values.shift();
  }

  clear(): void {
    this.values.length = 0;
  }
}
