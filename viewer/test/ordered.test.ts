import assert from "node:assert/strict";
import { test } from "node:test";
import { inOrder } from "../src/link/ordered";

test("the first comes alone, others a few at a time, all in order whatever finishes first", async () => {
  const finish: (() => void)[] = [];
  let [running, most] = [0, 0];
  const work = (k: number) =>
    new Promise<number>((resolve) => {
      running++;
      most = Math.max(most, running);
      finish[k] = () => {
        running--;
        resolve(10 * k);
      };
    });
  const got: [number, number][] = [];
  const all = (async () => {
    for await (const entry of inOrder(6, 3, work)) got.push(entry);
  })();
  const turn = () => new Promise((resolve) => setImmediate(resolve));
  await turn();
  assert.equal(finish.length, 1);
  finish[0]?.();
  await turn();
  assert.deepEqual(got, [[0, 0]]);
  assert.equal(finish.length, 4);
  finish[3]?.();
  finish[2]?.();
  await turn();
  assert.deepEqual(got, [[0, 0]]);
  finish[1]?.();
  await turn();
  assert.deepEqual(got, [
    [0, 0],
    [1, 10],
    [2, 20],
    [3, 30],
  ]);
  for (const k of [5, 4]) {
    finish[k]?.();
    await turn();
  }
  await all;
  assert.deepEqual(
    got.map((entry) => entry[0]),
    [0, 1, 2, 3, 4, 5],
  );
  assert.ok(most <= 3);
});

test("the first failure ends it, and those behind it are not left unhandled", async () => {
  const work = (k: number) => (k >= 1 ? Promise.reject(new Error(`piece ${k}`)) : Promise.resolve(k));
  const got: number[] = [];
  await assert.rejects(async () => {
    for await (const [k] of inOrder(5, 4, work)) got.push(k);
  }, /piece 1/);
  assert.deepEqual(got, [0]);
});

test("the others wait until the first has been dealt with", async () => {
  const begun: number[] = [];
  let go = (): void => {};
  const hasFirst = () => new Promise<void>((resolve) => (go = resolve));
  const work = (k: number) => {
    begun.push(k);
    return Promise.resolve(k);
  };
  const got: number[] = [];
  const all = (async () => {
    for await (const [k] of inOrder(3, 4, work, hasFirst)) got.push(k);
  })();
  await new Promise((resolve) => setImmediate(resolve));
  assert.deepEqual([begun, got], [[0], [0]]);
  go();
  await all;
  assert.deepEqual(
    [begun, got],
    [
      [0, 1, 2],
      [0, 1, 2],
    ],
  );
});
