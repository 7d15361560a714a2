// Written by tools/protocol_ts.py from python/feeler/workbench (protocol.py, commands.py, asking.py): change it there.
// SI: metres, newtons, radians; poses are world_from_tool, row by row. `frames.ts` packs and unpacks binary data.

export type FilePurpose = "open" | "job";

/** Bytes of a file in one message. */
export const MOST_PIECE_BYTES = 524288;

/** What a page may open in place of the present mock-up. */
export interface Opens {
  /** Suffixes of files, such as ".stl". */
  readonly formats: readonly string[];
  /** Suffixes of files that others of them need. */
  readonly companions: readonly string[];
  readonly samples: readonly string[];
  /** Of all files together. */
  readonly most_bytes: number;
  readonly most_files: number;
}

/** A file of the user's machine. */
export interface FileToSend {
  /** Without folders. */
  readonly name: string;
  readonly bytes: number;
}

/**
 * Announces files: to open in place of the mock-up, or one for a job. Answered by a reply with their number,
 * "files".
 */
export interface SendFiles {
  readonly kind: "send_files";
  readonly id: number;
  readonly purpose: FilePurpose;
  readonly files: readonly FileToSend[];
}

/** The next bytes of an announced file. Answered by a reply, for which the page waits before the next one. */
export interface FilePiece {
  readonly kind: "file_piece";
  readonly id: number;
  readonly files: number;
  /** Index in `SendFiles.files`. */
  readonly file: number;
  readonly data: Uint8Array;
}

/**
 * Opens another mock-up: files that were sent, or a sample; or the present one with other options.
 *
 * Answered at once; the document then shows the progress.
 */
export interface OpenMockup {
  readonly kind: "open_mockup";
  readonly id: number;
  readonly files: number | null;
  readonly sample: string | null;
  /** Of the files; null: as they say. */
  readonly unit: string | null;
}

export type OpeningRequest = SendFiles | FilePiece | OpenMockup;
