// Written by tools/protocol_ts.py from python/feeler/workbench (protocol.py, commands.py, asking.py): change it there.
// SI: metres, newtons, radians; poses are world_from_tool, row by row. `frames.ts` packs and unpacks what is binary.

/** Of the protocol: a page of another one is told to reload. */
export const PROTOCOL_VERSION = 1;

/** Closes a socket without the token, or past a limit. */
export const NOT_ALLOWED = 1008;

/** Closes a socket of another protocol version: the page is to be loaded anew. */
export const RELOAD = 4001;

/** Colliding triangles listed in a state, of each side. */
export const MOST_HITS = 20000;

/** Contact planes listed in a state. */
export const MOST_PLANES = 32;

/** Clearance rows listed in a state. */
export const MOST_CLEARANCES = 16;

export type Vec3 = [number, number, number];

/** 16 numbers of a rigid pose, row by row. */
export type Pose = readonly number[];

/** Parts: indices, paths or patterns. */
export type Selection = readonly (number | string)[] | number | string;

/** What a command answers. `id`: of what it added. `pose`: of the hand. */
export interface CommandAnswer {
  readonly id: number;
  readonly pose: Pose;
  readonly undo_depth: number;
  readonly redo_depth: number;
}

export type Unit = "mm" | "cm" | "m" | "in";

export type Mode = "stop" | "glide" | "pass";

export type UpAxis = "x" | "y" | "z";

export type MeasureType = "point" | "edge" | "angle" | "parts";

export type Material = "steel" | "aluminium" | "plastic" | "rubber";

export type FindingStatus = "new" | "active" | "reviewed" | "approved" | "resolved";

export type DepthKind = "exact" | "bound" | "estimate";

export type Source = "mouse" | "keys" | "gizmo" | "spacemouse" | "gamepad" | "xr" | "api";

/** What is known of the mock-up. */
export interface MockupFacts {
  readonly name: string;
  /** Of its content, hex: the address of its geometry. */
  readonly hash: string;
  /** Of the parts that are in the scene. */
  readonly triangles: number;
  /** All, also those that were left out: the number of every part is below it. */
  readonly parts: number;
}

/** What is known of the tool in hand. */
export interface ToolFacts {
  readonly name: string;
  readonly triangles: number;
}

/** A record that the job "replay" goes through. */
export interface RecordFacts {
  readonly name: string;
  readonly is_playing: boolean;
  /** Whether all of it came out as it was recorded; null before that is known. */
  readonly is_same: boolean | null;
  /** The same as a sentence. */
  readonly verdict: string | null;
}

/** How far reading and indexing are. */
export interface Loading {
  readonly stage: string;
  /** 0 to 1. */
  readonly share: number;
}

/** A plane that cuts the picture: what is kept has normal . x >= offset. */
export interface Section {
  readonly id: number;
  /** Unit. */
  readonly normal: Vec3;
  /** Metres along the normal. */
  readonly offset: number;
  readonly is_on: boolean;
}

/** One removal: parts, the way they took, and what came near. */
export interface SequenceLine {
  readonly id: number;
  readonly name: string;
  readonly parts: readonly number[];
  /** world_from_hand. */
  readonly way: readonly Pose[];
  /** Metres; 0 where something touched, null where it is not known. */
  readonly least_clearance: number | null;
  /** Part paths. */
  readonly touched: readonly string[];
  readonly tool: string | null;
}

/** A measure with the points that it was taken at. */
export interface Measure {
  readonly id: number;
  readonly name: string;
  readonly type: MeasureType;
  /** Metres. */
  readonly points: readonly Vec3[];
  readonly value: number;
  readonly unit: "m" | "rad";
  /** Taken by the engine on the triangles, not from the picture. */
  readonly is_exact: boolean;
}

/** Where a picture is seen from. */
export interface Camera {
  readonly position: Vec3;
  readonly target: Vec3;
  readonly up: Vec3;
  /** Vertical field of view. */
  readonly fov_rad: number;
}

/** A camera that was kept. */
export interface Viewpoint {
  readonly id: number;
  readonly name: string;
  readonly camera: Camera;
}

/** What a clash check says of two parts. */
export interface Finding {
  readonly id: string;
  /** A part path, as is `b`. */
  readonly a: string;
  readonly b: string;
  /** Null: the part is not in this mock-up, or was left out of the scene. */
  readonly part_a: number | null;
  readonly part_b: number | null;
  readonly verdict: string;
  /** Metres, as is `gap`. */
  readonly depth: number | null;
  readonly gap: number | null;
  readonly point_a: Vec3 | null;
  readonly point_b: Vec3 | null;
  readonly is_touching: boolean;
  readonly sentence: string;
}

/** Findings that belong together, the deepest first. */
export interface FindingGroup {
  readonly name: string;
  readonly findings: readonly Finding[];
}

/** What a clash run found, as groups, and how far each finding is. */
export interface Findings {
  readonly groups: readonly FindingGroup[];
  /** By the finding's id; "new" where there is none. */
  readonly status: Readonly<Record<string, FindingStatus>>;
  readonly is_touching_hidden: boolean;
}

/** All that a page shows and that a command may change; what a reload brings back. */
export interface Document {
  readonly mockup: MockupFacts | null;
  /** Null once the engine answers. */
  readonly loading: Loading | null;
  /** Why there is no mock-up. */
  readonly failed: string | null;
  readonly tool: ToolFacts | null;
  /** Names of what can be taken in hand. */
  readonly tools: readonly string[];
  readonly record: RecordFacts | null;
  /** Parts that were left out of the scene from the start: nothing meets them, and nobody sees them. */
  readonly absent: readonly number[];
  /** Of the mesh in hand: fetch `/held/VERSION` when it changes; 0: the hand is empty. */
  readonly held_version: number;
  readonly unit: Unit;
  readonly mode: Mode;
  readonly hidden: readonly number[];
  readonly ghost: readonly number[];
  /** 0 to 1. */
  readonly explode: number;
  readonly isolated: boolean;
  readonly sections: readonly Section[];
  /** Where the hand was last put down by a command. */
  readonly pose: Pose;
  readonly gripped: readonly number[];
  /** Part id -> world_from_part: the identity is where it was loaded. */
  readonly moved: Readonly<Record<string, Pose>>;
  /** Parts taken out of the mock-up. */
  readonly out: readonly number[];
  readonly sequence: readonly SequenceLine[];
  /** The line of the sequence that is being replayed. */
  readonly replaying: number | null;
  readonly measures: readonly Measure[];
  readonly viewpoints: readonly Viewpoint[];
  readonly findings: Findings | null;
  readonly material: Material | null;
}

/** The parts of a mock-up by column. */
export interface ManifestParts {
  /** Empty for those that were left out. */
  readonly paths: readonly string[];
  readonly triangles: readonly number[];
  /** Of each part's box, metres; an empty part, or one that was left out, has lower above upper. */
  readonly lower: readonly Vec3[];
  readonly upper: readonly Vec3[];
  /** 1: so small beside the mock-up that it may be left out while the camera moves. */
  readonly small: readonly number[];
  /** sRGB as 0xRRGGBB, -1 for a part without one; empty: the mock-up has no colours, and the page gives its own. */
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
  /** Of small parts alone. */
  readonly small: boolean;
  /** How many parts have triangles in it. */
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
  /** In the pieces: those that are drawn. */
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

/** How far the tool is from the mock-up, and between which points. */
export interface NearestPoints {
  readonly value: number;
  readonly tool_point: Vec3;
  readonly mockup_point: Vec3;
  readonly part: number;
}

/** The first thing in sight on a ray. */
export interface RayHit {
  readonly distance: number;
  readonly point: Vec3;
  readonly normal: Vec3;
  readonly part: number;
  /** Of the mock-up; -1: the fill of a section. */
  readonly triangle: number;
}

/** The same, with the point drawn to a corner or an edge that is near. */
export interface Snapped extends RayHit {
  readonly type: "vertex" | "edge" | "face";
  /** Of the triangle, where it is now. */
  readonly corners: [Vec3, Vec3, Vec3];
}

/** What a measure would come to. */
export interface Measured {
  readonly type: MeasureType;
  readonly points: readonly Vec3[];
  readonly value: number;
  readonly unit: "m" | "rad";
  readonly is_exact: boolean;
  readonly parts: readonly number[];
}

/** What is known of a part. */
export interface PartFacts {
  readonly part: number;
  readonly name: string;
  readonly path: string;
  readonly triangles: number;
  /** Null: the part has no triangle that can be queried. */
  readonly lower: Vec3 | null;
  readonly upper: Vec3 | null;
  readonly state: "gripped" | "moved" | "in place" | "left out";
  readonly is_hidden: boolean;
}

/** Where planes cut the mock-up. */
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

/** One HTML file with the mock-up inside. */
export interface WrittenPage extends Written {
  /** Triangles that had no room. */
  readonly left_out: number;
}

/** What came of a record that was gone through. */
export interface Replayed {
  readonly is_same: boolean;
  readonly verdict: string;
}

/** What went wrong, where, and what to do about it; "where" and "do" may be empty. */
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
  /** The one that the page was in before its connection broke. */
  readonly session: string | null;
  /** The newest that it has; 0: none. */
  readonly last_event: number;
}

/** Where the hand wants to be. The newest counts. */
export interface Wish {
  readonly kind: "pose";
  readonly seq: number;
  /** By the page's clock. */
  readonly time_ms: number;
  readonly source: Source;
  /** world_from_tool, row by row. */
  readonly pose: Float64Array;
}

/** A state was taken. At most two are on their way unacknowledged. */
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

/** Something that takes a while: progress comes by messages of the same id, the result as a reply. */
export interface Job {
  readonly kind: "job";
  readonly id: number;
  readonly name: string;
  readonly args: Readonly<Record<string, unknown>>;
}

/** Gives up a job of this page; its reply is an error then. */
export interface Cancel {
  readonly kind: "cancel";
  readonly id: number;
}

/** The picture that a "shot" event asked for, or the next piece of it: a message may have 1 MiB, a picture more. */
export interface Shot {
  readonly kind: "shot";
  readonly id: number;
  readonly name: string;
  /** Of a multiple of 4 characters in each piece but the last. */
  readonly png_base64: string;
  /** Another piece follows. */
  readonly more: boolean;
}

/** What a page measured, as a "benchmark" event asked for. */
export interface Benchmarked {
  readonly kind: "benchmarked";
  readonly id: number;
  /** As `Figures` of `viewer/src/app/benchmark.ts`. */
  readonly figures: Readonly<Record<string, unknown>>;
}

/** The answer to hello: everything. */
export interface Welcome {
  readonly kind: "welcome";
  readonly protocol: number;
  readonly session: string;
  readonly document: Document;
  /** The newest event that the document has in it; those that follow are greater. */
  readonly event: number;
  /** A haptic device moves the hand. */
  readonly device: boolean;
  readonly recording: boolean;
  /** Of the mesh in hand; null: the hand is empty, or there is no mock-up yet. */
  readonly held: HeldManifest | null;
  /** Of the server's software, by name. */
  readonly versions: Readonly<Record<string, string>>;
}

/** What the engine found at the newest pose. A newer one replaces it. */
export interface State {
  readonly kind: "state";
  readonly seq: number;
  /** Of the wish that it answers. */
  readonly pose_seq: number;
  readonly engine_us: number;
  /** From the wish to the answer. */
  readonly age_ms: number;
  /** Answers a second. */
  readonly rate_hz: number;
  readonly mode: Mode;
  /** Nothing meets, nothing is inside. */
  readonly is_free: boolean;
  /** The solid tool is held back from the wish. */
  readonly blocked: boolean;
  readonly force: Vec3;
  /** About the tool's origin, N m. */
  readonly torque: Vec3;
  /** How far the tool is out of what it is in; 0: in nothing, or not found yet. */
  readonly depth: number;
  /** Of the depth: no way out is shorter, one may be, or this one does not free it. */
  readonly depth_kind: DepthKind;
  /** Colliding triangles of the mock-up, listed or not. */
  readonly hit_count: number;
  /** Of them, those not listed. */
  readonly hit_more: number;
  /** Contact planes not listed. */
  readonly contact_more: number;
  readonly distance: NearestPoints | null;
  /** Touched, ids. */
  readonly parts: readonly number[];
  /** The solid tool's. */
  readonly pose: Float64Array;
  /** The hand's. */
  readonly wish: Float64Array;
  /** Packed triangles of the mock-up. */
  readonly hits: Uint32Array;
  /** Packed triangles of the mesh in hand. */
  readonly tool_hits: Uint32Array;
  /** A row a contact: point 3, normal 3 (from the mock-up to the tool), gap, share of the force in newtons. */
  readonly planes: Float32Array;
  readonly plane_parts: Uint32Array;
  /** A row a near part: distance, point on the tool 3, point on the mock-up 3. */
  readonly clearance: Float32Array;
  readonly clearance_parts: Uint32Array;
}

/** The document changed: the new values of some of its fields. */
export interface Patch {
  readonly kind: "event";
  readonly type: "patch";
  readonly n: number;
  readonly fields: Partial<Document>;
  /** What changed it; null: not a command. */
  readonly command: string | null;
  readonly undo_depth: number;
  readonly redo_depth: number;
}

/** The tool met a part that it did not touch before. */
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

/** Something to tell whoever looks at the page. */
export interface Notice {
  readonly kind: "event";
  readonly type: "notice";
  readonly n: number;
  readonly level: "info" | "warning" | "error";
  readonly text: string;
}

/** A script wants a picture: one page answers by a shot of the same id. */
export interface ShotWanted {
  readonly kind: "event";
  readonly type: "shot";
  readonly n: number;
  readonly id: number;
  readonly width: number;
  readonly height: number;
  /** Null: as the page stands. */
  readonly camera: Camera | null;
}

/** A page is to measure what it draws: it answers by a "benchmarked" message of the same id. */
export interface BenchmarkWanted {
  readonly kind: "event";
  readonly type: "benchmark";
  readonly n: number;
  readonly id: number;
}

/** The hand holds something else: fetch `/held/VERSION`. */
export interface HeldChanged {
  readonly kind: "event";
  readonly type: "held";
  readonly n: number;
  readonly version: number;
  /** Null: the hand is empty. */
  readonly manifest: HeldManifest | null;
}

/** How far a job of this page is. A newer one replaces it; it is no event, as it means nothing to other pages. */
export interface Progress {
  readonly kind: "progress";
  readonly id: number;
  /** 0 to 1. */
  readonly share: number;
  readonly stage: string;
}

/** A command, question or job was done. */
export interface Answer {
  readonly kind: "reply";
  readonly ok: true;
  readonly id: number;
  readonly result: unknown;
}

/** A command, question or job was not done; or a message was none. */
export interface Refusal {
  readonly kind: "reply";
  readonly ok: false;
  /** Null: the message had none. */
  readonly id: number | null;
  readonly error: Trouble;
}

export type FromPage = Hello | Wish | Ack | Command | Ask | Job | Cancel | Shot | Benchmarked;

export type ServerEvent = Patch | Impact | Notice | ShotWanted | BenchmarkWanted | HeldChanged;

export type FromServer = Welcome | State | ServerEvent | Progress | Answer | Refusal;

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
  /** Takes another tool, or none; where it would collide, it starts above the mock-up. */
  readonly take_tool: { readonly name: string | null };
  /** Adds a measure of points, parts or triangles. */
  readonly measure_add: {
    readonly type: MeasureType;
    readonly points?: readonly Vec3[];
    readonly parts?: Selection;
    readonly triangles?: readonly number[];
    readonly name?: string;
  };
  /** Renames a measure, or measures something else. */
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
  /** Saves a camera. */
  readonly viewpoint_add: { readonly name?: string; readonly camera: Camera };
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
  /** Sets the status of a finding. */
  readonly finding_status: { readonly id: string; readonly status: FindingStatus };
  /** Hides or shows findings that only touch. */
  readonly finding_filter: { readonly is_touching_hidden: boolean };
  readonly undo: Record<string, never>;
  readonly redo: Record<string, never>;
}

/** The arguments of questions, and their answers. */
export interface Questions {
  /** The first thing in sight on a ray; None: there is nothing. */
  readonly ray: { readonly args: { readonly origin: Vec3; readonly direction: Vec3 }; readonly answer: RayHit | null };
  /** As `ray`, with what the point snaps to; `within` in metres. */
  readonly snap: {
    readonly args: { readonly origin: Vec3; readonly direction: Vec3; readonly within?: number };
    readonly answer: Snapped | null;
  };
  /** What a measure would come to; arguments as of `measure_add`. */
  readonly measure: {
    readonly args: {
      readonly type: MeasureType;
      readonly points?: readonly Vec3[];
      readonly parts?: Selection;
      readonly triangles?: readonly number[];
    };
    readonly answer: Measured;
  };
  /** What is known of a part. */
  readonly part: { readonly args: { readonly part: Selection }; readonly answer: PartFacts };
}

/** The arguments of jobs, and what they come to. */
export interface Jobs {
  /** The exact outlines of the sections that are on, or of one plane. */
  readonly outline: { readonly args: { readonly normal?: Vec3; readonly offset?: number }; readonly answer: Outline };
  readonly export_csv: { readonly args: Record<string, never>; readonly answer: Written };
  readonly export_html: { readonly args: Record<string, never>; readonly answer: Written };
  readonly export_glb: { readonly args: Record<string, never>; readonly answer: Written };
  /** One HTML file with the mock-up inside, to download; see `page`. `camera`: from where it is seen at first. */
  readonly page: { readonly args: { readonly camera?: Camera }; readonly answer: WrittenPage };
  /** Goes through the record that the workbench was opened with. */
  readonly replay: { readonly args: Record<string, never>; readonly answer: Replayed };
}

/** What is sent of a command: its name and its arguments. */
export type CommandRequest = { [Name in keyof Commands]: Request<Name, Commands[Name]> }[keyof Commands];

type Request<Name, Args> =
  Record<string, never> extends Args ? readonly [name: Name, args?: Args] : readonly [name: Name, args: Args];

/** Where the arrays of a binary message are: type, shape (a text is a free length) and the most rows. */
export const ARRAYS = {
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
} as const;
