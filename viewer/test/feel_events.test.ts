import assert from "node:assert/strict";
import { test } from "node:test";
import { type ContactState, Feel, type ImpactMessage, slideOf, strengthOf } from "../src/feel/events";
import { materialOf } from "../src/feel/materials";
import { IDENTITY, rotation, translation } from "../src/math/matrix";

const FLOOR = [0, 0, 0, 0, 0, 1, 0, 8];

const state = (x: number, z = 0, planes: number[] = FLOOR, parts: number[] = [3]): ContactState => ({
  pose: translation([x, 0, z]),
  force: planes.length > 0 ? [0, 3, 4] : [0, 0, 0],
  planes,
  parts,
  age_ms: 0,
});

const impact = (part: number, speed_m_per_s: number, material: string | null = null): ImpactMessage => ({
  ...{ part, part_size_m: 0.1, speed_m_per_s, point: [1, 2, 3], material, force: 5 },
});

test("the speed along a plane is what slides, the speed into it is not", () => {
  const along = slideOf(IDENTITY, translation([0.001, 0, 0]), FLOOR, 0.01);
  assert.ok(Math.abs(along.speed_m_per_s - 0.1) < 1e-9);
  assert.equal(along.force_n, 8);
  const into = slideOf(IDENTITY, translation([0, 0, -0.001]), FLOOR, 0.01);
  assert.ok(into.speed_m_per_s < 1e-9);
});

test("a turning tool slides at its rim, and shares of the force weigh the planes", () => {
  const rim = [0.2, 0, 0, 0, 0, 1, 0, 1];
  const hub = [0, 0, 0, 0, 0, 1, 0, 3];
  const turned = rotation([0, 0, 1], 0.001);
  assert.ok(Math.abs(slideOf(IDENTITY, turned, rim, 0.01).speed_m_per_s - 0.02) < 1e-6);
  assert.ok(Math.abs(slideOf(IDENTITY, turned, [...rim, ...hub], 0.01).speed_m_per_s - 0.005) < 1e-6);
});

test("planes without force do not slide", () => {
  assert.deepEqual(slideOf(IDENTITY, translation([1, 0, 0]), [0, 0, 0, 0, 0, 1, 0, 0], 0.01), {
    speed_m_per_s: 0,
    force_n: 0,
  });
});

test("states that move along the contact slide at their speed, whatever the rate of states", () => {
  for (const interval of [5, 16, 40]) {
    const feel = new Feel();
    let now = 1000;
    for (let x = 0; now < 1400; now += interval, x += 0.2 * (interval / 1000)) feel.state(state(x), now);
    const { slide, press_n } = feel.step(now);
    assert.ok(Math.abs(slide.speed_m_per_s - 0.2) < 0.01, `${interval} ms: ${slide.speed_m_per_s}`);
    assert.equal(slide.force_n, 8);
    assert.equal(press_n, 5);
  }
});

test("the age of a state counts: late arrivals are not fast ones", () => {
  const feel = new Feel();
  for (let k = 0; k < 60; k++) {
    const age_ms = k % 2 === 0 ? 0 : 5;
    feel.state({ ...state(0.001 * k), age_ms }, 1000 + 10 * k + age_ms);
  }
  assert.ok(Math.abs(feel.step(1600).slide.speed_m_per_s - 0.1) < 1e-6);
});

test("a tool that is put elsewhere does not slide, nor does one whose states stop", () => {
  const feel = new Feel();
  feel.state(state(0), 1000);
  feel.state(state(5), 1010);
  assert.equal(feel.step(1011).slide.speed_m_per_s, 0);
  for (let k = 1; k < 20; k++) feel.state(state(5 + 0.002 * k), 1010 + 10 * k);
  assert.ok(feel.step(1210).slide.speed_m_per_s > 0.15);
  assert.equal(feel.step(1400).slide.speed_m_per_s, 0);
});

test("an impact is told once, its strength by its speed", () => {
  const feel = new Feel();
  feel.strike(impact(7, 0.125, "EPDM"), 1000);
  const { impacts } = feel.step(1001);
  assert.equal(impacts.length, 1);
  assert.deepEqual(impacts[0], {
    ...{ part: 7, part_size_m: 0.1, material: "rubber", speed_m_per_s: 0.125, force_n: 5, point: [1, 2, 3] },
    strength: 0.5,
  });
  assert.equal(feel.step(1002).impacts.length, 0);
});

test("strength grows with speed, is silent below a millimetre a second and full at half a metre", () => {
  assert.equal(strengthOf(0.0009), 0);
  assert.equal(strengthOf(Number.NaN), 0);
  assert.ok(strengthOf(0.01) < strengthOf(0.1));
  assert.equal(strengthOf(0.5), 1);
  assert.equal(strengthOf(10), 1);
});

test("chatter is one impact, a much faster one counts, and so does a later one", () => {
  const feel = new Feel();
  feel.strike(impact(7, 0.1), 1000);
  feel.strike(impact(7, 0.1), 1030);
  feel.strike(impact(8, 0.1), 1030);
  assert.deepEqual(
    feel.step(1031).impacts.map((each) => each.part),
    [7, 8],
  );
  feel.strike(impact(7, 0.1), 1060);
  assert.equal(feel.step(1061).impacts.length, 0);
  feel.strike(impact(7, 0.2), 1065);
  assert.equal(feel.step(1066).impacts.length, 1);
  feel.strike(impact(7, 0.1), 1150);
  assert.equal(feel.step(1151).impacts.length, 1);
});

test("a part is released when states no longer name it, once, and not when states stop", () => {
  const feel = new Feel();
  feel.state(state(0), 1000);
  assert.deepEqual(feel.step(1500).releases, []);
  feel.state(state(0, 0.01, [], []), 1510);
  assert.deepEqual(feel.step(1511).releases, [3]);
  assert.equal(feel.step(1511).press_n, 0);
  feel.state(state(0, 0.02, [], []), 1520);
  assert.deepEqual(feel.step(1600).releases, []);
});

test("a part that is missed by one state is not released", () => {
  const feel = new Feel();
  feel.state(state(0), 1000);
  feel.state(state(0, 0, [], []), 1010);
  assert.deepEqual(feel.step(1011).releases, []);
  feel.state(state(0), 1020);
  assert.deepEqual(feel.step(1200).releases, []);
});

test("after a reset nothing is felt and nothing is told as released", () => {
  const feel = new Feel();
  feel.state(state(0), 1000);
  feel.strike(impact(3, 1), 1000);
  feel.reset();
  assert.deepEqual(feel.step(1001), {
    impacts: [],
    releases: [],
    slide: { speed_m_per_s: 0, force_n: 0, material: "steel" },
    press_n: 0,
  });
});

test("materials are known by the words of parts lists", () => {
  const cases: [string | null, string][] = [
    [null, "steel"],
    ["C45E", "steel"],
    ["Absorber housing", "steel"],
    ["Aluminium EN AW-6061", "aluminium"],
    ["AlSi10Mg", "aluminium"],
    ["aluminum", "aluminium"],
    ["PA66 GF30", "plastic"],
    ["ABS", "plastic"],
    ["Rubber, NBR 70", "rubber"],
  ];
  for (const [name, material] of cases) assert.equal(materialOf(name), material, `${name}`);
});
