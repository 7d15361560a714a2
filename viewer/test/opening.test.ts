import assert from "node:assert/strict";
import { test } from "node:test";
import { suffixOf, whyNot } from "../src/actions/opening";
import { areaText, volumeText } from "../src/math/units";
import { isolated, touchedText, trianglesText } from "../src/ui/words";

const OPENS = {
  formats: [".stl", ".gltf"],
  companions: [".bin"],
  samples: [],
  most_bytes: 100,
  most_files: 2,
};
const file = (name: string, size = 1) => ({ name, size });

test("files that feeler reads are sent, with the files that they need", () => {
  assert.equal(whyNot([file("a.STL")], OPENS), null);
  assert.equal(whyNot([file("a.gltf"), file("a.bin")], OPENS), null);
  assert.match(whyNot([], OPENS) ?? "", /No file/);
  assert.match(whyNot([file("a.bin")], OPENS) ?? "", /a\.bin is in no format/);
  assert.match(whyNot([file("a.stl"), file("b.exe")], OPENS) ?? "", /b\.exe is in no format.*\.stl, \.gltf/);
  assert.match(whyNot([file("work.FEELPROJ")], OPENS) ?? "", /is a project: start feeler view work\.FEELPROJ/);
  assert.match(whyNot([file("stl")], OPENS) ?? "", /no format/);
  assert.match(whyNot([file("a.stl"), file("b.stl"), file("c.stl")], OPENS) ?? "", /3 files are more than 2/);
  assert.match(whyNot([file("a.stl", 60), file("b.stl", 60)], OPENS) ?? "", /too large/);
  assert.deepEqual(["a.b.STL", "stl", "a.", "dir.x/a"].map(suffixOf), [".stl", "", "", ""]);
});

test("areas and volumes have four digits that count, in a unit that people use", () => {
  assert.equal(volumeText(7.584e-4, "mm"), "758.4 cm³");
  assert.equal(volumeText(1.5, "m"), "1.5 m³");
  assert.equal(volumeText(0.0254 ** 3, "in"), "1 in³");
  assert.equal(volumeText(12.345678, "mm"), "12\u202f345\u202f678 cm³");
  assert.equal(areaText(0.05384, "cm"), "538.4 cm²");
  assert.equal(areaText(0, "mm"), "0 cm²");
});

test("one is one, and a name of another direction does not turn a sentence", () => {
  assert.equal(trianglesText(1, String), "1 triangle");
  assert.equal(trianglesText(2, String), "2 triangles");
  assert.equal(isolated("lid"), "lid");
  assert.equal(touchedText(["\u202elid", "box"]), "touches \u2068\u202elid\u2069, box");
});
