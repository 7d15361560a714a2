// Fetches the manifest, the pieces and the held mesh outside the page's thread, and transfers the buffers without a copy.
// Makes fields for the heat map there, too.

import { heatField } from "../math/heat-field";
import type { GeometryMessage, GeometryWish } from "./geometry";
import { inOrder } from "./ordered";
import type { Manifest } from "./protocol";
import { SharedShapes } from "./shared";

// Few enough that the first, the big shapes, are not slowed by those behind them.
const AT_ONCE = 4;

const scope = self as unknown as {
  postMessage(message: GeometryMessage, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<GeometryWish>) => void) | null;
};

// A page that does not draw, as it is hidden, does not say that it has drawn the first piece.
const LONGEST_PAUSE_MS = 500;

const running = new Map<number, AbortController>();
const paused = new Map<number, () => void>();

/** Until the page has drawn the first piece. */
function firstDrawn(load: number): Promise<void> {
  return new Promise((resolve) => {
    paused.set(load, resolve);
    setTimeout(resolve, LONGEST_PAUSE_MS);
  });
}

async function get(url: string, token: string, signal: AbortSignal): Promise<Response> {
  const headers = token === "" ? {} : { Authorization: `Bearer ${token}` };
  const response = await fetch(url, { headers, signal, cache: "no-store" });
  if (!response.ok)
    throw new Error(`The server answered ${response.status} to ${new URL(url).pathname}: reload the page.`);
  return response;
}

async function loadScene(wish: GeometryWish & { kind: "scene" }, signal: AbortSignal): Promise<void> {
  const { base, token, load } = wish;
  const fetchPiece = async (k: number) => (await get(`${base}scene/sent/${k}`, token, signal)).arrayBuffer();
  // The first picture waits for both.
  const first = fetchPiece(0);
  first.catch(() => undefined);
  const manifest = (await (await get(`${base}scene`, token, signal)).json()) as Manifest;
  scope.postMessage({ kind: "manifest", load, manifest });
  const shapes = new SharedShapes();
  const piece = (k: number) => (k === 0 ? first : fetchPiece(k));
  for await (const [k, sent] of inOrder(manifest.pieces.length, AT_ONCE, piece, () => firstDrawn(load))) {
    const data = shapes.whole(sent, manifest.part_bytes);
    scope.postMessage({ kind: "piece", load, k, data }, [data]);
  }
  scope.postMessage({ kind: "done", load });
}

async function loadHeld(wish: GeometryWish & { kind: "held" }, signal: AbortSignal): Promise<void> {
  const { base, token, load, version } = wish;
  const data = await (await get(`${base}held/${version}`, token, signal)).arrayBuffer();
  scope.postMessage({ kind: "held", load, data }, [data]);
}

scope.onmessage = ({ data: wish }) => {
  if (wish.kind === "abort") {
    running.get(wish.load)?.abort();
    return;
  }
  if (wish.kind === "go_on") {
    paused.get(wish.load)?.();
    return;
  }
  if (wish.kind === "field") {
    const field = heatField(wish.pieces, wish.lower, wish.upper);
    scope.postMessage({ kind: "field", load: wish.load, field }, [field.data.buffer as ArrayBuffer]);
    return;
  }
  const controller = new AbortController();
  running.set(wish.load, controller);
  const work = wish.kind === "scene" ? loadScene(wish, controller.signal) : loadHeld(wish, controller.signal);
  work
    .catch((error: unknown) => {
      if (controller.signal.aborted) return;
      controller.abort();
      scope.postMessage({
        kind: "failed",
        load: wish.load,
        what: error instanceof Error ? error.message : String(error),
      });
    })
    .finally(() => {
      running.delete(wish.load);
      paused.delete(wish.load);
    });
};
