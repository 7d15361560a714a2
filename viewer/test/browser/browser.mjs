// What the tests in a real browser share: a Chromium, and a page made of modules of src.

import { access } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";
import { chromium } from "playwright-core";

const VIEWER = join(dirname(fileURLToPath(import.meta.url)), "..", "..");
export const CHROMIUM = process.env.FEELER_CHROMIUM ?? "/usr/bin/chromium";
const FLAGS = [
  "--no-sandbox",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  // Else the software renderer also composes the page, and copies each frame.
  "--disable-gpu-rasterization",
  "--disable-gpu-compositing",
];
const ORIGIN = "http://localhost:8";
/** A page of a busy machine may take long. */
export const PATIENCE_MS = 120_000;

/** Why the browser tests cannot run here; false where they can. */
export const whySkipped = await access(CHROMIUM).then(
  () => false,
  () => `NO CHROMIUM at ${CHROMIUM}: the tests in a browser did not run (apt install chromium, or set FEELER_CHROMIUM)`,
);
if (whySkipped && process.env.CI) throw new Error(`${whySkipped}; CI may not leave them out`);
if (whySkipped) console.error(whySkipped);

/** Opens a page that runs `source` (TypeScript, relative to viewer/) and closes it when the test `t` ends. */
export async function openPage(t, source, flags = []) {
  const built = await esbuild.build({
    stdin: { contents: source, resolveDir: VIEWER, loader: "ts" },
    ...{ bundle: true, write: false, format: "esm", target: "es2022", logLevel: "warning" },
  });
  const browser = await chromium.launch({ executablePath: CHROMIUM, args: [...FLAGS, ...flags] });
  t.after(() => browser.close());
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(message.text());
  });
  // localhost is a secure context, which WebXR and WebHID ask for; nothing listens there.
  await page.route(`${ORIGIN}/**`, (route) => {
    const isScript = route.request().url().endsWith(".js");
    if (isScript) return route.fulfill({ contentType: "text/javascript", body: built.outputFiles[0].text });
    return route.fulfill({
      contentType: "text/html",
      body: '<!doctype html><link rel="icon" href="data:,"><canvas id="canvas"></canvas><script type="module" src="page.js"></script>',
    });
  });
  await page.goto(`${ORIGIN}/`);
  return { page, errors };
}
