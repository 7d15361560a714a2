// The stage in a real browser: what is drawn, what is picked, and what a frame costs in draw calls.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { heldOf, mockupOf } from "./blocks.mjs";
import { whySkipped } from "./browser.mjs";
import { open, serve } from "./serve.mjs";

// A wall at the back (part 0); before it a large block (1) and, in a piece of its own, a small one (2) to its right.
const WALL = [
  [-1, 0.5, -1],
  [1, 0.6, 1],
];
const LARGE = [
  [-0.4, -0.2, -0.4],
  [0.4, 0.2, 0.4],
];
const SMALL = [
  [0.6, -0.1, -0.1],
  [0.8, 0.1, 0.1],
];
const HELD = heldOf([-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]);
const AT = (x, y, z) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1];

let server;
let tab;

before(async () => {
  if (whySkipped) return;
  const { manifest, data } = mockupOf([[WALL, LARGE], [SMALL]], "blocks", [-1, -1, 0x20c040]);
  server = await serve((path) => {
    if (path === "/scene") return Buffer.from(JSON.stringify(manifest));
    if (path.startsWith("/scene/sent/")) return data[Number(path.split("/").pop())];
    return path === "/held/1" ? HELD.data : null;
  });
  tab = await open(server.url);
  await tab.page.evaluate(() => window.harness.load());
});

after(async () => {
  await tab?.close();
  server?.close();
});

/** Runs `f(harness, argument)` in the page with everything as it was at first, seen from the front. */
function inPage(f, argument) {
  return tab.page.evaluate(
    async ([source, value]) => {
      const { harness } = window;
      const { stage } = harness;
      stage.setPartStates(new Uint8Array(3));
      stage.setMoved(new Map());
      stage.setExplode(0);
      stage.setSections([]);
      stage.setOutlines(null);
      stage.setHeld(null);
      stage.setHits(new Uint32Array(0), new Uint32Array(0));
      stage.setMarks(harness.NO_MARKS);
      stage.setTheme("dark");
      stage.setHeat(false);
      stage.camera.setParallel(false);
      stage.camera.view(1, { lower: [-1, -1, -1], upper: [1, 1, 1] }, "z");
      await harness.whole();
      const script = document.createElement("script");
      script.textContent = `window.work = ${source}`;
      document.head.append(script);
      script.remove();
      const at = (p) => {
        const seen = stage.camera.project(p);
        return [Math.floor(seen.x), Math.floor(seen.y)];
      };
      const pick = (p) => stage.pick(...at(p));
      const colours = (...points) => harness.coloursAt(points.map(at));
      const colour = async (p) => (await colours(p))[0];
      return window.work({ ...harness, at, pick, colour, colours }, value);
    },
    [f.toString(), argument],
  );
}

const scene = (name, f) => test(name, { skip: whySkipped, timeout: 120_000 }, f);

scene("a pick finds the part and the point before the others, and nothing beside them", async () => {
  const found = await inPage(({ pick }) => [
    pick([0, 0, 0]),
    pick([0.7, 0, 0]),
    pick([-0.7, 0, 0.7]),
    pick([1.4, 0, 0]),
  ]);
  assert.deepEqual(
    found.map((hit) => hit?.part),
    [1, 2, 0, undefined],
  );
  const depths = [-0.2, -0.1, 0.5];
  depths.forEach((depth, k) => {
    assert.ok(Math.abs(found[k].point[1] - depth) < 1e-4, `${found[k].point} is not at ${depth}`);
    assert.equal(found[k].held, false);
  });
});

scene("what is hidden or a ghost is looked through, at once", async () => {
  const parts = await inPage(({ stage, pick }) => {
    const with1 = (state) => {
      stage.setPartStates(Uint8Array.of(0, state, 0));
      return pick([0, 0, 0])?.part;
    };
    return [with1(1), with1(2), with1(32), with1(0)];
  });
  assert.deepEqual(parts, [0, 0, 0, 1]);
});

scene("a section is filled, and picked where its plane is", async () => {
  const { filled, plain, hit, behind, wall } = await inPage(async ({ stage, pick, colour, colours }) => {
    const plain = await colour([0.02, 0, 0.03]);
    // Half of the large block is cut away; what the eye meets is its inside.
    stage.setSections([{ normal: [0, 1, 0], offset: 0 }]);
    const filled = await colours(...[0, 1, 2, 3, 4, 5, 6, 7, 8].map((k) => [0.01 * k, 0, 0.03]));
    const hit = pick([0, 0, 0]);
    stage.setSections([
      { normal: [0, 1, 0], offset: 0 },
      { normal: [1, 0, 0], offset: 0.5 },
    ]);
    return { plain, filled, hit, behind: pick([0.7, 0, 0]), wall: pick([0, 0, 0]) };
  });
  assert.equal(hit.part, 1);
  assert.ok(Math.abs(hit.point[1]) < 1e-4, `the plane is at y = 0, not ${hit.point[1]}`);
  assert.ok(Math.abs(behind.point[1]) < 1e-4 && behind.part === 2);
  assert.equal(wall, null, "two sections leave nothing there");
  const lights = filled.map(([r, g, b]) => r + g + b);
  assert.ok(Math.max(...lights) - Math.min(...lights) > 60, "the fill is hatched");
  assert.ok(filled.some((c) => Math.abs(c[0] - plain[0]) > 25));
});

scene("of flush parts that are cut, each is filled as far as it goes", async () => {
  const wrong = await inPage(async ({ stage, pick, whole }) => {
    // The small block lies flat on the large one's side: two faces in one place, of other triangles.
    stage.setMoved(new Map([[2, [1, 0, 0, -0.2, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]]));
    stage.setSections([{ normal: [0, 1, 0], offset: 0 }]);
    const found = [];
    for (const position of [
      [-1.1, -1.3, 0.3],
      [-0.4, -0.6, 0.02],
      [-2.3, -0.9, -0.7],
    ]) {
      Object.assign(stage.camera, { position, target: [0.4, 0, 0], moved: true });
      await whole();
      // Behind these points the eye's rays go from the large block into the small one.
      for (let x = 0.33; x < 0.395; x += 0.004) {
        for (let z = -0.07; z < 0.08; z += 0.01) {
          const hit = pick([x, 0, z]);
          if (hit?.part !== 1 || Math.abs(hit.point[1]) > 1e-5) found.push({ position, x, z, hit });
        }
      }
    }
    return found;
  });
  assert.deepEqual(wrong.slice(0, 3), [], `${wrong.length} points are of another part than they lie in`);
});

scene("a frame in which only the tool moves draws the tool alone", async () => {
  const stats = await inPage(
    async ({ stage, geometry, settled }, { manifest, poses }) => {
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      await settled();
      return poses.map((pose) => {
        stage.setPose(pose, null);
        return stage.frame(performance.now());
      });
    },
    { manifest: HELD.manifest, poses: [AT(0, -0.6, 0), AT(0.1, -0.6, 0), AT(0.2, -0.6, 0)] },
  );
  for (const frame of stats) {
    assert.equal(frame.isKept, true);
    assert.equal(frame.triangles, 12 + 12, "and the box that it covers");
    assert.ok(frame.calls <= 3);
  }
});

scene("what is told again changes nothing: a picture that stands comes to rest", async () => {
  const { first, again } = await inPage(
    async ({ stage, geometry, settled, NO_MARKS }, { manifest, pose }) => {
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      const tell = () => {
        stage.setPose([...pose], [...pose]);
        stage.setHits(Uint32Array.of(12, 13), Uint32Array.of(1));
        stage.setMarks({ ...NO_MARKS, distance: { from: [0, -0.3, 0], to: [0.1, -0.3, 0], text: "100 mm" } });
        stage.setPartStates(Uint8Array.of(0, 8, 0));
        stage.setSections([{ normal: [0, 0, 1], offset: -0.9 }]);
        return stage.frame(performance.now()).drawn;
      };
      await settled();
      const first = tell();
      await settled();
      return { first, again: tell() };
    },
    { manifest: HELD.manifest, pose: AT(0, -0.6, 0) },
  );
  assert.deepEqual([first, again], [true, false]);
});

scene("the held mesh hides and is hidden by distance, and is picked", async () => {
  const { before, inside, behind, beforeTint, cap } = await inPage(
    async ({ stage, geometry, pick, colour }, { manifest, poses }) => {
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      stage.setPose(poses[0], null);
      const [before, beforeTint] = [pick([0, -0.7, 0]), await colour([0, -0.7, 0])];
      stage.setPose(poses[1], null);
      const inside = pick([0, -0.2, 0]);
      stage.setPose(poses[2], null);
      const behind = pick([0.02, 0.3, 0.02]);
      // In the fill of a section, the plane hides it: the block's back face is behind it.
      stage.setPose(poses[1], null);
      stage.setSections([{ normal: [0, 1, 0], offset: -0.15 }]);
      return { before, beforeTint, inside, behind, cap: pick([0, -0.15, 0]) };
    },
    { manifest: HELD.manifest, poses: [AT(0, -0.6, 0), AT(0, 0, 0), AT(0, 0.35, 0)] },
  );
  assert.deepEqual([before.held, before.part], [true, 0]);
  assert.ok(Math.abs(before.point[1] + 0.7) < 1e-4);
  assert.ok(beforeTint[1] > beforeTint[0], "the tool is of the hand's colour");
  assert.deepEqual([inside.held, inside.part], [false, 1]);
  assert.deepEqual([behind.held, behind.part], [false, 1]);
  assert.deepEqual([cap.held, cap.part], [false, 1]);
});

scene("a part has the colour that is stated, and calm ones where none is", async () => {
  const found = await inPage(({ colours }) => colours([0.7, -0.1, 0.02], [0.02, -0.2, 0.03], [-0.7, 0.5, 0.7]));
  const [stated, ...calm] = found.map(([r, g, b]) => g - Math.max(r, b));
  assert.ok(stated > 60, `not green: ${found[0]}`);
  assert.ok(Math.max(...calm) < 25, `green as well: ${found.slice(1)}`);
});

scene("a selected part has a rim, whatever its colour, but none where the picture ends", async () => {
  const { rim, inside, end } = await inPage(async ({ stage, at, PartState, coloursAt, colour }) => {
    stage.setPartStates(Uint8Array.of(0, 0, PartState.selected));
    // The small block is seen from its left as well: it ends at the corner at the back.
    const [x, y] = at([0.6, 0.1, 0.02]);
    const inside = await colour([0.7, -0.1, 0.02]);
    const rim = await coloursAt([-2, -1, 0, 1, 2].map((k) => [x + k, y]));
    stage.setPartStates(Uint8Array.of(PartState.selected, 0, 0));
    stage.camera.position = [-0.7, 0.3, 0.7];
    stage.camera.target = [-0.7, 0.5, 0.7];
    stage.camera.moved = true;
    return {
      rim,
      inside,
      end: await coloursAt([
        [0, 40],
        [60, 40],
      ]),
    };
  });
  const isRim = ([r, g, b]) => r > 240 && g > 200 && b < 90;
  assert.ok(rim.some(isRim), `no rim: ${rim}`);
  assert.ok(!isRim(inside));
  assert.ok(!end.some(isRim), `a rim at the end of the picture: ${end}`);
});

scene("lit parts change colour without a redraw, and are told apart without red", async () => {
  const { frames, colours } = await inPage(async ({ stage, colour, PartState }) => {
    const frames = [];
    const colours = [];
    for (const state of [0, PartState.hit, PartState.selected]) {
      stage.setPartStates(Uint8Array.of(0, state, 0));
      frames.push(stage.frame(performance.now()).isKept);
      colours.push(await colour([0.21, -0.2, 0.22]));
    }
    return { frames, colours };
  });
  assert.deepEqual(frames, [true, true, true]);
  for (const [k, a] of colours.entries()) {
    for (const b of colours.slice(k + 1)) {
      assert.ok(Math.abs(a[1] - b[1]) + Math.abs(a[2] - b[2]) > 40, `${a} and ${b} are alike in green and blue`);
    }
  }
});

scene("triangles that meet are drawn over their part; those of a hidden part are not", async () => {
  const { plain, hit, hidden, calls } = await inPage(async ({ stage, colour }) => {
    const plain = await colour([0.1, -0.2, 0.1]);
    stage.setHits(
      Uint32Array.from({ length: 12 }, (_, k) => 12 + k),
      new Uint32Array(0),
    );
    const hit = await colour([0.1, -0.2, 0.1]);
    const { calls } = stage.stats;
    stage.setPartStates(Uint8Array.of(0, 1, 0));
    return { plain, hit, hidden: await colour([0.1, -0.2, 0.1]), calls };
  });
  assert.ok(hit[0] > plain[0] + 40 && hit[2] < plain[2], `${plain} did not turn orange: ${hit}`);
  assert.ok(Math.abs(hidden[0] - hidden[2]) < 60, `still orange: ${hidden}`);
  assert.ok(calls <= 4);
});

scene("a moved part is drawn and picked where it is", async () => {
  const found = await inPage(
    ({ stage, pick }, pose) => {
      stage.setMoved(new Map([[1, pose]]));
      return [pick([0, 0, 0]), pick([-0.5, 0, 0.5])];
    },
    AT(-0.5, 0, 0.5),
  );
  assert.deepEqual(
    found.map((hit) => hit.part),
    [0, 1],
  );
});

scene("a tool behind the mock-up shines through it, and is not picked there", async () => {
  const { plain, behind, beside, hit } = await inPage(
    async ({ stage, geometry, pick, colour }, { manifest, pose }) => {
      const plain = await colour([-0.7, 0, 0.7]);
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      stage.setPose(pose, null);
      return {
        plain,
        behind: await colour([-0.7, 0.5, 0.7]),
        beside: await colour([-0.7, 0.5, -0.7]),
        hit: pick([-0.7, 0.5, 0.7]),
      };
    },
    { manifest: HELD.manifest, pose: AT(-0.75, 0.8, 0.75) },
  );
  // Of the tool's colour, and still of the wall's.
  assert.ok(behind[1] - behind[0] > plain[1] - plain[0] + 8, `${behind} has nothing of the tool, nor has ${plain}`);
  assert.ok(Math.abs(behind[1] - plain[1]) < 60, `${behind} is as if nothing were before it`);
  assert.ok(Math.abs(beside[1] - plain[1]) < 12);
  assert.equal(hit.held, false);
});

scene("surfaces near the tool are coloured by their distance, those farther off and others are not", async () => {
  const { off, on, away } = await inPage(
    async ({ stage, geometry, colours, frames }, { manifest, pose }) => {
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      stage.setPose(pose, null);
      stage.setHeat(true);
      await frames(() => stage.heatAccuracy !== null);
      stage.setHeat(false);
      const places = [
        [0, -0.2, 0.11],
        [0, -0.2, 0.114],
        [0, -0.2, 0.15],
        [-0.7, 0.5, 0.7],
      ];
      const off = await colours(...places);
      stage.setHeat(true);
      const on = await colours(...places);
      stage.setPose([...pose.slice(0, 7), -0.9, ...pose.slice(8)], null);
      return { off, on, away: await colours(...places) };
    },
    { manifest: HELD.manifest, pose: AT(0, -0.302, 0) },
  );
  const changes = on.map((colour, k) => Math.max(...colour.map((value, c) => Math.abs(value - off[k][c]))));
  assert.ok(Math.max(changes[0], changes[1]) > 12, `nothing is coloured: ${changes}`);
  assert.ok(changes[2] <= 2 && changes[3] <= 2, `farther than 20 mm: ${changes}`);
  away.forEach((colour, k) => {
    if (k > 1) assert.ok(Math.abs(colour[1] - off[k][1]) <= 2, "the tool went away");
  });
});

scene("in parallel projection the same is picked, filled and hidden, before the eye and behind it", async () => {
  const found = await inPage(
    async ({ stage, geometry, pick, colour, settled, whole }, { manifest, poses }) => {
      const perspective = await colour([0.02, 0, 0.03]);
      stage.camera.setParallel(true);
      await whole();
      const size = Math.abs(stage.camera.project([1, -0.9, 0]).x - stage.camera.project([0, -0.9, 0]).x);
      const behind = Math.abs(stage.camera.project([1, 5, 0]).x - stage.camera.project([0, 5, 0]).x);
      const parts = [pick([0, 0, 0]), pick([0.7, 0, 0]), pick([-0.7, 0, 0.7]), pick([1.4, 0, 0])];
      // Nearer than the eye's own place: zoomed in, the eye would be inside of the block.
      stage.camera.dolly(0.05, [0, 0, 0]);
      const inside = pick([0.01, 0, 0.01]);
      stage.camera.dolly(20, [0, 0, 0]);
      stage.setSections([{ normal: [0, 1, 0], offset: 0 }]);
      const cut = pick([0, 0, 0]);
      const filled = await colour([0.02, 0, 0.03]);
      stage.setSections([{ normal: [1, 0, 0], offset: 0 }]);
      const across = pick([0.2, 0, 0.2]);
      const half = pick([-0.2, 0, 0.2]);
      stage.setSections([]);
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      const held = [];
      for (const pose of poses) {
        stage.setPose(pose, null);
        held.push(pick([pose[3], 0, pose[11]]));
      }
      await settled();
      return { perspective, size, behind, parts, inside, cut, filled, across, half, held };
    },
    { manifest: HELD.manifest, poses: [AT(0, -0.6, 0), AT(0, 0.8, 0)] },
  );
  assert.ok(Math.abs(found.size - found.behind) < 1e-6, "a metre is as long in every depth");
  assert.deepEqual(
    found.parts.map((hit) => hit?.part),
    [1, 2, 0, undefined],
  );
  [-0.2, -0.1, 0.5].forEach((depth, k) => {
    assert.ok(Math.abs(found.parts[k].point[1] - depth) < 1e-3, `${found.parts[k].point} is not at ${depth}`);
  });
  assert.equal(found.inside.part, 1);
  assert.ok(Math.abs(found.inside.point[1] + 0.2) < 1e-3, "nothing before the target is cut off");
  assert.ok(Math.abs(found.cut.point[1]) < 1e-3, `the fill is at ${found.cut.point}`);
  assert.notDeepEqual(found.filled, found.perspective);
  assert.equal(found.across.part, 1);
  assert.ok(Math.abs(found.across.point[1] + 0.2) < 1e-3, "a plane along the view fills nothing");
  assert.equal(found.half?.part, undefined, "cut away, with the wall behind it");
  assert.equal(found.held[0].held, true);
  assert.equal(found.held[1].held, false, "behind the block and the wall");
});

scene("figures lie over their marks", async () => {
  const found = await inPage(({ stage, NO_MARKS, at }) => {
    const line = { from: [0.2, -0.3, 0], to: [0.6, -0.3, 0], text: "400 mm" };
    stage.setMarks({ ...NO_MARKS, distance: line });
    stage.frame(performance.now());
    const figure = document.querySelector("#labels .mark");
    const box = figure.getBoundingClientRect();
    return { text: figure.textContent, x: box.x + box.width / 2, y: box.y + box.height / 2, at: at([0.4, -0.3, 0]) };
  });
  assert.equal(found.text, "400 mm");
  assert.ok(Math.abs(found.x - found.at[0]) < 4 && Math.abs(found.y - found.at[1]) < 40);
});

scene("a picture for keeping has its own size, and shows the same", async () => {
  const { size, colour, seen, kept } = await inPage(async ({ stage, settled, colour: colourOf }) => {
    await settled();
    const seen = await colourOf([0.21, -0.2, 0.22]);
    const image = await createImageBitmap(await stage.shot(320, 180));
    const canvas = new OffscreenCanvas(320, 180);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { x, y } = stage.camera.project([0.21, -0.2, 0.22]);
    const colour = Array.from(context.getImageData(Math.floor(x / 2), Math.floor(y / 2), 1, 1).data);
    stage.frame(performance.now());
    return { size: [image.width, image.height], colour, seen, kept: stage.stats.isKept };
  });
  assert.deepEqual(size, [320, 180]);
  for (let k = 0; k < 3; k++) assert.ok(Math.abs(colour[k] - seen[k]) <= 3, `${colour} is not ${seen}`);
  assert.equal(kept, true, "the kept layer outlives a picture");
});

scene("while it stands, edges are smoothed", async () => {
  const { first, last } = await inPage(async ({ stage, coloursAt, at, settled, whole }) => {
    // The edge of the wall, turned a little: a staircase until it is averaged.
    stage.camera.roll(0.06);
    await whole();
    const [x, y] = at([-1, 0.5, 0]);
    const pixels = Array.from({ length: 60 * 12 }, (_, k) => [x - 6 + (k % 12), y - 30 + Math.floor(k / 12)]);
    const shades = async () => new Set((await coloursAt(pixels)).map(String)).size;
    const first = await shades();
    await settled();
    return { first, last: await shades() };
  });
  assert.ok(last > first, `${first} shades before, ${last} after`);
});

scene("a lost context comes back with everything on it", async () => {
  const { was, is, hit, told } = await inPage(
    async ({ stage, geometry, colours, pick, whole, settled }, { manifest, pose }) => {
      let told = 0;
      stage.onRestored(() => told++);
      stage.setPartStates(Uint8Array.of(0, 8, 0));
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      stage.setPose(pose, null);
      await settled();
      const all = () => colours([0.21, -0.2, 0.22], [0.7, 0, 0], [0.02, -0.7, 0.02]);
      const was = await all();
      const gl = stage.renderer.getContext();
      const extension = gl.getExtension("WEBGL_lose_context");
      const event = (name) => new Promise((resolve) => stage.canvas.addEventListener(name, resolve, { once: true }));
      const lost = event("webglcontextlost");
      extension.loseContext();
      await lost;
      stage.frame(performance.now());
      const restored = event("webglcontextrestored");
      // A context can be restored only once the event of its loss is over.
      await new Promise((resolve) => setTimeout(resolve));
      extension.restoreContext();
      await restored;
      await whole();
      const hit = pick([0.7, 0, 0]);
      await settled();
      return { was, is: await all(), hit, told };
    },
    { manifest: HELD.manifest, pose: AT(0, -0.6, 0) },
  );
  assert.deepEqual(is, was);
  assert.equal(hit.part, 2);
  assert.equal(told, 1);
  // Three says as an error that it was lost.
  const unexpected = tab.errors.splice(0).filter((error) => !/Context (Lost|Restored)/.test(error.message));
  assert.deepEqual(unexpected, []);
});

scene("a headset sees the mock-up and what is held with both eyes, and the page its own picture after", async () => {
  const { was, is, eyes } = await inPage(
    async ({ stage, geometry, colours, inHeadset, whole }, { manifest, pose }) => {
      stage.setHeld({ piece: await geometry.loadHeld(1), manifest });
      stage.setPose(pose, null);
      const all = () => colours([0.21, -0.2, 0.22], [0.02, -0.7, 0.02]);
      const was = await all();
      const seen = await inHeadset([0, -2, 0]);
      await whole();
      const isTeal = (c) => c[1] > c[0] + 40 && c[2] > c[0] + 25;
      const isGrey = (c) => c[0] > 90 && Math.max(...c) - Math.min(...c) < 40;
      const eyes = seen.map((set) => {
        const found = [...set].map((text) => text.split(",").map(Number));
        return [found.some(isTeal), found.some(isGrey)];
      });
      return { was, is: await all(), eyes };
    },
    { manifest: HELD.manifest, pose: AT(0, -0.6, 0) },
  );
  assert.deepEqual(eyes, [
    [true, true],
    [true, true],
  ]);
  assert.deepEqual(is, was);
});

scene("the manifest asks for the token", async () => {
  const what = await tab.page.evaluate(
    () =>
      new Promise((resolve) => {
        const worker = new Worker("geometry.js", { type: "module" });
        worker.onmessage = ({ data }) => resolve(data);
        worker.postMessage({ kind: "scene", load: 7, base: `${location.origin}/`, token: "another" });
      }),
  );
  assert.equal(what.kind, "failed");
  assert.match(what.what, /401/);
  tab.errors.length = 0;
});
