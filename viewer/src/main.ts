// The start of the page: the elements to draw on, the page, the components.

import { h, render } from "preact";
import type { FeelerApi } from "./api";
import { takeToken } from "./link";
import { Page } from "./page";
import { App, type PictureElements } from "./ui/app";

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
  return { canvas, gizmo, labels };
}

function start(): void {
  const root = document.getElementById("app");
  if (!root) return;
  try {
    const picture = makePicture();
    const page = new Page(picture, takeToken(location, history, sessionStorage));
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const follow = (): void => {
      page.store.is_system_dark.value = dark.matches;
    };
    follow();
    dark.addEventListener("change", follow);
    window.feeler = page.api();
    render(h(App, { workbench: page.wb, picture }), root);
  } catch (error) {
    const text = error instanceof Error ? error.message : String(error);
    root.textContent = `The workbench cannot start: ${text}. It needs a browser with WebGL 2.`;
    root.className = "no-start";
  }
}

start();
