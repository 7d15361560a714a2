// The document: applies patches; the order of contact modes.

import type { Document, Mode } from "../link/protocol";

export const MODES: readonly Mode[] = ["stop", "glide", "pass"];

/** The document with the patch's fields in place of its own. */
export const patched = (document: Document, fields: Partial<Document>): Document => ({ ...document, ...fields });

/** The mock-up to show: none while another one is loading. */
export const shownMockup = (document: Document | null): Document["mockup"] =>
  document && !document.loading && !document.failed ? document.mockup : null;
