import assert from "node:assert/strict";
import { test } from "node:test";
import { asksForAttributes, PartTree } from "../src/model/part-tree";
import { MOST_ROWS, scrollTo, visibleRows } from "../src/ui/virtual";

/** 10,000 paths: 10 groups of 10 groups of 100 parts. */
const PATHS = Array.from(
  { length: 10_000 },
  (_, k) => `engine/group_${Math.floor(k / 1000)}/unit_${Math.floor(k / 100) % 10}/bolt_${k % 100}`,
);

const names = (tree: PartTree, rows: ReturnType<PartTree["rows"]>) => rows.map((row) => tree.node(row.node).name);

test("the tree shows what lies in open groups, in the order of the paths", () => {
  const tree = new PartTree(["a/b/one", "a/b/two", "a/three", "four"]);
  assert.deepEqual(names(tree, tree.rows(new Set())), ["a", "four"]);
  const a = tree.roots[0] ?? -1;
  const rows = tree.rows(new Set([a]));
  assert.deepEqual(names(tree, rows), ["a", "b", "three", "four"]);
  assert.deepEqual(
    rows.map((row) => [row.depth, row.place, row.siblings, row.isGroup, row.isOpen]),
    [
      [0, 1, 2, true, true],
      [1, 1, 2, true, false],
      [1, 2, 2, false, false],
      [0, 2, 2, false, false],
    ],
  );
});

test("every part has one node and every group all its parts", () => {
  const tree = new PartTree(PATHS);
  assert.equal(tree.nodes.length, 10_000 + 1 + 10 + 100);
  assert.deepEqual(tree.partsUnder(tree.roots[0] ?? -1), [...PATHS.keys()]);
  for (const part of [0, 4711, 9999]) {
    const node = tree.node(tree.nodeOf(part));
    assert.equal(node.part, part);
    assert.equal(node.path, PATHS[part]);
    assert.equal(tree.above(tree.nodeOf(part)).length, 3);
  }
  assert.equal(tree.nodeOf(10_000), -1);
});

test("a search finds parts by every word of the path, and shows the groups above them", () => {
  const tree = new PartTree(PATHS);
  const rows = tree.rows(new Set(), "GROUP_3 bolt_77");
  assert.equal(rows.length, 1 + 1 + 10 + 10);
  assert.equal(tree.matching("group_3 bolt_77").length, 10);
  assert.deepEqual(tree.matching("group_3 no such part"), []);
  assert.deepEqual(tree.rows(new Set(), "nowhere"), []);
  const group = rows[1]?.node ?? -1;
  assert.equal(
    tree.rows(new Set(), "group_3 bolt_77", new Set([group])).length,
    2,
    "a group can be shut while searching",
  );
});

test("parts that were left out of the scene have no line, nor has a group of them alone", () => {
  const tree = new PartTree(["a/b/one", "", "a/three", ""], new Set([1, 3]));
  assert.deepEqual(
    tree.nodes.map((node) => node.name),
    ["a", "b", "one", "three"],
  );
  assert.equal(tree.nodeOf(1), -1);
  assert.deepEqual(tree.matching(""), [0, 2]);
});

test("paths that are the same, empty or odd make no part vanish", () => {
  const tree = new PartTree(["a/b", "a/b", "", "/", "a", "a//c"]);
  assert.deepEqual(
    [0, 1, 2, 3, 4, 5].map((part) => tree.node(tree.nodeOf(part)).part),
    [0, 1, 2, 3, 4, 5],
  );
  assert.equal(tree.node(tree.nodeOf(5)).name, "c");
});

test("no more than eighty rows are in the page, whatever the window and the list", () => {
  for (const height of [0, 100, 900, 5000, 100_000]) {
    for (const top of [0, 13, 5000, 259_900, 1e9]) {
      for (const count of [0, 1, 50, 10_000]) {
        const { first, end } = visibleRows(top, height, 26, count);
        assert.ok(end - first <= MOST_ROWS && MOST_ROWS < 80);
        assert.ok(0 <= first && first <= end && end <= count);
      }
    }
  }
});

test("the rows in sight are in the page", () => {
  const { first, end } = visibleRows(2600, 520, 26, 10_000);
  assert.ok(first <= 100 && end >= 120);
  const last = visibleRows(10_000 * 26 - 520, 520, 26, 10_000);
  assert.equal(last.end, 10_000);
});

test("scrolling to a row moves only as far as it must", () => {
  assert.equal(scrollTo(5, 0, 260, 26), 0);
  assert.equal(scrollTo(0, 100, 260, 26), 0);
  assert.equal(scrollTo(20, 0, 260, 26), 21 * 26 - 260);
});

test("searches that ask for attributes are told from words of paths", () => {
  for (const query of ["material:steel", "bolt material:", 'material:"cast iron', '"a b:c"', "c:/x"])
    assert.equal(asksForAttributes(query), true, query);
  for (const query of ["", ":", "bolt :steel", '":"', "bolt M8 #2"])
    assert.equal(asksForAttributes(query), false, query);
});

test("parts that the server found take the place of words", () => {
  const tree = new PartTree(["a/b/one", "a/b/two", "a/three", "four"]);
  assert.deepEqual(tree.matching("material:steel", new Set([1, 3])), [1, 3]);
  const rows = tree.rows(new Set(), "material:steel", new Set(), new Set([1, 3]));
  assert.deepEqual(names(tree, rows), ["a", "b", "two", "four"]);
  assert.deepEqual(tree.rows(new Set(), "material:steel"), []);
});

test("parts that are a whole group are known by it", () => {
  const tree = new PartTree(["a/b/one", "a/b/two", "a/three", "four", "a/b/gone"], new Set([4]));
  const group = (...parts: number[]) => tree.groupOf(new Set(parts))?.name ?? null;
  assert.deepEqual([group(0, 1), group(1, 0, 2)], ["b", "a"]);
  assert.deepEqual(
    [group(), group(0), group(0, 2), group(0, 3), group(0, 1, 3), group(0, 1, 2, 3)],
    Array(6).fill(null),
  );
});
