// Sends files of the user's machine to the server, piece by piece: another mock-up, or a file for a job.

import type { FilePurpose } from "../link/openings";
import type { Workbench } from "./workbench";

/** Of a file in one message: a multiple of the disk's blocks, below the limit of the protocol. */
const PIECE_BYTES = 1 << 18;
/** Messages on the way at a time: while one is written, the next one comes. */
const WINDOW = 2;

/** Sends files, which shows as a job; resolves with the number of the set. Null: it was cancelled, or there is no server. */
export async function sendFiles(wb: Workbench, files: readonly File[], purpose: FilePurpose): Promise<number | null> {
  const { link } = wb;
  if (!link) return null;
  const sending = wb.local(`Sending ${files.length === 1 ? files[0]?.name : `${files.length} files`}`);
  try {
    const listed = files.map((file) => ({ name: file.name, bytes: file.size }));
    const number = await link.sendFiles(purpose, listed);
    const total = Math.max(
      1,
      files.reduce((sum, file) => sum + file.size, 0),
    );
    let sent = 0;
    for (const [at, file] of files.entries()) {
      const waiting: Promise<void>[] = [];
      for (let from = 0; from < file.size; from += PIECE_BYTES) {
        if (sending.is_cancelled) return null;
        const data = new Uint8Array(await file.slice(from, from + PIECE_BYTES).arrayBuffer());
        waiting.push(link.sendPiece(number, at, data));
        if (waiting.length >= WINDOW) await waiting.shift();
        sent += data.length;
        sending.tell(sent / total);
      }
      await Promise.all(waiting);
    }
    return number;
  } finally {
    sending.end();
  }
}
