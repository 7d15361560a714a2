// The page's data as signals: the server's document, the newest state, and the page's own state.

import { computed, signal } from "@preact/signals";
import type { Document, Manifest, MeasureType, State } from "../link/protocol";
import { isSame } from "../math/same";
import type { Vec3 } from "../math/vectors";
import { FindingState } from "./finding-state";
import type { Connection, ContextMenu, Dialog, Notice, Panel } from "./page-state";
import { PartTree } from "./part-tree";
import { drawnSections } from "./sections";
import { loadSettings, type Settings } from "./settings";
import type { TypedMove } from "./typed-move";

/** How many notices are kept in sight. */
const MOST_NOTICES = 4;
/** Notices that need no answer vanish by themselves. */
const INFO_MS = 10_000;

/** The current measurement: the points clicked so far, and the one under the pointer. */
export interface Measuring {
  readonly type: MeasureType;
  readonly picks: readonly MeasurePick[];
}

export interface MeasurePick {
  readonly part: number;
  readonly triangle: number;
  readonly point: Vec3;
  /** The edge of the triangle that is nearest. */
  readonly edge: readonly [Vec3, Vec3];
}

/** A job under way, as the status line shows it. */
export interface JobShown {
  readonly id: number;
  readonly title: string;
  readonly share: number;
  readonly cancel: () => void;
}

/** A section as it is dragged, before the server knows. */
export interface SectionDraft {
  readonly id: number;
  readonly normal: Vec3;
  readonly offset: number;
}

export class Store {
  readonly document = signal<Document | null>(null);
  /** The newest state, and only in frames that draw it: panels that show figures follow `shown_state`. */
  readonly state = signal<State | null>(null);
  readonly manifest = signal<Manifest | null>(null);
  /** How much of the geometry has come, 0 to 1; null before any. */
  readonly geometry_share = signal<number | null>(null);
  /** Why the geometry did not come. */
  readonly geometry_failed = signal<string | null>(null);
  readonly connection = signal<Connection>("connecting");
  /** Steps that can be undone and redone; null until a change told. */
  readonly undo_depth = signal<number | null>(null);
  readonly redo_depth = signal<number | null>(null);
  readonly is_recording = signal(false);
  readonly has_device = signal(false);

  readonly selection = signal<ReadonlySet<number>>(new Set());
  /** The part under the pointer; -1: none. */
  readonly hover = signal(-1);
  readonly search = signal("");
  readonly panel = signal<Panel>("pose");
  readonly dialog = signal<Dialog>(null);
  /** The step of the tour that is shown, from 0; null: none. */
  readonly tour_step = signal<number | null>(null);
  readonly menu = signal<ContextMenu | null>(null);
  readonly notices = signal<readonly Notice[]>([]);
  readonly typed = signal<TypedMove | null>(null);
  readonly measuring = signal<Measuring | null>(null);
  readonly snap = signal<{ point: Vec3; type: "vertex" | "edge" | "face" } | null>(null);
  readonly section_draft = signal<SectionDraft | null>(null);
  readonly findings = new FindingState(this.document);
  readonly jobs = signal<readonly JobShown[]>([]);
  readonly settings = signal<Settings>(loadSettings());
  /** The text of the live region. */
  readonly spoken = signal("");
  /** A headset is there. */
  readonly is_xr_there = signal(false);
  readonly is_system_dark = signal(true);

  /** The parts that were left out of the scene: nobody sees them. */
  readonly absent = computed(() => {
    const absent = this.document.value?.absent ?? [];
    // A document that came anew has the same ones in another array: the tree stays as it was opened.
    if (!isSame(absent, this.last_absent)) this.last_absent = absent;
    return this.last_absent;
  });
  readonly tree = computed(() => new PartTree(this.manifest.value?.parts.paths ?? [], new Set(this.absent.value)));
  readonly paths = computed(() => this.manifest.value?.parts.paths ?? []);
  /** How many parts are in the scene. */
  readonly part_count = computed(() => this.paths.value.length - this.absent.value.length);
  readonly unit = computed(() => this.document.value?.unit ?? "mm");
  readonly theme = computed(() => {
    const chosen = this.settings.value.theme;
    if (chosen !== "system") return chosen;
    return this.is_system_dark.value ? "dark" : "light";
  });
  /** A record is being gone through. */
  readonly is_replaying = computed(() => this.document.value?.record?.is_playing ?? false);
  /** Nothing can be changed: one file without a server, the link is down, or a record is replayed. */
  readonly is_read_only = computed(() => this.connection.value !== "open" || this.is_replaying.value);
  /** Visibility can be changed: also in one file without a server. */
  readonly can_look = computed(() => !this.is_read_only.value || this.connection.value === "offline");
  /** The drawn cuts, the dragged one at its dragged place. */
  readonly drawn_sections = computed(() =>
    drawnSections(this.document.value?.sections ?? [], this.section_draft.value),
  );
  readonly hidden = computed(() => new Set(this.document.value?.hidden ?? []));
  readonly ghost = computed(() => new Set(this.document.value?.ghost ?? []));
  readonly has_hand = computed(() => {
    const document = this.document.value;
    return document !== null && (document.tool !== null || document.gripped.length > 0);
  });

  private next_notice = 1;
  private last_absent: readonly number[] = [];

  /** The name to show for a part. */
  nameOf(part: number): string {
    return this.paths.value[part]?.split("/").at(-1) ?? `part ${part}`;
  }

  notify(level: Notice["level"], text: string): void {
    const id = this.next_notice++;
    const others = this.notices.peek().filter((notice) => notice.text !== text);
    this.notices.value = [...others, { id, level, text }].slice(-MOST_NOTICES);
    if (level === "info") setTimeout(() => this.dismiss(id), INFO_MS);
  }

  dismiss(id: number): void {
    this.notices.value = this.notices.peek().filter((notice) => notice.id !== id);
  }

  set(changes: Partial<Settings>): void {
    this.settings.value = { ...this.settings.peek(), ...changes };
  }
}
