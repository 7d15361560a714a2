// The page's data as signals: the server's document, the newest state, and the page's own state.

import { computed, type Signal, signal } from "@preact/signals";
import type { Opens } from "../link/openings";
import type {
  CardAnswer,
  Document,
  JointPlace,
  Manifest,
  MeasureType,
  RecordTimeline,
  SequenceFilm,
  State,
} from "../link/protocol";
import { isSame } from "../math/same";
import type { Box, Vec3 } from "../math/vectors";
import type { Film } from "./film";
import { FindingState } from "./finding-state";
import type { JointsShown } from "./joints";
import {
  type Connection,
  type ContextMenu,
  type Dialog,
  type Drawer,
  knownPanel,
  type Notice,
  type Panel,
} from "./page-state";
import { PartTree } from "./part-tree";
import { PeopleState } from "./people";
import { drawnSections } from "./sections";
import { loadSettings, type Settings } from "./settings";
import type { TypedMove } from "./typed-move";

/** How many notices are kept in sight; of those that only inform, the newest. */
const MOST_NOTICES = 3;
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

/** What the picture shows of a way: its path, the nearest neighbour on it, and the free swing of a tool. World. */
export interface WayMarks {
  readonly path: readonly Vec3[];
  readonly gap: { readonly point: Vec3; readonly value: number; readonly part: number } | null;
  readonly fan: { readonly centre: Vec3; readonly rim: readonly Vec3[]; readonly isGood: boolean } | null;
}

export const NO_WAY: WayMarks = { path: [], gap: null, fan: null };

/** What tasks use of files of the user, by the command that takes them. */
export type TaskFile = "task_times" | "task_catalogue";

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
  /** The link has been down so long that the server is probably gone. */
  readonly is_ended = signal(false);
  /** The link is open, and nothing answers: the program hangs, or its machine sleeps. */
  readonly is_silent = signal(false);
  /** What can be opened in place of the present mock-up; null: nothing. */
  readonly opens = signal<Opens | null>(null);
  /** Files that were dropped, until it is said that the present mock-up may go. */
  readonly pending_files = signal<readonly File[]>([]);
  /** Files are over the page. */
  readonly is_dropping = signal(false);
  /** Steps that can be undone and redone; null until a change told. */
  readonly undo_depth = signal<number | null>(null);
  readonly redo_depth = signal<number | null>(null);
  readonly is_recording = signal(false);
  readonly has_device = signal(false);

  readonly selection = signal<ReadonlySet<number>>(new Set());
  /** The part under the pointer; -1: none. */
  readonly hover = signal(-1);
  /** The point of the mock-up under the pointer. */
  readonly pointed = signal<Vec3 | null>(null);
  /** Who else is there, and who has the tool. */
  readonly people = new PeopleState();
  readonly search = signal("");
  readonly dialog = signal<Dialog>(null);
  /** The step of the tour that is shown, from 0; null: none. */
  readonly tour_step = signal<number | null>(null);
  readonly menu = signal<ContextMenu | null>(null);
  readonly notices = signal<readonly Notice[]>([]);
  readonly typed = signal<TypedMove | null>(null);
  /** Moving the tool by keys was refused, or ended by another person: the keys that follow do nothing. */
  readonly is_typing_refused = signal(false);
  readonly measuring = signal<Measuring | null>(null);
  readonly snap = signal<{ point: Vec3; type: "vertex" | "edge" | "face" } | null>(null);
  readonly section_draft = signal<SectionDraft | null>(null);
  /** The section box while one of its faces is dragged. */
  readonly box_draft = signal<Box | null>(null);
  /** The next click on the picture cuts along the face there. */
  readonly is_picking_face = signal(false);
  /** The findings, and how they are shown. */
  readonly findings = new FindingState(this.document);
  /** The card whose answer is open. */
  readonly card = signal<number | null>(null);
  /** The answers that were fetched, by card. */
  readonly answers = signal<ReadonlyMap<number, CardAnswer>>(new Map());
  /** Which tools a task is planned with; none: their reach is not checked. */
  readonly task_tools = signal<"catalogue" | "own" | "none">("catalogue");
  /** Why files that were opened for tasks are not used; empty: nothing is wrong. */
  readonly task_troubles: Readonly<Record<TaskFile, Signal<string>>> = {
    task_times: signal(""),
    task_catalogue: signal(""),
  };
  /** How many people a task is planned for. */
  readonly people_count = signal(1);
  readonly film = signal<Film | null>(null);
  /** The sequence as a film; null before it was fetched. */
  readonly sequence_film = signal<SequenceFilm["ways"] | null>(null);
  /** How fast films and records play. */
  readonly speed = signal(1);
  /** The record over time; null before it was fetched. */
  readonly timeline = signal<RecordTimeline | null>(null);
  /** The replay that this page began, to cancel it; null: none, or another page did. */
  readonly replay = signal<{ cancel(): void } | null>(null);
  /** The moment of the record that was scrubbed to, until the server shows it. */
  readonly wanted_moment = signal<number | null>(null);
  /** The fastener at which the tool is seated. */
  readonly reach = signal<CardAnswer["reaches"][number] | null>(null);
  readonly way_marks = signal<WayMarks>(NO_WAY);
  /** Where the joints are shown while they are moved; null: where the document has them. */
  readonly joints_shown = signal<JointsShown | null>(null);
  /** Where the joint got to that this page moved last. */
  readonly joint_place = signal<JointPlace | null>(null);
  /** The number whose worst position is shown as a ghost. */
  readonly joint_ghost = signal<string | null>(null);
  readonly jobs = signal<readonly JobShown[]>([]);
  readonly settings = signal<Settings>(loadSettings());
  /** The open panel: kept over reloads. */
  readonly panel = signal<Panel>(knownPanel(this.settings.peek().panel));
  /** The text of the live region. */
  readonly spoken = signal("");
  /** A headset is there. */
  readonly is_xr_there = signal(false);
  readonly is_system_dark = signal(true);
  /** The system asks for reduced motion. */
  readonly is_motion_reduced = signal(false);
  /** The window is too narrow for tree and panels at once: they are drawers. */
  readonly is_narrow = signal(false);
  /** It is worked by fingers: targets are larger. */
  readonly is_coarse = signal(false);
  readonly drawer = signal<Drawer>(null);

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
  readonly is_tree_shown = computed(() =>
    this.is_narrow.value ? this.drawer.value === "tree" : this.settings.value.is_tree_open,
  );
  readonly are_panels_shown = computed(() =>
    this.is_narrow.value ? this.drawer.value === "panels" : this.settings.value.are_panels_open,
  );
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
  /** The drawn section box, a dragged face at its dragged place; null: none is on. */
  readonly drawn_box = computed((): Box | null => {
    const box = this.document.value?.section_box;
    if (!box?.is_on) return null;
    return this.box_draft.value ?? { lower: [...box.lower], upper: [...box.upper] };
  });
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

  /** Shows a notice; `of`: the command that was refused. */
  notify(level: Notice["level"], text: string, of?: string): void {
    const id = this.next_notice++;
    const others = this.notices
      .peek()
      .filter((notice) => notice.text !== text && !(level === "info" && notice.level === "info"));
    this.notices.value = [...others, { id, level, text, of }].slice(-MOST_NOTICES);
    if (level === "info") setTimeout(() => this.dismiss(id), INFO_MS);
  }

  /** Opens or closes the tree: beside the picture, or over it. */
  showTree(is_shown: boolean): void {
    if (this.is_narrow.peek()) this.showDrawer(is_shown ? "tree" : null);
    else this.set({ is_tree_open: is_shown });
  }

  showPanels(is_shown: boolean): void {
    if (this.is_narrow.peek()) this.showDrawer(is_shown ? "panels" : null);
    else this.set({ are_panels_open: is_shown });
  }

  showDrawer(drawer: Drawer): void {
    this.drawer.value = drawer;
  }

  /** Takes away a notice that is true no longer. */
  dismissText(text: string): void {
    this.notices.value = this.notices.peek().filter((notice) => notice.text !== text);
  }

  /** Takes away what was refused for a reason that is over. */
  dismissOf(of: string): void {
    for (const notice of this.notices.peek()) if (notice.of === of) this.dismiss(notice.id);
  }

  dismiss(id: number): void {
    this.notices.value = this.notices.peek().filter((notice) => notice.id !== id);
  }

  set(changes: Partial<Settings>): void {
    this.settings.value = { ...this.settings.peek(), ...changes };
  }
}
