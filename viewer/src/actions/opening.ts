// Opening another mock-up: files of the user's machine, which the page sends to the server, or a sample.

import type { Opens } from "../link/openings";
import type { Document, Unit } from "../link/protocol";
import { chooseSeveral } from "./choosing";
import { takeFindings } from "./findings";
import { isMechanism, openMechanism } from "./joints";
import { sendFiles } from "./sending";
import type { Workbench } from "./workbench";

/** The suffix of a name, in lower case: ".stl". */
export const suffixOf = (name: string): string => /\.[^./\\]+$/.exec(name)?.[0].toLowerCase() ?? "";

/** The suffix of projects, which the command opens: a page cannot name the file that is to be saved. */
const PROJECT = ".feelproj";

/** `Notice.of` of what was refused while a mock-up was loading. */
export const WHILE_LOADING = "while loading";

/** Why these files cannot be opened, in a sentence; null: they can. */
export function whyNot(files: readonly Pick<File, "name" | "size">[], opens: Opens): string | null {
  if (files.length === 0) return "No file was chosen.";
  const project = files.find((file) => suffixOf(file.name) === PROJECT);
  if (project) return `${project.name} is a project: start feeler view ${project.name} to open it.`;
  const { meshes, mechanisms } = parted(files);
  if (mechanisms.length > 1) return `${mechanisms.length} mechanisms were chosen: choose one with the mock-up.`;
  const known = new Set([...opens.formats, ...opens.companions]);
  const other = meshes.find((file) => !known.has(suffixOf(file.name)));
  const isMesh = meshes.some((file) => opens.formats.includes(suffixOf(file.name)));
  if (other || !isMesh) {
    return `${(other ?? files[0])?.name} is in no format that feeler reads: choose ${opens.formats.join(", ")}.`;
  }
  if (meshes.length > opens.most_files) {
    return `${meshes.length} files are more than ${opens.most_files}: start feeler view with their folder.`;
  }
  const bytes = meshes.reduce((sum, file) => sum + file.size, 0);
  if (bytes > opens.most_bytes) return "The files are too large to send: start feeler view with them.";
  return null;
}

/** The files of a mock-up, and the mechanisms that were chosen with them. */
function parted<Named extends Pick<File, "name">>(files: readonly Named[]): { meshes: Named[]; mechanisms: Named[] } {
  return { meshes: files.filter((file) => !isMechanism(file)), mechanisms: files.filter(isMechanism) };
}

/** Whether something would be lost with the present mock-up. */
export function hasWork(wb: Workbench): boolean {
  const document = wb.document;
  if (!document?.mockup) return false;
  const { sequence, measures, viewpoints, findings, gripped, moved, cards } = document;
  return (
    [sequence, measures, viewpoints, gripped, Object.keys(moved), cards].some((each) => each.length > 0) ||
    findings !== null
  );
}

/** Lets the user choose files. */
export function chooseFiles(wb: Workbench): void {
  const { opens } = wb.store;
  const accept = [...(opens.peek()?.formats ?? []), ...(opens.peek()?.companions ?? []), ".toml"].join(",");
  chooseSeveral(accept, (files) => takeFiles(wb, files));
}

/** Opens files that were chosen or dropped: findings beside the mock-up, a mock-up in place of it. */
export function takeFiles(wb: Workbench, files: readonly File[]): void {
  const { store } = wb;
  const [first] = files;
  if (!first) return;
  if (files.length === 1 && suffixOf(first.name) === ".json") {
    void takeFindings(wb, first);
    return;
  }
  if (files.length === 1 && isMechanism(first)) {
    void openMechanism(wb, first);
    return;
  }
  const opens = store.opens.peek();
  const wrong = opens ? whyNot(files, opens) : "No other mock-up can be opened here: start feeler view with it.";
  if (wrong) {
    store.notify("error", wrong);
    return;
  }
  if (hasWork(wb)) {
    store.pending_files.value = files;
    store.dialog.value = "open";
  } else void openFiles(wb, files);
}

/** Sends files and opens them; a mechanism among them once the mock-up is there. */
export async function openFiles(wb: Workbench, files: readonly File[], unit: string | null = null): Promise<void> {
  const { link, store } = wb;
  store.pending_files.value = [];
  if (store.dialog.peek() === "open") store.dialog.value = null;
  const { meshes, mechanisms } = parted(files);
  const [mechanism] = mechanisms;
  const loading = new AbortController();
  try {
    const number = await sendFiles(wb, meshes, "open");
    if (number === null || !link) return;
    const isThere = mechanism && isOpened(store.document, meshes, loading.signal);
    await link.openMockup({ files: number, sample: null, unit });
    if (mechanism && (await isThere)) await openMechanism(wb, mechanism);
  } catch (error) {
    loading.abort();
    refused(wb, error);
  }
}

/** A value that changes: what `isOpened` needs of a signal. */
interface Watched<T> {
  peek(): T;
  subscribe(told: (now: T) => void): () => void;
}

/** Ends once a mock-up was loaded: whether it is the one of these files. What fails leaves the present one, and is told. */
export function isOpened(
  document: Watched<Document | null>,
  files: readonly Pick<File, "name">[],
  signal: AbortSignal,
): Promise<boolean> {
  const before = document.peek()?.mockup ?? null;
  return new Promise((resolve) => {
    let hasBegun = false;
    const end = document.subscribe((now) => {
      if (now?.loading) hasBegun = true;
      else if (now && hasBegun) {
        hasBegun = false;
        queueMicrotask(() => end());
        const { mockup } = now;
        // The same file again may leave the same facts.
        resolve(mockup !== null && (mockup !== before || files.some((file) => file.name === mockup.name)));
      }
    });
    signal.addEventListener("abort", () => {
      end();
      resolve(false);
    });
  });
}

export async function openSample(wb: Workbench, sample: string): Promise<void> {
  wb.store.dialog.value = null;
  await asked(wb, { files: null, sample, unit: null });
}

/** The numbers of the present files are of another unit. */
export async function reopenIn(wb: Workbench, unit: Unit): Promise<void> {
  wb.store.dialog.value = null;
  await asked(wb, { files: null, sample: null, unit });
}

async function asked(wb: Workbench, what: { files: null; sample: string | null; unit: string | null }): Promise<void> {
  try {
    await wb.link?.openMockup(what);
  } catch (error) {
    refused(wb, error);
  }
}

/** What is refused because a mock-up is loading stands until that is over. */
function refused(wb: Workbench, error: unknown): void {
  wb.tell(error, wb.document?.loading ? WHILE_LOADING : undefined);
}
