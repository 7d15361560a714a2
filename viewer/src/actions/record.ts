// A record that the workbench was opened with: played from any moment, and scrubbed. The server shows its moments.

import type { Workbench } from "./workbench";

let is_seeking = false;

/** Whether this page can pause the replay. */
export const canPause = (wb: Workbench): boolean => wb.store.replay.value !== null;

/** The moment that is shown, or that will be, seconds. */
export const recordAt = (wb: Workbench): number =>
  wb.store.wanted_moment.value ?? wb.store.document.value?.record?.at ?? 0;

/** Plays from `start`; without one exactly from the beginning, which compares all results. */
export async function playRecord(wb: Workbench, start?: number): Promise<void> {
  const speed = wb.store.speed.peek();
  const job = wb.job("replay", start === undefined ? { speed } : { start, speed }, "Replay");
  if (!job) return;
  wb.store.replay.value = job;
  try {
    await job.result;
  } catch (error) {
    if (wb.store.replay.peek() === job) wb.tell(error);
  } finally {
    if (wb.store.replay.peek() === job) wb.store.replay.value = null;
  }
}

/** Pauses the replay of this page, or goes on from the moment that is shown. */
export function toggleRecord(wb: Workbench): void {
  const job = wb.store.replay.peek();
  const record = wb.store.document.peek()?.record;
  if (job) {
    // The pause was asked for: its refusal is no news.
    wb.store.replay.value = null;
    job.cancel();
    return;
  }
  const seconds = wb.store.timeline.peek()?.seconds ?? 0;
  const at = record?.at;
  void playRecord(wb, at == null || at >= seconds - 1e-6 ? undefined : at);
}

/** Shows a moment. While one is on its way only the newest wish waits. */
export async function seekRecord(wb: Workbench, at: number): Promise<void> {
  wb.store.wanted_moment.value = at;
  if (is_seeking) return;
  is_seeking = true;
  try {
    for (let now: number | null = at; now !== null; ) {
      await wb.job("replay_to", { at: now }, "Going to that moment")?.result;
      const next = wb.store.wanted_moment.peek();
      now = next === now ? null : next;
    }
  } catch (error) {
    wb.tell(error);
  } finally {
    is_seeking = false;
    wb.store.wanted_moment.value = null;
  }
}
