// A server of the stage's test page and of pieces, and a Chromium that opens it.

import { createServer } from "node:http";
import { dirname } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";
import { chromium } from "playwright-core";
import { CHROMIUM, PATIENCE_MS } from "./browser.mjs";

const HERE = dirname(fileURLToPath(import.meta.url));
const HTML = `<!doctype html><html><head><style>
  body { margin: 0; } canvas { display: block; width: 100vw; height: 100vh; }
  #labels { position: absolute; inset: 0; overflow: hidden; pointer-events: none; font: 12px sans-serif; }
  .mark { padding: 1px 5px; border-radius: 4px; background: #111c; color: #fff; white-space: nowrap; }
</style></head><body><canvas></canvas><div id="labels"></div><script type="module" src="page.js"></script></body></html>`;

async function bundle() {
  const built = await esbuild.build({
    absWorkingDir: HERE,
    entryPoints: { page: "page.ts", geometry: "../../src/link/geometry.worker.ts" },
    outdir: "out",
    write: false,
    bundle: true,
    format: "esm",
    target: "es2022",
    logLevel: "warning",
  });
  return Object.fromEntries(built.outputFiles.map((file) => [`/${file.path.split("/").pop()}`, file.text]));
}

/** Serves the page, and `answer(path)` (a Buffer or null) for all else to who brings the token. Returns { url, close }. */
export async function serve(answer) {
  const scripts = await bundle();
  const server = createServer(async (request, response) => {
    const path = new URL(request.url, "http://localhost").pathname;
    if (path === "/") return response.setHeader("Content-Type", "text/html").end(HTML);
    if (path === "/favicon.ico") {
      response.statusCode = 204;
      return response.end();
    }
    if (path in scripts) return response.setHeader("Content-Type", "text/javascript").end(scripts[path]);
    const isAllowed = request.headers.authorization === "Bearer token of the test";
    const body = isAllowed ? await answer(path) : null;
    response.statusCode = isAllowed ? (body ? 200 : 404) : 401;
    return response.end(body ?? "");
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** Opens the page at `url` in a Chromium with a software device. Errors of the page are thrown by `close`. */
export async function open(url, { width = 640, height = 360 } = {}) {
  const browser = await chromium.launch({
    executablePath: CHROMIUM,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
  const page = await browser.newPage({ viewport: { width, height } });
  const errors = [];
  page.on("pageerror", (error) => errors.push(error));
  page.on("console", (message) => {
    if (message.type() === "error" || /WebGL|GL_INVALID/.test(message.text())) errors.push(new Error(message.text()));
  });
  page.setDefaultTimeout(PATIENCE_MS);
  try {
    await page.goto(url);
    await page.waitForFunction(() => window.harness !== undefined);
  } catch (error) {
    await browser.close(); // else the test waits for it for ever
    throw error;
  }
  return {
    page,
    errors,
    close: async () => {
      await browser.close();
      if (errors.length > 0) throw errors[0];
    },
  };
}
