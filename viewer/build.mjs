// Builds the page into python/feeler/workbench/static, which the wheel carries.
//
//     node build.mjs                    the page, minified
//     node build.mjs --watch            the same, again after each change
//     node build.mjs --tests            the unit tests, for `node --test`
//
// Says what the page weighs, gzipped.

import { cp, mkdir, readdir, readFile, rm, stat } from "node:fs/promises";
import { dirname, join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import * as esbuild from "esbuild";
import { licences } from "./licences.mjs";

const HERE = dirname(fileURLToPath(import.meta.url));
const STATIC = join(HERE, "..", "python", "feeler", "workbench", "static");
const TESTS = join(HERE, "..", "target", "viewer-tests");

const shared = {
  absWorkingDir: HERE,
  bundle: true,
  format: "esm",
  target: "es2022",
  jsx: "automatic",
  jsxImportSource: "preact",
  legalComments: "none",
  logLevel: "warning",
};

const page = {
  ...shared,
  entryPoints: { main: "src/app/main.ts", geometry: "src/link/geometry.worker.ts", style: "src/ui/style.css" },
  outdir: STATIC,
  minify: true,
  metafile: true,
  plugins: [licences(HERE)],
};

async function files(folder) {
  const found = await readdir(folder, { recursive: true, withFileTypes: true });
  return found.filter((entry) => entry.isFile()).map((entry) => join(entry.parentPath ?? entry.path, entry.name));
}

async function buildPage() {
  await rm(STATIC, { recursive: true, force: true });
  await mkdir(STATIC, { recursive: true });
  await cp(join(HERE, "public"), STATIC, { recursive: true });
  if (process.argv.includes("--watch")) {
    const context = await esbuild.context(page);
    await context.watch();
    return;
  }
  await esbuild.build(page);
  let total = 0;
  for (const path of (await files(STATIC)).sort()) {
    const gzipped = gzipSync(await readFile(path), { level: 9 }).length;
    total += gzipped;
    console.log(`${relative(STATIC, path).padEnd(16)} ${(await stat(path)).size} bytes, ${gzipped} gzipped`);
  }
  console.log(`${"".padEnd(16)} ${total} bytes gzipped in all`);
}

async function buildTests() {
  await rm(TESTS, { recursive: true, force: true });
  const entryPoints = (await files(join(HERE, "test"))).filter((path) => path.endsWith(".test.ts"));
  await esbuild.build({
    ...shared,
    entryPoints,
    outdir: TESTS,
    outExtension: { ".js": ".mjs" },
    platform: "node",
    sourcemap: "inline",
  });
}

await (process.argv.includes("--tests") ? buildTests() : buildPage());
