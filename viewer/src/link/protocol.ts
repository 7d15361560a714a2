// Written by tools/protocol_ts.py from python/feeler/workbench (protocol.py, commands.py, asking.py): change it there.
// SI: metres, newtons, radians; poses are world_from_tool, row by row. `frames.ts` packs and unpacks binary data.

import { MOST_PIECE_BYTES, type OpeningRequest, type Opens } from "./openings";

/** Version of the protocol: pages with another one must reload. */
export const PROTOCOL_VERSION = 1;

export type Vec3 = [number, number, number];

/** Where a camera is, and what it looks at. */
export interface CameraPlace {
  readonly position: Vec3;
  readonly target: Vec3;
  readonly up: Vec3;
  /** Vertical field of view. */
  readonly fov_rad: number;
}

/** A camera. */
export interface Camera extends CameraPlace {
  /** Parallel projection, as high at the target as the perspective view; absent: perspective. */
  readonly is_parallel?: boolean;
}

/** How a part differs from the one of the revision that a result was computed on. */
export interface StalePart {
  readonly change: "changed" | "moved" | "new";
}

/** A pattern that does not name a part any more, as that has another name: its paths now and before. */
export interface LeftPattern {
  readonly pattern: string;
  readonly of: "requirement" | "rule";
  readonly part: string;
  readonly was: string;
}

/** Characters of a person's name. */
export const MOST_NAME = 40;

/** Parts of a selection that others see. */
export const MOST_SELECTED = 1000;

/** A page tells where its person is at most once in this time; the server passes it on no faster. */
export const LEAST_HERE_MS = 100;

export type Holder = "page" | "script" | "device";

export type TurnWish = "take" | "ask" | "give" | "keep" | "let_go";

/** Somebody with a page. */
export interface Person {
  readonly id: number;
  /** Plain text, different from all others. */
  readonly name: string;
  /** A number from 0, different from all others. */
  readonly colour: number;
  /** The page has said nothing for some seconds: it is hidden, or its machine sleeps. */
  readonly is_away: boolean;
}

/** Who has the tool, and what it holds. */
export interface Turn {
  /** Null: nobody. */
  readonly kind: Holder | null;
  /** The page's; null: not a page. */
  readonly person: number | null;
  /** Anybody may take it, by moving it: nobody has it, or its holder has not moved it for some seconds. */
  readonly is_free: boolean;
  /** Persons who asked for it, in this order. */
  readonly asked: readonly number[];
}

/** The name of the page's person. Empty: the default, "Guest 1". */
export interface Named {
  readonly kind: "name";
  readonly name: string;
}

/** Where the page's person points and looks, and what is selected. Only the newest counts. */
export interface Here {
  readonly kind: "here";
  /** On the mock-up, under the pointer. Null: nowhere. */
  readonly point: Vec3 | null;
  /** Parts, at most `MOST_SELECTED`. */
  readonly selection: readonly number[];
  readonly camera: Camera;
  /** The person holds the tool, even if it does not move at this moment. */
  readonly is_moving: boolean;
}

/** Takes the tool if it is free, asks for it, gives it to `to`, keeps it, or lets it go. Answered by a reply. */
export interface Turning {
  readonly kind: "turn";
  readonly id: number;
  readonly wish: TurnWish;
  /** A person, for "give". */
  readonly to: number | null;
}

export type PersonMessage = Named | Here | Turning;

/** The people with a page, and who has the tool. A newer message replaces it. */
export interface People {
  readonly kind: "people";
  readonly you: number;
  /** In the order in which they came. */
  readonly people: readonly Person[];
  readonly turn: Turn;
}

/** Where another person points and looks, and what is selected there. A newer message replaces it. */
export interface Seen {
  readonly kind: "seen";
  readonly person: number;
  readonly point: Vec3 | null;
  readonly selection: readonly number[];
  readonly camera: Camera;
}

export type FindingStatus = "new" | "active" | "reviewed" | "approved" | "resolved";

export type FindingFormat = "json" | "csv" | "xlsx" | "html" | "bcf" | "rules";

/** A group of findings that somebody made. */
export interface OwnGroup {
  readonly id: number;
  readonly name: string;
}

/** A clash check that was run here. */
export interface Check {
  /** Metres. */
  readonly clearance: number;
  /** Metres; null: the chordal errors of both parts. */
  readonly contact: number | null;
  /** The parts whose pairs were checked; null: all. */
  readonly of: readonly number[] | null;
  /** Where parts lay, as `moved`, `out` and `gripped` of the document: the findings are stale if that changed. */
  readonly moved: Readonly<Record<string, readonly number[]>>;
  readonly out: readonly number[];
  readonly gripped: readonly number[];
}

/** The findings of a clash check, without their rows, which are `GET /findings/VERSION`: see `FindingRows`. */
export interface Findings {
  readonly version: string;
  readonly count: number;
  /** Number of findings by verdict. */
  readonly counts: Readonly<Record<string, number>>;
  /** Number of findings that each exclusion of the rules hides, by its name. */
  readonly hidden: Readonly<Record<string, number>>;
  /** By the finding's id, where it is not that of its row. */
  readonly status: Readonly<Record<string, FindingStatus>>;
  /** The same. */
  readonly notes: Readonly<Record<string, string>>;
  readonly own_groups: readonly OwnGroup[];
  /** The own group of a finding, by the finding's id. */
  readonly members: Readonly<Record<string, number>>;
  readonly is_touching_hidden: boolean;
  /** Null: the findings are of a file. */
  readonly check: Check | null;
  /** By part id: parts that differ since, in another revision, also those without findings. */
  readonly stale: Readonly<Record<string, StalePart>>;
}

/** How the next clash check is made. */
export interface ClashSettings {
  /** Metres. */
  readonly clearance: number;
  /** Metres; null: the chordal errors of both parts. */
  readonly contact: number | null;
  /** TOML, as for `feeler clash --rules`. */
  readonly rules: string;
}

/** What a requirement was when it was checked last. Metres. */
export interface RequirementVerdict {
  readonly status: "holds" | "violated" | "unknown";
  /** Pairs of parts that violate it; the others are of the worst of them. */
  readonly pairs: number;
  readonly gap: number | null;
  readonly depth: number | null;
  readonly parts: readonly number[];
  readonly points: readonly [number, number, number][];
  /** Why it is not known. */
  readonly trouble: string | null;
  /** Where parts lay, as in `Check`. */
  readonly moved: Readonly<Record<string, readonly number[]>>;
  readonly out: readonly number[];
  readonly gripped: readonly number[];
  /** By part id: parts that it is about and that differ since, in another revision. */
  readonly stale: Readonly<Record<string, StalePart>>;
}

/** The verdict of a requirement, by its id. */
export interface RequirementResult {
  readonly id: number;
  readonly verdict: RequirementVerdict;
}

/** A clearance that must hold: parts of pattern `a` stay at least `gap` metres away from those of `b`. */
export interface KeptClear {
  readonly id: number;
  readonly name: string;
  readonly a: string;
  readonly b: string;
  readonly gap: number;
  /** Null: it was not checked as it is. */
  readonly verdict: RequirementVerdict | null;
}

/** Findings that the command "findings_take" opens. */
export interface Taken {
  readonly key: string;
  readonly count: number;
  /** Findings of before that were not found again. */
  readonly gone: number;
  /** What the check did not do, for people. */
  readonly notes: readonly string[];
}

/** Patterns of paths for pairs like that of a finding, and how many findings they hide. */
export interface Alike {
  readonly a: string;
  readonly b: string;
  readonly count: number;
}

/** From where a finding is seen. */
export interface FindingSide {
  /** From the contact to the eye, unit. */
  readonly direction: [number, number, number];
  /** The part around the other one: to be drawn see-through. */
  readonly cover: number | null;
}

/** How many findings an exclusion would hide. */
export interface Hides {
  readonly count: number;
  /** What is wrong with the patterns. */
  readonly trouble: string | null;
}

/** The rows of the findings, `GET /findings/VERSION`; it is never sent by the socket. The worst come first. */
export interface FindingRows {
  readonly kind: "findings";
  readonly version: string;
  /** JSON: `FindingWords`. */
  readonly words: Uint8Array;
  /** The part of each of the words' paths; 4294967295: none in this mock-up. */
  readonly part_of_path: Uint32Array;
  /** Indices into the paths. */
  readonly pairs: Uint32Array;
  /** Indices into verdicts, rules and groups. */
  readonly labels: Uint32Array;
  /** Severity (critical, major, minor), status, kind of depth (none, measured, estimate, bound, exact), touches. */
  readonly codes: Uint8Array;
  /** Depth, its error, gap, shared volume: metres, NaN where not known. */
  readonly sizes: Float32Array;
  /** Point of the first part, of the second, translation of the first out of the second; NaN where not known. */
  readonly places: Float32Array;
}

/** The texts of findings. */
export interface FindingWords {
  readonly ids: readonly string[];
  readonly paths: readonly string[];
  readonly verdicts: readonly string[];
  readonly rules: readonly string[];
  readonly groups: readonly string[];
  /** By id. */
  readonly notes: Readonly<Record<string, string>>;
}

/** A number of a position. */
export interface JointNumber {
  readonly name: string;
  readonly kind: "turn" | "slide";
  /** Its place among the links. */
  readonly link: number;
  /** The number that it follows; its own name if it follows none. */
  readonly root: string;
  /** One of the numbers that move with it, the same of all. */
  readonly group: string;
  /** Where its link is modelled. */
  readonly axis: Vec3;
  readonly point: Vec3;
  /** Metres a turn of a screw; else 0. */
  readonly pitch: number;
  readonly limits: [number, number] | null;
}

/** Parts that a joint moves as one. */
export interface JointLink {
  readonly name: string;
  /** The place of the link that it hangs on; -1: the frame. */
  readonly above: number;
  readonly parts: readonly number[];
  /** world_from_modelled, row by row. */
  readonly pose: readonly number[];
}

/** A mechanism, and its position. */
export interface Mechanism {
  readonly name: string;
  readonly numbers: readonly JointNumber[];
  readonly links: readonly JointLink[];
  readonly values: Readonly<Record<string, number>>;
}

/** A moving part, the other one that it meets, and where. */
export interface JointMet {
  readonly part: number;
  readonly other: number;
  readonly point: Vec3;
}

/** The position with the least gap. */
export interface JointWorst {
  readonly value: number;
  /** Metres; no smaller one was found. */
  readonly gap: number;
  readonly part: number;
  readonly other: number;
  readonly points: [Vec3, Vec3];
  /** Of the links. */
  readonly poses: readonly (readonly number[])[];
}

/** How far a number moves freely, with the others where they stand. */
export interface JointRange {
  readonly name: string;
  readonly state: "running" | "done" | "failed";
  /** Of the work, 0 to 1; the range itself is known from 0.2 on. */
  readonly share: number;
  readonly lower: number;
  readonly upper: number;
  /** What ends it; null: a limit, or the end of what was looked at. */
  readonly below: JointMet | null;
  readonly above: JointMet | null;
  /** Values, and the gap there in metres; null: nothing is near. */
  readonly curve: readonly [number, number | null][];
  readonly worst: JointWorst | null;
  readonly trouble: string;
}

/** The move of a line of the sequence. */
export interface JointStep {
  readonly name: string;
  readonly kind: "turn" | "slide";
  readonly begin: number;
  readonly end: number;
}

/** Where the links are shown, until the next message or patch. A newer message replaces it. */
export interface Joints {
  readonly kind: "joints";
  /** Of the links, world_from_modelled; null: where the document has them. */
  readonly poses: readonly (readonly number[])[] | null;
  readonly values: Readonly<Record<string, number>>;
}

export type TaskEditKind = "off" | "on" | "time" | "before" | "free";

/** What the user changed of a task. */
export interface TaskEdits {
  /** Paths of parts that are off already. */
  readonly off: readonly string[];
  /** Paths of parts, and the seconds that were typed for their steps. */
  readonly times: readonly [string, number][];
  /** Pairs of paths: the first goes before the second. */
  readonly before: readonly [string, string][];
  /** A digest of the table of times; empty: the examples. */
  readonly table: string;
  /** A digest of the catalogue, where tools are chosen from it; empty: the built-in one. */
  readonly catalogue: string;
}

/** The table of times that tasks use. */
export interface TaskTimes {
  /** Of its file; empty: all figures are examples. */
  readonly name: string;
  /** How many of the elements it gives. */
  readonly given: number;
}

/** The catalogue that tools of tasks are chosen from. */
export interface TaskCatalogue {
  /** Of its file; empty: the built-in one. */
  readonly name: string;
  /** How many it has. */
  readonly tools: number;
}

/** The parts that a joint moves, at its worst position. */
export interface JointGhost {
  /** In the world's frame. */
  readonly manifest: HeldManifest;
  /** Base64 of its pieces, one after the other. */
  readonly data: string;
}

/** Where a joint got to, as far as contact let it. */
export interface JointPlace {
  readonly name: string;
  /** Radians or metres. */
  readonly value: number;
  /** What ends it there. end: neither contact nor a limit, and `why` says what. */
  readonly stop: "contact" | "limit" | "end" | null;
  /** The contact that stops the joint; null without one. */
  readonly met: JointMet | null;
  readonly why: string;
  /** All numbers. */
  readonly values: Readonly<Record<string, number>>;
}

/** The first visible hit of a ray. */
export interface RayHit {
  readonly distance: number;
  readonly point: Vec3;
  readonly normal: Vec3;
  readonly part: number;
  /** Of the mock-up; -1: the fill of a section. */
  readonly triangle: number;
}

/** The same, with the point snapped to a near corner or edge. */
export interface Snapped extends RayHit {
  readonly type: "vertex" | "edge" | "face";
  /** Of the triangle, at its present place. */
  readonly corners: [Vec3, Vec3, Vec3];
}

/** The value of a measure. */
export interface Measured {
  readonly type: MeasureType;
  readonly points: readonly Vec3[];
  readonly value: number;
  readonly unit: "m" | "rad";
  readonly is_exact: boolean;
  readonly parts: readonly number[];
}

/** Facts about a part. */
export interface PartFacts {
  readonly part: number;
  readonly name: string;
  readonly path: string;
  readonly triangles: number;
  /** Null: the part has no triangle that can be queried. */
  readonly lower: Vec3 | null;
  readonly upper: Vec3 | null;
  /** Each edge has as many triangles on one side as on the other. */
  readonly is_closed: boolean;
  /** Cubic metres; null: it is not closed. */
  readonly volume: number | null;
  /** Square metres. */
  readonly area: number;
  readonly state: "gripped" | "moved" | "in place" | "left out";
  readonly is_hidden: boolean;
  /** As its file states them; at most 100. */
  readonly attributes: Readonly<Record<string, string>>;
}

/** The parts that a search finds. */
export interface FoundParts {
  readonly count: number;
  /** Base64 of little-endian uint32 `(count,)`, ascending. */
  readonly parts: string;
}

/** The cuts of the mock-up by planes. */
export interface Outline {
  readonly count: number;
  /** Base64 of little-endian float32 `(count, 2, 3)`: metres, world. */
  readonly segments: string;
  /** Base64 of little-endian uint32 `(count,)`. */
  readonly parts: string;
}

/** A file to fetch: `GET /exports/NAME`. */
export interface Written {
  readonly name: string;
  readonly bytes: number;
}

/** A file of findings or rules. */
export interface WrittenFindings extends Written {
  /** How the file falls short, for people. */
  readonly notes: readonly string[];
}

/** One HTML file with the mock-up inside. */
export interface WrittenPage extends Written {
  /** Triangles that did not fit. */
  readonly left_out: number;
}

/** The result of a replay. */
export interface Replayed {
  readonly is_same: boolean;
  readonly verdict: string;
}

/** The nearest neighbour at one pose of a way, without parts in contact since the start. */
export interface Gap {
  /** Of the length of the way, 0 to 1. */
  readonly share: number;
  /** Metres; null: none within the distance looked at. */
  readonly gap: number | null;
  readonly part: number | null;
  /** On the part, world. */
  readonly point: Vec3 | null;
}

/** Where a way does not hold. */
export interface WayHit {
  /** Of the length of the way, 0 to 1. */
  readonly share: number;
  readonly part: number;
  /** On the part, world. */
  readonly point: Vec3;
}

/** A command of a record. */
export interface RecordStep {
  /** Of the replay, seconds. */
  readonly at: number;
  /** Of the recorded session, seconds since its start. */
  readonly time: number;
  readonly title: string;
}

/** A record over time. */
export interface RecordTimeline {
  /** Of a replay at the recorded speed: pauses are cut. */
  readonly seconds: number;
  readonly steps: readonly RecordStep[];
  /** At some moments, `share` of `seconds`; empty before the record was replayed. */
  readonly gaps: readonly Gap[];
}

/** A way that was found, with what it passes. */
export interface FoundWay extends GivenWay {
  readonly legs: readonly string[];
  /** The travel of the middle of the parts, metres. */
  readonly length: number;
  /** Radians in total. */
  readonly rotation: number;
  /** At some poses of it, in order: between them the gap may be smaller. */
  readonly gaps: readonly Gap[];
}

/** The same, with where parts lie when it begins; of a removal in the sequence also where it does not hold. */
export interface WayFacts extends FoundWay {
  /** Part id -> world_from_part, of parts that are not where they were loaded. */
  readonly places?: Readonly<Record<string, Pose>>;
  readonly hit?: WayHit;
}

/** A line of the sequence, as a way. */
export interface FilmWay extends WayFacts {
  readonly id: number;
  /** world_from_part of its parts before it; those that are missing were at home. */
  readonly starts: Readonly<Record<string, Pose>>;
}

/** The sequence of removals as a film. */
export interface SequenceFilm {
  readonly ways: readonly FilmWay[];
}

/** A part that stops others. */
export interface BlockerFacts {
  readonly part: number;
  /** How many attempts it stopped; 0 for one that holds them by proof. */
  readonly attempts: number;
  /** No path exists while it stays. */
  readonly is_proof: boolean;
  /** The motion of the moving parts where it stopped the best attempt. */
  readonly pose: Pose;
}

/** Which tools reach a fastener. */
export interface ReachFacts {
  readonly part: number | null;
  readonly name: string;
  readonly kind: string;
  /**
   * The one that swings farthest, or the first of the catalogue; the other figures are of it. If none reaches, the
   * one that came nearest; empty: none fits.
   */
  readonly tool: string;
  /** All that reach it, of those that were tried; of a catalogue the first. */
  readonly tools: readonly string[];
  /** It is a tool, or a chain, of the catalogue. */
  readonly is_catalogue: boolean;
  /** Its drive and width, in words; empty: the mesh does not show them. */
  readonly head: string;
  /** For one turn; null: it is not reached, or not known. */
  readonly strokes: number | null;
  /** Whether a hand fits at the grip; null: not asked. */
  readonly has_hand: boolean | null;
  readonly is_reachable: boolean;
  readonly swing_deg: number;
  readonly because: string;
  /** world_from_tool of the tool in its seat, in the middle of the swing. */
  readonly pose: Pose;
  /** The way in; empty: none was found. */
  readonly way: readonly Pose[];
  readonly point: Vec3;
  /** Out of the joint. */
  readonly axis: Vec3;
  /** The path of the tool's far end over its free swing; empty without one. */
  readonly fan: readonly Vec3[];
  readonly blockers: readonly number[];
}

/** A figure with its name, in words. */
export interface Fact {
  readonly name: string;
  readonly figure: string;
}

/** A step of a task; its way is that of the answer with the same number. */
export interface TaskStepFacts {
  /** "undo", "disconnect" or "take out". */
  readonly verb: string;
  /** The fastener, or the first part. */
  readonly part: number;
  /** Empty: by hand, or without tools. */
  readonly tool: string;
  readonly swing_deg: number | null;
  readonly strokes: number;
  /** world_from_tool: the tool's way in, the last one in its seat; empty without one. */
  readonly tool_way: readonly Pose[];
  /** From 0. */
  readonly person: number;
  /** Seconds from the beginning. */
  readonly start: number;
  readonly seconds: number;
  /** The standard deviation, seconds. */
  readonly spread: number;
  /** Steps that have to be done before, by number. */
  readonly after: readonly number[];
  readonly because: string;
  readonly arithmetic: string;
  /** The user typed its time. */
  readonly is_typed: boolean;
}

/** Something that nothing frees. */
export interface TaskBlockerFacts {
  /** Null: all parts asked for, together. */
  readonly part: number | null;
  readonly because: string;
  readonly blockers: readonly number[];
}

/** How parts are taken out; without steps if no plan was found. */
export interface TaskAnswer {
  readonly steps: readonly TaskStepFacts[];
  /** Of the best plan that was found; null: none was. */
  readonly seconds: number | null;
  readonly spread: number | null;
  /** No plan takes fewer seconds. */
  readonly bound: number | null;
  readonly people: number;
  /** The search ended by itself, not at a limit. */
  readonly is_complete: boolean;
  readonly blocked: readonly TaskBlockerFacts[];
  readonly notes: readonly string[];
}

/** A tool in its seat. */
export interface ToolGhost {
  /** In the world's frame. */
  readonly manifest: HeldManifest;
  /** Base64 of its pieces, one after the other. */
  readonly data: string;
}

/** What is seen of the fastener of a step, from the best of the eyes around its head. */
export interface TaskSight {
  /** Of the head, 0 to 1. */
  readonly share: number;
  /** The parts in front of the rest, the worst first. */
  readonly hidden_by: readonly number[];
  /** Base64 of a PNG from that eye; the fastener is blue. */
  readonly picture: string;
  /** Width and height, pixels. */
  readonly size: [number, number];
}

/** The answer of a card, without a task. */
export interface AnswerFacts {
  readonly id: number;
  /** One after the other; for an order, the last one is of the parts asked for. */
  readonly ways: readonly WayFacts[];
  readonly blockers: readonly BlockerFacts[];
  readonly reaches: readonly ReachFacts[];
  /** The swept volume, in the world's frame: its pieces are `GET /cards/ID`. */
  readonly room: HeldManifest | null;
  /** What else is to be said. */
  readonly facts: readonly Fact[];
}

/** The whole answer of a card. */
export interface CardAnswer extends AnswerFacts {
  /** Of a task. */
  readonly task?: TaskAnswer;
}

/** Closes a socket without the token, or past a limit. */
export const NOT_ALLOWED = 1008;

/** Closes a socket of another protocol version: the page must reload. */
export const RELOAD = 4001;

/** Closes a socket of a page beyond the limit: another one must be closed first. */
export const TOO_MANY_PAGES = 4002;

/** Colliding triangles listed in a state, of each side. */
export const MOST_HITS = 20000;

/** Contact planes listed in a state. */
export const MOST_PLANES = 32;

/** Clearance rows listed in a state. */
export const MOST_CLEARANCES = 16;

/** 16 numbers of a rigid pose, row by row. */
export type Pose = readonly number[];

/** Parts: indices, paths or patterns. */
export type Selection = readonly (number | string)[] | number | string;

/** What a command answers. `id`: of what it added. `pose`: of the hand. */
export interface CommandAnswer {
  readonly id?: number;
  readonly pose?: Pose;
  readonly undo_depth?: number;
  readonly redo_depth?: number;
}

export type Unit = "mm" | "cm" | "m" | "in";

export type Mode = "stop" | "glide" | "pass";

export type UpAxis = "x" | "y" | "z";

export type MeasureType = "point" | "edge" | "angle" | "parts";

export type Material = "steel" | "aluminium" | "plastic" | "rubber";

export type CardQuestion = "removal" | "order" | "access" | "swept" | "task";

export type LineQuestion = "way" | "shorten";

export type CardKind = "removal" | "order" | "access" | "swept" | "task" | "way" | "shorten";

export type CardState = "waiting" | "running" | "done" | "failed" | "cancelled";

export type DepthKind = "exact" | "bound" | "estimate";

export type Source = "mouse" | "keys" | "gizmo" | "spacemouse" | "gamepad" | "xr" | "api";

/** Facts about the mock-up. */
export interface MockupFacts {
  readonly name: string;
  /** Hash of its content, hex: the address of its geometry. */
  readonly hash: string;
  /** Of the parts in the scene. */
  readonly triangles: number;
  /** All, including excluded ones: the number of every part is below it. */
  readonly parts: number;
}

/** Facts about the tool in hand. */
export interface ToolFacts {
  readonly name: string;
  readonly triangles: number;
}

/** A record for the job "replay". */
export interface RecordFacts {
  readonly name: string;
  readonly is_playing: boolean;
  /** Whether all results equalled the recorded ones; null before that is known. */
  readonly is_same: boolean | null;
  /** The same as a sentence. */
  readonly verdict: string | null;
  /** The moment that is shown, seconds of the replay; null before one was. */
  readonly at: number | null;
  /** Whether the timeline of the question "record" has gaps. */
  readonly has_gaps: boolean;
}

/** The project file that the document is saved in. */
export interface ProjectFacts {
  readonly name: string;
  readonly state: "saved" | "saving" | "failed" | "read only";
  /** Why it is not saved. */
  readonly trouble: string | null;
  /** By part id: parts that differ from those that the project's answers are about. */
  readonly stale: Readonly<Record<string, "changed" | "moved" | "new">>;
  /** Paths of parts that this revision lacks. */
  readonly gone: readonly string[];
  /** Removals, measures and cards of missing parts, which only the file has until these are back. */
  readonly aside: number;
  /** Patterns of requirements and rules that parts with another name have left. */
  readonly left: readonly LeftPattern[];
}

/** Progress of reading and indexing. */
export interface Loading {
  readonly stage: string;
  /** 0 to 1. */
  readonly share: number;
}

/** A section plane: keeps the points with normal . x >= offset. */
export interface Section {
  readonly id: number;
  /** Unit. */
  readonly normal: Vec3;
  /** Metres along the normal. */
  readonly offset: number;
  readonly is_on: boolean;
}

/** A section box along the world axes: keeps the points inside it. */
export interface SectionBox {
  readonly lower: Vec3;
  readonly upper: Vec3;
  readonly is_on: boolean;
}

/** One removal: parts, their way, and its clearance. */
export interface SequenceLine {
  readonly id: number;
  readonly name: string;
  readonly parts: readonly number[];
  /** world_from_hand. */
  readonly way: readonly Pose[];
  /** Metres; 0 if something touched, null if not known. */
  readonly least_clearance: number | null;
  /** Part paths. */
  readonly touched: readonly string[];
  readonly tool: string | null;
  /** Null: parts were moved freely. */
  readonly joint: JointStep | null;
  /** By part id: parts of any kind that differ since. Empty: it is of the present revision. */
  readonly stale: Readonly<Record<string, StalePart>>;
}

/** A measure with its points. */
export interface Measure {
  readonly id: number;
  readonly name: string;
  readonly type: MeasureType;
  /** Metres. */
  readonly points: readonly Vec3[];
  readonly value: number;
  readonly unit: "m" | "rad";
  /** Computed by the engine on the triangles, not from the picture. */
  readonly is_exact: boolean;
  /** By part id: its parts that differ since. */
  readonly stale: Readonly<Record<string, StalePart>>;
}

/** A stored camera, and the sections of that moment. */
export interface Viewpoint {
  readonly id: number;
  readonly name: string;
  readonly camera: Camera;
  /** Null in viewpoints of older projects: they change no sections. */
  readonly sections: readonly Section[] | null;
  readonly section_box: SectionBox | null;
}

/** A question about parts, and its answer in a sentence; `GET /cards/ID` and the question "card" have the rest. */
export interface Card {
  readonly id: number;
  readonly question: CardKind;
  /** Empty: all fasteners. */
  readonly parts: readonly number[];
  /** Parts left out for this question. */
  readonly without: readonly number[];
  /** Tool, tools, catalogue, people, grip, swing_deg, clearance, seconds, as far as given. */
  readonly options: Readonly<Record<string, unknown>>;
  readonly title: string;
  /** The mock-up that it is about: what is out of it, or moved. */
  readonly setting: string;
  readonly state: CardState;
  /** 0 to 1. */
  readonly share: number;
  readonly stage: string;
  /** The answer; empty before it. */
  readonly sentence: string;
  /** Whether the answer is what one hopes for; null before it, and if it is neither. */
  readonly is_good: boolean | null;
  /** Parts were moved since it was asked; of a line: its way, what is before it, or parts outside of the sequence. */
  readonly is_stale: boolean;
  /** The line of the sequence that it is about; null for questions about parts. */
  readonly line: number | null;
  /** It is about an earlier revision of the mock-up, and so stale. */
  readonly is_earlier: boolean;
  /** Of a task: what the user changed. */
  readonly edits: TaskEdits;
  /** Of a line: the least one of each way of the answer, metres; null where nothing is near. */
  readonly clearances: readonly (number | null)[];
}

/** A way of parts: poses of their motion in the world, the first the identity. */
export interface GivenWay {
  readonly parts: readonly number[];
  readonly poses: readonly Pose[];
  /** Metres; null: nothing near, or not known. */
  readonly clearance: number | null;
}

/** A way that guides the hand, which holds its parts. */
export interface Guiding {
  readonly card: number | null;
  readonly line: number | null;
  /** Of the ways of the card, from 0. */
  readonly step: number;
  readonly parts: readonly number[];
  /** world_from_hand, from where the hand was when it began. */
  readonly way: readonly Pose[];
}

/** The state that a page shows and that commands may change; a reload restores it. */
export interface Document {
  readonly mockup: MockupFacts | null;
  /** Null once the engine answers. */
  readonly loading: Loading | null;
  /** Why there is no mock-up. */
  readonly failed: string | null;
  readonly tool: ToolFacts | null;
  /** Names for `take_tool`. */
  readonly tools: readonly string[];
  readonly record: RecordFacts | null;
  readonly project: ProjectFacts | null;
  /** Parts excluded when the mock-up was opened: they do not collide and are not drawn. */
  readonly absent: readonly number[];
  /** Version of the mesh in hand: fetch `/held/VERSION` when it changes; 0: the hand is empty. */
  readonly held_version: number;
  readonly unit: Unit;
  readonly mode: Mode;
  readonly hidden: readonly number[];
  readonly ghost: readonly number[];
  /** 0 to 1. */
  readonly explode: number;
  readonly isolated: boolean;
  readonly sections: readonly Section[];
  readonly section_box: SectionBox | null;
  /** The last pose of the hand that a command set. */
  readonly pose: Pose;
  readonly gripped: readonly number[];
  /** Part id -> world_from_part; the identity is the loaded place. */
  readonly moved: Readonly<Record<string, Pose>>;
  /** Parts taken out of the mock-up. */
  readonly out: readonly number[];
  readonly sequence: readonly SequenceLine[];
  /** The line of the sequence being replayed. */
  readonly replaying: number | null;
  /** Null: nothing draws the hand. */
  readonly guiding: Guiding | null;
  readonly measures: readonly Measure[];
  readonly viewpoints: readonly Viewpoint[];
  readonly findings: Findings | null;
  readonly cards: readonly Card[];
  readonly clash: ClashSettings;
  readonly task_times: TaskTimes;
  readonly task_catalogue: TaskCatalogue;
  readonly requirements: readonly KeptClear[];
  readonly material: Material | null;
  /** What puts answers about mock-up and tool in doubt, as their loaders found. */
  readonly doubts: readonly string[];
  readonly mechanism: Mechanism | null;
  /** Of its numbers that follow no other. */
  readonly joint_ranges: readonly JointRange[];
  /** The number of the joint on which the hand holds its parts. */
  readonly on_joint: string | null;
}

/** The parts of a mock-up by column. */
export interface ManifestParts {
  /** Empty for excluded parts. */
  readonly paths: readonly string[];
  readonly triangles: readonly number[];
  /** Of each part's box, metres; an empty or excluded part has lower above upper. */
  readonly lower: readonly Vec3[];
  readonly upper: readonly Vec3[];
  /** 1: so small beside the mock-up that it may be skipped while the camera moves. */
  readonly small: readonly number[];
  /** sRGB as 0xRRGGBB, -1 for a part without one; empty: the mock-up has no colours, and the page chooses some. */
  readonly colours: readonly number[];
}

/** One piece of geometry, `GET /scene/pieces/K`. */
export interface ManifestPiece {
  readonly triangles: number;
  readonly vertices: number;
  /** Packed index of its first triangle: the number of triangles in the pieces before it. */
  readonly first: number;
  readonly bytes: number;
  readonly lower: Vec3;
  readonly upper: Vec3;
  /** Of small parts only. */
  readonly small: boolean;
  /** Number of parts with triangles in it. */
  readonly parts: number;
}

/**
 * The geometry of the mock-up, `GET /scene`: pieces, big shapes first, small parts at the end.
 *
 * A piece is little-endian: float32 positions[vertices][3], metres from `middle`; the part of each vertex, uint16 or
 * uint32 as `part_bytes` says, padded to 4 bytes; uint16 index[triangles][3], padded to 4 bytes. A packed triangle is
 * the index of a triangle in the order of the pieces.
 */
export interface Manifest {
  readonly hash: string;
  readonly name: string;
  /** Of the files that it was read from. */
  readonly unit: string;
  readonly up: UpAxis;
  readonly middle: Vec3;
  readonly lower: Vec3;
  readonly upper: Vec3;
  /** In the pieces: the drawn ones. */
  readonly triangles: number;
  readonly vertices: number;
  readonly part_bytes: 2 | 4;
  readonly parts: ManifestParts;
  readonly pieces: readonly ManifestPiece[];
}

/** The geometry in hand, in the hand's frame: its pieces, one after the other, are `GET /held/VERSION`. */
export interface HeldManifest {
  readonly version: number;
  readonly middle: Vec3;
  readonly lower: Vec3;
  readonly upper: Vec3;
  readonly triangles: number;
  readonly vertices: number;
  readonly part_bytes: 2 | 4;
  /** Paths; the part of a vertex is an index into them. */
  readonly parts: readonly string[];
  readonly pieces: readonly ManifestPiece[];
}

/** The distance of tool and mock-up, and the two closest points. */
export interface NearestPoints {
  readonly value: number;
  readonly tool_point: Vec3;
  readonly mockup_point: Vec3;
  readonly part: number;
}

/** An error, its place and a remedy; "where" and "do" may be empty. */
export interface Trouble {
  readonly what: string;
  readonly where: string;
  readonly do: string;
}

/** The first message, within 2 seconds; nothing else is read before it. */
export interface Hello {
  readonly kind: "hello";
  readonly protocol: number;
  readonly token: string;
  /** The session of the page before its connection broke. */
  readonly session: string | null;
  /** The newest that the page has; 0: none. */
  readonly last_event: number;
}

/** The target of the hand. Only the newest counts. */
export interface Wish {
  readonly kind: "pose";
  readonly seq: number;
  /** By the page's clock. */
  readonly time_ms: number;
  readonly source: Source;
  /** world_from_tool, row by row. */
  readonly pose: Float64Array;
}

/** Acknowledges a state. At most two may be unacknowledged. */
export interface Ack {
  readonly kind: "ack";
  readonly seq: number;
}

/** Changes the document. Answered by a reply. */
export interface Command {
  readonly kind: "command";
  readonly id: number;
  readonly name: string;
  readonly args: Readonly<Record<string, unknown>>;
}

/** A question, which changes nothing. Answered by a reply. */
export interface Ask {
  readonly kind: "ask";
  readonly id: number;
  readonly name: string;
  readonly args: Readonly<Record<string, unknown>>;
}

/** Starts a long task: progress comes in messages of the same id, the result as a reply. */
export interface Job {
  readonly kind: "job";
  readonly id: number;
  readonly name: string;
  readonly args: Readonly<Record<string, unknown>>;
}

/** Cancels a job of this page, whose reply is then an error; or drops a file of which pieces came. */
export interface Cancel {
  readonly kind: "cancel";
  readonly id: number;
}

/** Asks whether the server is there: it replies at once, whatever else it does. */
export interface Ping {
  readonly kind: "ping";
  readonly id: number;
}

/** The picture for a "shot" event, or the next piece of it: a message may have 1 MiB, a picture more. */
export interface Shot {
  readonly kind: "shot";
  readonly id: number;
  readonly name: string;
  /** A multiple of 4 characters in each piece but the last. */
  readonly png_base64: string;
  /** Another piece follows. */
  readonly more: boolean;
}

/** The measurements for a "benchmark" event. */
export interface Benchmarked {
  readonly kind: "benchmarked";
  readonly id: number;
  /** As `Figures` of `viewer/src/app/benchmark.ts`. */
  readonly figures: Readonly<Record<string, unknown>>;
}

/** The answer to hello: the whole state. */
export interface Welcome {
  readonly kind: "welcome";
  readonly protocol: number;
  readonly session: string;
  readonly document: Document;
  /** The newest event included in the document; later ones are greater. */
  readonly event: number;
  /** A haptic device moves the hand. */
  readonly device: boolean;
  readonly recording: boolean;
  /** Of the mesh in hand; null: the hand is empty, or there is no mock-up yet. */
  readonly held: HeldManifest | null;
  /** Versions of the server's software, by name. */
  readonly versions: Readonly<Record<string, string>>;
  /** Null: the mock-up cannot be replaced from a page. */
  readonly opens: Opens | null;
}

/** The engine's results at the newest pose. A newer state replaces it. */
export interface State {
  readonly kind: "state";
  readonly seq: number;
  /** The number of the wish that it answers. */
  readonly pose_seq: number;
  readonly engine_us: number;
  /** Time from the wish to the answer. */
  readonly age_ms: number;
  /** Answers per second. */
  readonly rate_hz: number;
  readonly mode: Mode;
  /** No collision and no containment. */
  readonly is_free: boolean;
  /** Contact holds the solid tool back from the wish. */
  readonly blocked: boolean;
  readonly force: Vec3;
  /** About the tool's centre of area, N m. */
  readonly torque: Vec3;
  /** The length of the way out of a penetration; 0: there is none, or it is not known yet. */
  readonly depth: number;
  /** Kind of the depth: no way out is shorter, one may be, or this one does not free the tool. */
  readonly depth_kind: DepthKind;
  /** Colliding triangles of the mock-up, listed or not. */
  readonly hit_count: number;
  /** Number of those not listed. */
  readonly hit_more: number;
  /** Number of contact planes not listed. */
  readonly contact_more: number;
  readonly distance: NearestPoints | null;
  /** Ids of touched parts. */
  readonly parts: readonly number[];
  /** Of the solid tool. */
  readonly pose: Float64Array;
  /** Of the hand. */
  readonly wish: Float64Array;
  /** Packed triangles of the mock-up. */
  readonly hits: Uint32Array;
  /** Packed triangles of the mesh in hand. */
  readonly tool_hits: Uint32Array;
  /** A row per contact: point 3, normal 3 (from the mock-up to the tool), gap, share of the force in newtons. */
  readonly planes: Float32Array;
  readonly plane_parts: Uint32Array;
  /** A row per near part: distance, point on the tool 3, point on the mock-up 3. */
  readonly clearance: Float32Array;
  readonly clearance_parts: Uint32Array;
}

/** A change of the document: the new values of some fields. */
export interface Patch {
  readonly kind: "event";
  readonly type: "patch";
  readonly n: number;
  readonly fields: Partial<Document>;
  /** The command behind it; null: none. */
  readonly command: string | null;
  readonly undo_depth: number;
  readonly redo_depth: number;
}

/** The tool hit a part that it did not touch before. */
export interface Impact {
  readonly kind: "event";
  readonly type: "impact";
  readonly n: number;
  readonly part: number;
  /** The diagonal of its box. */
  readonly part_size_m: number;
  readonly speed_m_per_s: number;
  readonly point: Vec3;
  readonly material: string | null;
  /** Newtons. */
  readonly force: number;
}

/** A notice for the user. */
export interface Notice {
  readonly kind: "event";
  readonly type: "notice";
  readonly n: number;
  readonly level: "info" | "warning" | "error";
  readonly text: string;
}

/** A script requests a picture: one page answers by a shot of the same id. */
export interface ShotWanted {
  readonly kind: "event";
  readonly type: "shot";
  readonly n: number;
  readonly id: number;
  readonly width: number;
  readonly height: number;
  /** Null: the page's own camera. */
  readonly camera: Camera | null;
}

/** Requests measurements of the frame rate: the page answers by a "benchmarked" message of the same id. */
export interface BenchmarkWanted {
  readonly kind: "event";
  readonly type: "benchmark";
  readonly n: number;
  readonly id: number;
}

/** The content of the hand changed: fetch `/held/VERSION`. */
export interface HeldChanged {
  readonly kind: "event";
  readonly type: "held";
  readonly n: number;
  readonly version: number;
  /** Null: the hand is empty. */
  readonly manifest: HeldManifest | null;
}

/**
 * Progress of a job of this page. A newer message replaces it; it is not an event, because other pages ignore
 * it.
 */
export interface Progress {
  readonly kind: "progress";
  readonly id: number;
  /** 0 to 1. */
  readonly share: number;
  readonly stage: string;
}

/** A command, question or job succeeded. */
export interface Answer {
  readonly kind: "reply";
  readonly ok: true;
  readonly id: number;
  readonly result: unknown;
}

/** A command, question or job failed; or a message was invalid. */
export interface Refusal {
  readonly kind: "reply";
  readonly ok: false;
  /** Null: the message had none. */
  readonly id: number | null;
  readonly error: Trouble;
}

/** The places of vertices in a saved page: `lower + whole numbers * step`. */
export interface Grid {
  readonly lower: Vec3;
  readonly step: number;
}

/** The mock-up inside an HTML file; it is never sent. */
export interface SavedPage {
  readonly kind: "page";
  readonly document: Document;
  /** The initial view. Null: the page's own. */
  readonly camera: Camera | null;
  /** Of the included pieces. */
  readonly manifest: Manifest;
  /** Triangles that had no room in the file. */
  readonly left_out: number;
  readonly grid: Grid;
  /** The frame of `FindingRows`; empty: there are none. */
  readonly findings: Uint8Array;
  /** The pieces of the manifest in order, filtered: see `page.py`. */
  readonly pieces: Uint8Array;
}

export type PageMessage = Hello | Wish | Ack | Command | Ask | Job | Cancel | Ping | Shot | Benchmarked;

export type FromPage = PageMessage | OpeningRequest | PersonMessage;

export type ServerEvent = Patch | Impact | Notice | ShotWanted | BenchmarkWanted | HeldChanged;

export type FromServer = Welcome | State | ServerEvent | Progress | Answer | Refusal | People | Seen | Joints;

/** The arguments of commands. */
export interface Commands {
  /** Hides parts; they still collide. */
  readonly hide: { readonly parts: Selection };
  /** Shows hidden parts again. */
  readonly show: { readonly parts: Selection };
  /** Shows all parts, and none as a ghost. */
  readonly show_all: Record<string, never>;
  /** Hides all parts. */
  readonly hide_all: Record<string, never>;
  /** Shows these parts alone; the same call again restores what was hidden before. */
  readonly isolate: { readonly parts: Selection };
  /** Draws parts see-through, or solid again. */
  readonly ghost: { readonly parts: Selection; readonly is_on: boolean };
  /** Draws these parts solid and all others see-through. */
  readonly single_out: { readonly parts: Selection };
  /** Draws the parts apart by a share, 0 to 1. */
  readonly explode: { readonly share: number };
  /** Adds a section plane; `offset` is its distance from the origin along `normal`, metres. */
  readonly section_add: { readonly normal: Vec3; readonly offset: number };
  /** Moves a section plane. */
  readonly section_move: { readonly id: number; readonly normal: Vec3; readonly offset: number };
  /** Switches a section plane on or off. */
  readonly section_switch: { readonly id: number; readonly is_on: boolean };
  /** Removes a section plane. */
  readonly section_remove: { readonly id: number };
  /** Cuts everything outside a box along the world axes away; replaces the box that was there. Metres. */
  readonly section_box: { readonly lower: Vec3; readonly upper: Vec3 };
  /** Switches the section box on or off. */
  readonly section_box_switch: { readonly is_on: boolean };
  /** Removes the section box. */
  readonly section_box_remove: Record<string, never>;
  /** Sets the unit in which lengths are shown. */
  readonly set_unit: { readonly unit: Unit };
  /** Sets the material that contact sounds like; null: steel. */
  readonly set_material: { readonly material: Material | null };
  /** Sets what contact does to the tool: stop, glide or pass. */
  readonly set_mode: { readonly mode: Mode };
  /** Moves the tool to a pose, as far as contact lets it: 16 numbers of world_from_tool, row by row, metres. */
  readonly place: { readonly pose: Pose };
  /** Grips parts: they leave the scene and move with the hand, together with those that it holds already. */
  readonly grip: { readonly parts: Selection };
  /** Releases the gripped parts where they are; if they moved, this adds a step to the sequence. */
  readonly release: Record<string, never>;
  /** Puts parts back into their places. */
  readonly put_back: { readonly parts: Selection };
  /** Takes another tool, or none; where it would collide, it starts beside the mock-up. */
  readonly take_tool: { readonly name: string | null };
  /** Adds a measure. */
  readonly measure_add: {
    readonly type: MeasureType;
    readonly points?: readonly Vec3[];
    readonly parts?: Selection;
    readonly triangles?: readonly number[];
    readonly name?: string;
  };
  /** Renames the measure `id`, or measures something else, as `measure_add` does. */
  readonly measure_edit: {
    readonly id: number;
    readonly type?: MeasureType;
    readonly points?: readonly Vec3[];
    readonly parts?: Selection;
    readonly triangles?: readonly number[];
    readonly name?: string;
  };
  /** Removes a measure. */
  readonly measure_remove: { readonly id: number };
  /** Saves a camera, and the sections as they are. */
  readonly viewpoint_add: { readonly name?: string; readonly camera: Camera };
  /** Restores the sections that a viewpoint was saved with; the camera belongs to the page. */
  readonly viewpoint_show: { readonly id: number };
  /** Removes a saved camera. */
  readonly viewpoint_remove: { readonly id: number };
  /** Renames a step of the sequence. */
  readonly sequence_rename: { readonly id: number; readonly name: string };
  /** Moves a step of the sequence to another place in the order. */
  readonly sequence_move: { readonly id: number; readonly index: number };
  /** Removes a step of the sequence; its parts stay where they are. */
  readonly sequence_remove: { readonly id: number };
  /** Replays a step of the sequence: grips its parts where they were and moves them along its path. */
  readonly sequence_replay: { readonly id: number };
  /** Opens the findings of a clash check, as `feeler clash --json` writes them. */
  readonly findings_open: { readonly findings: unknown };
  /** Opens the findings that a job found. `saved`: these findings, for a record that is replayed. */
  readonly findings_take: { readonly key: string; readonly saved?: unknown };
  /** Closes the findings. */
  readonly findings_close: Record<string, never>;
  /** Sets the status of a finding. */
  readonly finding_status: { readonly id: string; readonly status: FindingStatus };
  /** Sets the status, the note or the own group (its id; 0: none) of findings. */
  readonly finding_mark: {
    readonly version: string;
    readonly rows: readonly number[];
    readonly status?: FindingStatus;
    readonly note?: string;
    readonly group?: number;
  };
  /** Hides or shows findings that only touch. */
  readonly finding_filter: { readonly is_touching_hidden: boolean };
  /** Makes a group by hand, of rows of the findings of a version. */
  readonly finding_group_add: { readonly version: string; readonly rows: readonly number[]; readonly name: string };
  /** Renames a group that was made by hand. */
  readonly finding_group_rename: { readonly id: number; readonly name: string };
  /** Removes a group that was made by hand; its findings go back to where they were. */
  readonly finding_group_remove: { readonly id: number };
  /** Adds an exclusion to the rules, for pairs of parts by two patterns, and hides the findings that it names. */
  readonly finding_ignore: { readonly name: string; readonly a: string; readonly b: string };
  /** Adds a clearance that must hold: parts of pattern `a` at least `gap` metres away from those of `b`. */
  readonly requirement_add: { readonly name: string; readonly a: string; readonly b: string; readonly gap: number };
  /** Changes the requirement `id`; it has to be checked again. `gap`: metres. */
  readonly requirement_edit: {
    readonly id: number;
    readonly name?: string;
    readonly a?: string;
    readonly b?: string;
    readonly gap?: number;
  };
  /** Removes a requirement. */
  readonly requirement_remove: { readonly id: number };
  /** Takes the verdicts of the job "verify"; requirements that are gone are left out. */
  readonly requirements_checked: { readonly results: readonly RequirementResult[] };
  /** Sets how the next clash check is made. */
  readonly clash_settings: { readonly clearance?: number; readonly contact?: number | string; readonly rules?: string };
  /** Accepts the present revision of the mock-up: the project's answers are about its parts from now on. */
  readonly accept_revision: Record<string, never>;
  /** Asks about parts: do they come out, what has to go first, is a fastener reached, what room do they need. */
  readonly ask: {
    readonly question: CardQuestion;
    readonly parts?: Selection;
    readonly without?: Selection;
    readonly tool?: string;
    readonly tools?: readonly string[];
    readonly catalogue?: boolean;
    readonly grip?: string;
    readonly swing_deg?: number;
    readonly clearance?: number;
    readonly seconds?: number;
    readonly people?: number;
  };
  /** Asks the question of a card again, of the mock-up as it is now. */
  readonly card_again: { readonly id: number };
  /** Gives up a question that is not answered yet. */
  readonly card_cancel: { readonly id: number };
  /** Removes a card, with its answer, and the guide along its way. */
  readonly card_remove: { readonly id: number };
  /** Edits the task of a card, which is planned again. */
  readonly task_edit: {
    readonly id: number;
    readonly edit: TaskEditKind;
    readonly parts: Selection;
    readonly seconds?: number;
    readonly later?: Selection;
  };
  /** Takes a table of times (TOML, as of `feeler task --times`) for all tasks, which are planned again. */
  readonly task_times: { readonly toml: string; readonly name?: string };
  /** Takes a catalogue of tools (TOML, as of `feeler access --write-catalogue`) for tasks that choose from one. */
  readonly task_catalogue: { readonly toml: string; readonly name?: string };
  /** Takes parts out along the ways of a card, and adds them to the sequence. */
  readonly way_take: { readonly id?: number; readonly steps?: number; readonly ways?: readonly GivenWay[] };
  /** Asks whether the way of a line of the sequence holds: at every pose, and between them. */
  readonly way_check: { readonly id: number };
  /** Asks for a shorter way of a line of the sequence, of straight legs, with the same begin and end. */
  readonly way_shorten: { readonly id: number };
  /** Puts the shorter way of a card into the sequence: in place of the line's, or after it as another line. */
  readonly way_keep: {
    readonly id?: number;
    readonly is_added?: boolean;
    readonly line?: number;
    readonly ways?: readonly GivenWay[];
  };
  /** Lets a way guide the hand: step `step` of a card's ways, or the way of a line of the sequence. */
  readonly guide: { readonly card?: number; readonly step?: number; readonly line?: number };
  /** Ends the guidance of the hand. */
  readonly guide_end: Record<string, never>;
  /** Puts the tool at a pose at once, without a motion that contact could stop, as into a seat that was found. */
  readonly seat: { readonly pose: Pose };
  /**
   * Opens a mechanism: the text of a TOML file, and its name. Links of the one before go back to where they are
   * modelled. `is_start`: it was there from the start, and is no step of undo.
   */
  readonly mechanism_open: { readonly name: string; readonly text: string; readonly is_start?: boolean };
  /** Closes the mechanism: its links go back to where they are modelled. Lines of the sequence stay. */
  readonly mechanism_close: Record<string, never>;
  /** Moves a joint to a value, radians or metres, as far as contact lets it; joints that follow it follow. */
  readonly joint_move: { readonly name: string; readonly value: number };
  /** Takes the parts of a joint in the hand, on the joint: they move along it alone. The tool is put away. */
  readonly joint_take: { readonly name: string };
  /**
   * Keeps the position as lines of the sequence: one for each joint that stands elsewhere than after the lines
   * before. In the order in which they were moved.
   */
  readonly joint_step: Record<string, never>;
  /** Puts the joints where a line of the sequence leaves them, without a motion that contact could stop. */
  readonly joint_step_go: { readonly id: number };
  readonly undo: Record<string, never>;
  readonly redo: Record<string, never>;
}

/** The arguments of questions, and their answers. */
export interface Questions {
  /** The first visible hit of a ray; None if there is none. */
  readonly ray: { readonly args: { readonly origin: Vec3; readonly direction: Vec3 }; readonly answer: RayHit | null };
  /** As `ray`, with the snapped point; `within` in metres. */
  readonly snap: {
    readonly args: { readonly origin: Vec3; readonly direction: Vec3; readonly within?: number };
    readonly answer: Snapped | null;
  };
  /** The value of a measure; arguments as of `measure_add`. */
  readonly measure: {
    readonly args: {
      readonly type: MeasureType;
      readonly points?: readonly Vec3[];
      readonly parts?: Selection;
      readonly triangles?: readonly number[];
    };
    readonly answer: Measured;
  };
  /** Facts about a part. */
  readonly part: { readonly args: { readonly part: Selection }; readonly answer: PartFacts };
  /** The parts that a search finds, by words of paths and by attributes: see `Parts.search`. */
  readonly find: { readonly args: { readonly query: string }; readonly answer: FoundParts };
  /** The whole answer of a card. Its ways begin where the parts lay when it was asked, also once they were taken. */
  readonly card: { readonly args: { readonly id: number }; readonly answer: CardAnswer };
  /** The tool of a step of a task in its seat; None: the step has none. */
  readonly task_tool: {
    readonly args: { readonly id: number; readonly step: number };
    readonly answer: ToolGhost | null;
  };
  /** The tool of a row of access in its seat, with the hand if one fits; None: the row has none of the catalogue. */
  readonly reach_tool: {
    readonly args: { readonly id: number; readonly row: number };
    readonly answer: ToolGhost | null;
  };
  /** What is seen of the fastener of a step of a task before it is undone; None: the step has none. */
  readonly task_sight: {
    readonly args: { readonly id: number; readonly step: number };
    readonly answer: TaskSight | null;
  };
  /** The parts that a joint moves, at its worst position. */
  readonly joint_ghost: { readonly args: { readonly name: string }; readonly answer: JointGhost };
  /** Shows a joint at a value to all pages, as far as contact lets it, until the next change; null: as it stands. */
  readonly joint_to: {
    readonly args: { readonly name: string; readonly value: number | null };
    readonly answer: JointPlace;
  };
  /** The record over time. */
  readonly record: { readonly args: Record<string, never>; readonly answer: RecordTimeline };
  /** Patterns for the parts of a finding and their numbered siblings, and how many findings they hide. */
  readonly finding_alike: { readonly args: { readonly version: string; readonly row: number }; readonly answer: Alike };
  /** From where a finding is seen; null if none of its parts is here. */
  readonly finding_side: {
    readonly args: { readonly version: string; readonly row: number };
    readonly answer: FindingSide | null;
  };
  /** From where two parts are seen at a point between them. */
  readonly pair_side: {
    readonly args: { readonly parts: Selection; readonly point: Vec3 };
    readonly answer: FindingSide;
  };
  /** How many findings an exclusion with two patterns would hide. */
  readonly finding_hides: { readonly args: { readonly a: string; readonly b: string }; readonly answer: Hides };
}

/** The arguments of jobs, and their results. */
export interface Jobs {
  /** The exact outlines of the active sections and of the section box, or of one plane. */
  readonly outline: { readonly args: { readonly normal?: Vec3; readonly offset?: number }; readonly answer: Outline };
  readonly export_csv: { readonly args: Record<string, never>; readonly answer: Written };
  readonly export_html: { readonly args: Record<string, never>; readonly answer: Written };
  readonly export_glb: { readonly args: Record<string, never>; readonly answer: Written };
  /** A project of the document, to download. It names the mock-up by its content, and no folder of this machine. */
  readonly export_project: { readonly args: Record<string, never>; readonly answer: Written };
  /** One page of what was found and done, with its films inside. `pictures`: as of `feeler report`. */
  readonly report: { readonly args: { readonly pictures?: number }; readonly answer: Written };
  /** One HTML file with the mock-up inside, to download; see `page`. `camera`: the initial view. */
  readonly page: { readonly args: { readonly camera?: Camera }; readonly answer: WrittenPage };
  /** Replays the record that the workbench was opened with: exactly; or shows it from some seconds on. */
  readonly replay: { readonly args: { readonly start?: number; readonly speed?: number }; readonly answer: Replayed };
  /** Shows the record at some seconds of its replay. */
  readonly replay_to: { readonly args: { readonly at: number }; readonly answer: Replayed };
  /** The sequence as a film. */
  readonly film: { readonly args: Record<string, never>; readonly answer: SequenceFilm };
  /** Checks the scene as it is now: parts taken out and parts in the hand do not count, hidden ones do. */
  readonly clash: { readonly args: { readonly parts?: Selection }; readonly answer: Taken };
  /** Opens a file that a page sent: findings of `feeler clash --json` or --save. */
  readonly findings_file: { readonly args: { readonly files: number; readonly name: string }; readonly answer: Taken };
  /** Takes statuses and comments of a BCF file that a page sent: `count` findings have changed. */
  readonly findings_bcf: { readonly args: { readonly files: number; readonly name: string }; readonly answer: Taken };
  /** Checks the requirements in the scene as it is now, as "clash" does; for the command "requirements_checked". */
  readonly verify: { readonly args: Record<string, never>; readonly answer: readonly RequirementResult[] };
  /** Writes the requirements as TOML, for `feeler verify`. */
  readonly export_requirements: { readonly args: Record<string, never>; readonly answer: Written };
  /** Writes the findings with their statuses and notes, or the rules. */
  readonly export_findings: { readonly args: { readonly format: FindingFormat }; readonly answer: WrittenFindings };
}

/** What is sent of a command: its name and its arguments. */
export type CommandRequest = { [Name in keyof Commands]: Request<Name, Commands[Name]> }[keyof Commands];

type Request<Name, Args> =
  Record<string, never> extends Args ? readonly [name: Name, args?: Args] : readonly [name: Name, args: Args];

/** Where the arrays of a binary message are: type, shape (a text is a free length) and the most rows. */
export const ARRAYS = {
  file_piece: {
    data: ["u1", ["bytes"], MOST_PIECE_BYTES],
  },
  findings: {
    words: ["u1", ["bytes"], null],
    part_of_path: ["u4", ["paths"], null],
    pairs: ["u4", ["rows", 2], null],
    labels: ["u4", ["rows", 3], null],
    codes: ["u1", ["rows", 4], null],
    sizes: ["f4", ["rows", 4], null],
    places: ["f4", ["rows", 9], null],
  },
  pose: {
    pose: ["f8", [4, 4], null],
  },
  state: {
    pose: ["f8", [4, 4], null],
    wish: ["f8", [4, 4], null],
    hits: ["u4", ["hits"], MOST_HITS],
    tool_hits: ["u4", ["tool hits"], MOST_HITS],
    planes: ["f4", ["planes", 8], MOST_PLANES],
    plane_parts: ["u4", ["planes"], MOST_PLANES],
    clearance: ["f4", ["clearances", 7], MOST_CLEARANCES],
    clearance_parts: ["u4", ["clearances"], MOST_CLEARANCES],
  },
  page: {
    findings: ["u1", ["findings"], null],
    pieces: ["u1", ["n"], null],
  },
} as const;
