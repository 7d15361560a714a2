// A record that the workbench was opened with: played from any moment, and scrubbed. The server shows its moments.

import { effect, signal } from "@preact/signals";
import type { Job } from "../link/link";
import type { Jobs } from "../link/protocol";
import type { Workbench } from "./workbench";

/** The replay that this page began; null: none, or another page did. */
const playing = signal<Job<Jobs["replay"]["answer"]> | null>(null);
/** The moment that was scrubbed to, until the server shows it. */
const wanted = signal<number | null>(null);
let is_seeking = false;

/** Whether this page can pause the replay. */
export const canPause = (): boolean => playing.value !== null;

/** The moment that is shown, or that will be, seconds. */
export const recordAt = (wb: Workbench): number => wanted.value ?? wb.store.document.value?.record?.at ?? 0;

/** Plays from `start`; without one exactly from the beginning, which compares all results. */
export async function playRecord(wb: Workbench, start?: number): Promise<void> {
  const speed = wb.store.speed.peek();
  const job = wb.job("replay", start === undefined ? { speed } : { start, speed }, "Replay");
  if (!job) return;
  playing.value = job;
  try {
    await job.result;
  } catch (error) {
    if (playing.peek() === job) wb.tell(error);
  } finally {
    if (playing.peek() === job) playing.value = null;
  }
}

/** Pauses the replay of this page, or goes on from the moment that is shown. */
export function toggleRecord(wb: Workbench): void {
  const job = playing.peek();
  const record = wb.store.document.peek()?.record;
  if (job) {
    // The pause was asked for: its refusal is no news.
    playing.value = null;
    job.cancel();
    return;
  }
  const seconds = wb.store.timeline.peek()?.seconds ?? 0;
  const at = record?.at;
  void playRecord(wb, at == null || at >= seconds - 1e-6 ? undefined : at);
}

/** Shows a moment. While one is on its way only the newest wish waits. */
export async function seekRecord(wb: Workbench, at: number): Promise<void> {
  wanted.value = at;
  if (is_seeking) return;
  is_seeking = true;
  try {
    for (let now: number | null = at; now !== null; ) {
      await wb.job("replay_to", { at: now }, "Going to that moment")?.result;
      const next = wanted.peek();
      now = next === now ? null : next;
    }
  } catch (error) {
    wb.tell(error);
  } finally {
    is_seeking = false;
    wanted.value = null;
  }
}

/** Fetches the timeline of the record, and again when its gaps are known. */
export function followRecord(wb: Workbench): () => void {
  let known = "";
  return effect(() => {
    const record = wb.store.document.value?.record;
    const key = record && wb.store.connection.value === "open" ? `${record.name} ${record.has_gaps}` : "";
    if (key === known) return;
    known = key;
    if (key === "") return;
    wb.ask("record", {})
      .then((timeline) => {
        wb.store.timeline.value = timeline;
      })
      .catch((error: unknown) => {
        known = "";
        wb.tell(error);
      });
  });
}
