// Work that runs a few at a time and comes back in order.

/**
 * Runs `work(k)` for k = 0 to `count` - 1, the first alone, so that it comes soon; after `hasFirst`, which the caller may delay,
 * at most `atOnce` at a time. Gives [k, result] in order of k. The first failure ends it.
 */
export async function* inOrder<T>(
  count: number,
  atOnce: number,
  work: (k: number) => Promise<T>,
  hasFirst: () => Promise<void> = () => Promise.resolve(),
): AsyncGenerator<[number, T]> {
  const begun: Promise<T>[] = [];
  for (let k = 0; k < count; k++) {
    while (begun.length < Math.min(count, k === 0 ? 1 : k + atOnce)) {
      const promise = work(begun.length);
      // One that fails behind the first failure is never awaited.
      promise.catch(() => undefined);
      begun.push(promise);
    }
    const result = await (begun[k] as Promise<T>);
    delete begun[k];
    yield [k, result];
    if (k === 0) await hasFirst();
  }
}
