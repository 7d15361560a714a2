// Opening another mock-up: files of the user's machine, which the page sends to the server, or a sample.

import type { Opens } from "../link/openings";
import type { Unit } from "../link/protocol";
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
  const [first] = files;
  if (!first) return "No file was chosen.";
  const project = files.find((file) => suffixOf(file.name) === PROJECT);
  if (project) return `${project.name} is a project: start feeler view ${project.name} to open it.`;
  const known = new Set([...opens.formats, ...opens.companions]);
  const other = files.find((file) => !known.has(suffixOf(file.name)));
  const isMesh = files.some((file) => opens.formats.includes(suffixOf(file.name)));
  if (other || !isMesh) {
    return `${(other ?? first).name} is in no format that feeler reads: choose ${opens.formats.join(", ")}.`;
  }
  if (files.length > opens.most_files) {
    return `${files.length} files are more than ${opens.most_files}: start feeler view with their folder.`;
  }
  const bytes = files.reduce((sum, file) => sum + file.size, 0);
  if (bytes > opens.most_bytes) return "The files are too large to send: start feeler view with them.";
  return null;
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
  const accept = [...(opens.peek()?.formats ?? []), ...(opens.peek()?.companions ?? [])].join(",");
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

/** Sends files and opens them. */
export async function openFiles(wb: Workbench, files: readonly File[], unit: string | null = null): Promise<void> {
  const { link, store } = wb;
  store.pending_files.value = [];
  if (store.dialog.peek() === "open") store.dialog.value = null;
  try {
    const number = await sendFiles(wb, files, "open");
    if (number !== null) await link?.openMockup({ files: number, sample: null, unit });
  } catch (error) {
    refused(wb, error);
  }
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
