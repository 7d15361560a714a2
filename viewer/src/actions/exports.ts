// Exports: pictures, and the files that jobs of the server write.

import type { Camera, Viewpoint } from "../link/protocol";
import { showCutsOf } from "./sections";
import type { Workbench } from "./workbench";

/** Pictures have one size, independent of the window's. */
export const SHOT_WIDTH = 1920;
export const SHOT_HEIGHT = 1080;

export const EXPORTS = {
  export_csv: "Sequence as CSV",
  export_html: "Sequence as a page",
  export_glb: "Sequence as animated GLB",
  page: "One HTML file to send",
  report: "Report (HTML)",
  export_project: "Project file",
} as const;

export type Export = keyof typeof EXPORTS;

/** Lets the server write a file, and downloads it. */
export async function exportFile(wb: Workbench, name: Export): Promise<void> {
  const args = name === "page" ? { camera: wb.stage.camera.toJSON() } : {};
  const job = wb.job(name, args, EXPORTS[name]);
  if (!job) return;
  try {
    const result = await job.result;
    download(await wb.fetchFile(result.name), result.name);
    wb.store.notify("info", `${result.name} was written`);
  } catch (error) {
    wb.tell(error);
  }
}

/** Keeps the camera as a viewpoint, and downloads the picture. */
export async function takeSnapshot(wb: Workbench): Promise<void> {
  const camera = wb.stage.camera.toJSON();
  const name = `View ${(wb.document?.viewpoints.length ?? 0) + 1}`;
  try {
    const picture = await wb.stage.shot(SHOT_WIDTH, SHOT_HEIGHT);
    download(picture, `${fileName(wb.document?.mockup?.name ?? "feeler")}-${fileName(name)}.png`);
    if (!wb.store.is_read_only.peek()) await wb.run("viewpoint_add", { name, camera });
    wb.say("Picture taken");
  } catch (error) {
    wb.tell(error);
  }
}

/** Puts the camera where a viewpoint has it, and its cuts. */
export function lookFrom(wb: Workbench, viewpoint: Viewpoint): void {
  const { camera } = viewpoint;
  showCutsOf(wb, viewpoint);
  wb.look((each) => each.fromJSON(camera));
  wb.store.set({ is_parallel: camera.is_parallel ?? false });
}

/** A picture at a size, from a camera if one is given, as base64 of a PNG. */
export async function pictureFor(wb: Workbench, width: number, height: number, camera: Camera | null): Promise<string> {
  const before = wb.stage.camera.toJSON();
  if (camera) wb.stage.camera.fromJSON(camera);
  try {
    return base64(new Uint8Array(await (await wb.stage.shot(width, height)).arrayBuffer()));
  } finally {
    if (camera) wb.stage.camera.fromJSON(before);
    wb.redraw();
  }
}

/** Bytes as base64, in blocks that a call's arguments can hold. */
export function base64(bytes: Uint8Array): string {
  let text = "";
  for (let k = 0; k < bytes.length; k += 8192) text += String.fromCharCode(...bytes.subarray(k, k + 8192));
  return btoa(text);
}

const fileName = (text: string): string => text.replace(/[^\w.-]+/g, "-").replace(/^-+|-+$/g, "") || "feeler";

/** Lets the browser save a file. */
export function download(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The browser has begun to read by then.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
