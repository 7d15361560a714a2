import assert from "node:assert/strict";
import { test } from "node:test";
import {
  formatAngle,
  formatCount,
  formatForce,
  formatLength,
  keptFigure,
  lengthFigure,
  parseAngle,
  parseLength,
  UNITS,
} from "../src/math/units";

test("lengths are shown to a hundredth of a millimetre, without zeros at the end", () => {
  assert.equal(formatLength(0.0125, "mm"), "12.5 mm");
  assert.equal(formatLength(0.0125, "cm"), "1.25 cm");
  assert.equal(formatLength(0.0125, "m"), "0.0125 m");
  assert.equal(formatLength(0.0254, "in"), "1 in");
  assert.equal(formatLength(-0.0000001, "mm"), "0 mm");
  assert.equal(formatLength(100, "mm"), "100000 mm");
  assert.equal(formatLength(Number.NaN, "mm"), "–");
  assert.equal(formatLength(Number.POSITIVE_INFINITY, "mm"), "–");
});

test("a length that was typed is shown with the digits that are kept", () => {
  for (const text of ["0", "0.0005", "3.175", "1000000", "0.000000001", "-12.3456789"]) {
    for (const unit of UNITS) {
      assert.equal(keptFigure(parseLength(text, unit) ?? Number.NaN, unit), text);
    }
  }
});

test("what is typed is read in the unit chosen, or in the one typed", () => {
  const near = (read: number | null, metres: number): void =>
    assert.ok(read !== null && Math.abs(read - metres) < 1e-12);
  near(parseLength("12.5", "mm"), 0.0125);
  near(parseLength("12,5", "mm"), 0.0125);
  near(parseLength("12.5", "in"), 0.3175);
  near(parseLength("3/8 in", "mm"), 0.009525);
  near(parseLength('-2"', "mm"), -0.0508);
  near(parseLength(".5cm", "m"), 0.005);
  near(parseLength("+7 MM", "in"), 0.007);
  near(parseLength("4um", "mm"), 4e-6);
  near(parseLength("1 1/2", "mm"), 0.0015);
  near(parseLength("-1 3/8in", "mm"), -0.034925);
  near(parseLength("1e-1", "mm"), 1e-4);
  near(parseLength("2,5E+1 mm", "in"), 0.025);
});

test("what cannot be read is null, not a wrong length", () => {
  for (const text of [
    "",
    "-",
    "mm",
    "1.2.3",
    "1 ft",
    "1/0",
    "1 1/0",
    "1.5 1/2",
    "1 2/3.5",
    "1e",
    "1e-",
    "1e2/3",
    "1e999",
    "2*3",
    "0x10",
    "NaN",
    "5 deg",
    "1 2",
  ]) {
    assert.equal(parseLength(text, "mm"), null, text);
  }
});

test("a figure that is shown reads back as the same length", () => {
  for (const unit of UNITS) {
    for (const metres of [0, 0.00001, -0.01234, 0.5, 3.02365]) {
      const back = parseLength(lengthFigure(metres, unit), unit);
      assert.ok(back !== null && Math.abs(back - metres) < 6e-6, `${metres} in ${unit}`);
    }
  }
});

test("angles are degrees unless they say otherwise", () => {
  assert.equal(parseAngle("90"), Math.PI / 2);
  assert.equal(parseAngle("-45°"), -Math.PI / 4);
  assert.equal(parseAngle("1 rad"), 1);
  assert.equal(parseAngle("1 mm"), null);
  assert.equal(formatAngle(Math.PI / 2), "90°");
});

test("counts have gaps between thousands, forces two decimals while they are small", () => {
  assert.equal(formatCount(1599996), "1\u202f599\u202f996");
  assert.equal(formatCount(663), "663");
  assert.equal(formatForce(1.234), "1.23 N");
  assert.equal(formatForce(123.456), "123.5 N");
});
