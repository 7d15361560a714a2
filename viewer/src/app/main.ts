// The start of the page: the elements to draw on, the page, the components.

import { h, render } from "preact";
import { takeToken } from "../link/link";
import { OfflineError, readOffline } from "../link/offline-file";
import { App, type PictureElements } from "../ui/app";
import type { FeelerApi } from "./api";
import { makeCompass } from "./compass";
import { Page } from "./page";

declare global {
  interface Window {
    feeler?: FeelerApi;
  }
}

function makePicture(): PictureElements {
  const canvas = document.createElement("canvas");
  canvas.id = "picture";
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", "The mock-up. Drag to look around; press ? for all keys.");
  const gizmo = document.createElement("canvas");
  gizmo.className = "gizmo";
  gizmo.hidden = true;
  gizmo.setAttribute("aria-hidden", "true");
  const labels = document.createElement("div");
  labels.className = "labels";
  labels.setAttribute("aria-hidden", "true");
  const tether = document.createElement("div");
  tether.className = "tether";
  tether.hidden = true;
  const arrow = document.createElement("button");
  arrow.type = "button";
  arrow.className = "tool-arrow";
  arrow.hidden = true;
  arrow.title = "The tool is out of the picture: look at it (Shift+F)";
  arrow.setAttribute("aria-label", "Look at the tool, which is out of the picture");
  const head = document.createElement("span");
  head.textContent = "➤";
  head.setAttribute("aria-hidden", "true");
  arrow.append(head);
  const cuts = document.createElement("div");
  cuts.className = "cuts";
  // The panel of the cuts has the same by keys.
  cuts.setAttribute("aria-hidden", "true");
  return { canvas, gizmo, labels, tether, arrow, cuts, ...makeCompass() };
}

async function start(root: HTMLElement): Promise<void> {
  const offline = await readOffline();
  const picture = makePicture();
  const page = new Page(picture, offline ? null : takeToken(location, history, sessionStorage));
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const follow = (): void => {
    page.store.is_system_dark.value = dark.matches;
    page.store.is_motion_reduced.value = still.matches;
  };
  follow();
  for (const query of [dark, still]) query.addEventListener("change", follow);
  window.feeler = page.api();
  render(h(App, { workbench: page.wb, picture }), root);
  if (offline) page.showOffline(offline);
}

const root = document.getElementById("app");
if (root) {
  start(root).catch((error: unknown) => {
    // Nothing of the page may be there: plain text is all that can be relied on.
    const what = error instanceof Error ? error.message : String(error);
    const advice = error instanceof OfflineError ? "" : " It needs a browser with WebGL 2.";
    root.textContent = `The workbench cannot start. ${what}${advice}`;
    root.className = "no-start";
  });
}
