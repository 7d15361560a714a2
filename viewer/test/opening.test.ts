import assert from "node:assert/strict";
import { test } from "node:test";
import { isOpened, openFiles, suffixOf, whyNot } from "../src/actions/opening";
import type { Workbench } from "../src/actions/workbench";
import type { Document } from "../src/link/protocol";
import { areaText, volumeText } from "../src/math/units";
import { Store } from "../src/model/store";
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

test("a mechanism that is dropped with its model is opened once that is there", async () => {
  assert.equal(whyNot([file("a.stl"), file("a.toml")], OPENS), null);
  assert.match(whyNot([file("a.bin"), file("a.toml")], OPENS) ?? "", /a\.toml is in no format|a\.bin is in no format/);
  assert.match(whyNot([file("a.stl"), file("a.toml"), file("b.toml")], OPENS) ?? "", /2 mechanisms/);
  const store = new Store();
  const done: string[] = [];
  const told = (facts: object): void => {
    store.document.value = { loading: null, mockup: null, ...facts } as unknown as Document;
  };
  told({});
  const wb = {
    store,
    local: () => ({ is_cancelled: false, tell: () => {}, end: () => {} }),
    link: {
      sendFiles: async (_: string, files: { name: string }[]) => {
        done.push(`send ${files.map((each) => each.name).join()}`);
        return 1;
      },
      sendPiece: async () => {},
      openMockup: async () => {
        done.push("open");
      },
    },
    run: async (name: string, args: { name: string; text: string }) => {
      done.push(`${name} ${args.name} ${args.text}`);
      return true;
    },
    tell: (error: unknown) => done.push(String(error)),
  } as unknown as Workbench;
  const opening = openFiles(wb, [new File(["x"], "a.stl"), new File(["[[joint]]"], "a.toml")]);
  await new Promise((resolve) => setTimeout(resolve, 20));
  assert.deepEqual(done, ["send a.stl", "open"]);
  told({ loading: { stage: "opening", share: 0 } });
  told({ mockup: { name: "a.stl" } });
  await opening;
  assert.deepEqual(done, ["send a.stl", "open", "mechanism_open a.toml [[joint]]"]);
});

test("a mechanism waits for its own model, and for none that cannot be opened", async () => {
  const store = new Store();
  const at = (mockup: object, loading: object | null = null): void => {
    store.document.value = { loading, mockup } as unknown as Document;
  };
  const old = { name: "old.stl" };
  for (const [after, files, expected] of [
    [old, [file("a.stl")], false],
    [{ name: "old.stl" }, [file("a.stl")], true],
    [old, [file("old.stl")], true],
  ] as const) {
    at(old);
    const found = isOpened(store.document, files, new AbortController().signal);
    at(old);
    at(old, { stage: "opening", share: 0 });
    at(after);
    assert.equal(await found, expected);
  }
  const stop = new AbortController();
  const found = isOpened(store.document, [], stop.signal);
  stop.abort();
  assert.equal(await found, false);
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
