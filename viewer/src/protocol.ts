// Written by tools/protocol_ts.py from python/feeler/workbench/document/protocol.py: change it there.
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

export type Unit = "mm" | "cm" | "m" | "in";

export type Mode = "stop" | "glide" | "pass";

export type DepthKind = "exact" | "bound" | "estimate";

export type Source = "mouse" | "keys" | "gizmo" | "spacemouse" | "gamepad" | "xr" | "api";

/** What is known of the mock-up. */
export interface MockupFacts {
  name: string;
  /** Of its content, hex: the address of its geometry. */
  hash: string;
  /** Of the parts that are in the scene. */
  triangles: number;
  /** All, also those that were left out: the number of every part is below it. */
  parts: number;
}

/** What is known of the tool in hand. */
export interface ToolFacts {
  name: string;
  triangles: number;
}

/** A record that the job "replay" goes through. */
export interface RecordFacts {
  name: string;
  is_playing: boolean;
  /** Whether all of it came out as it was recorded; null before that is known. */
  is_same: boolean | null;
  /** The same as a sentence. */
  verdict: string | null;
}

/** How far reading and indexing are. */
export interface Loading {
  stage: string;
  /** 0 to 1. */
  share: number;
}

/** A plane that cuts the picture: what is kept has normal . x >= offset. */
export interface Section {
  id: number;
  /** Unit, 3 numbers. */
  normal: number[];
  /** Metres along the normal. */
  offset: number;
  is_on: boolean;
}

/** One removal: parts, the way they took, and what came near. */
export interface SequenceLine {
  id: number;
  name: string;
  parts: number[];
  /** Poses of 16 numbers, world_from_hand. */
  way: number[][];
  /** Metres; 0 where something touched, null where it is not known. */
  least_clearance: number | null;
  /** Part paths. */
  touched: string[];
  tool: string | null;
}

/** A measure with the points that it was taken at. */
export interface Measure {
  id: number;
  name: string;
  type: "point" | "edge" | "angle" | "parts";
  /** 3 numbers each, metres. */
  points: number[][];
  value: number;
  unit: "m" | "rad";
  /** Taken by the engine on the triangles, not from the picture. */
  is_exact: boolean;
}

/** Where a picture is seen from. */
export interface Camera {
  position: number[];
  target: number[];
  up: number[];
  /** Vertical field of view. */
  fov_rad: number;
}

/** A camera that was kept. */
export interface Viewpoint {
  id: number;
  name: string;
  camera: Camera;
}

/** What a clash run found, as groups, and how far each group is. */
export interface Findings {
  groups: Record<string, unknown>[];
  status: Record<string, string>;
  is_touching_hidden: boolean;
}

/** All that a page shows and that a command may change; what a reload brings back. */
export interface DocumentFields {
  mockup: MockupFacts | null;
  /** Null once the engine answers. */
  loading: Loading | null;
  /** Why there is no mock-up. */
  failed: string | null;
  tool: ToolFacts | null;
  /** Names of what can be taken in hand. */
  tools: string[];
  record: RecordFacts | null;
  /** Parts that were left out of the scene from the start: nothing meets them, and nobody sees them. */
  absent: number[];
  /** Of the mesh in hand: fetch `/held/VERSION` when it changes; 0: the hand is empty. */
  held_version: number;
  unit: Unit;
  mode: Mode;
  hidden: number[];
  ghost: number[];
  /** 0 to 1. */
  explode: number;
  isolated: boolean;
  sections: Section[];
  /** 16 numbers: where the hand was last put down by a command. */
  pose: number[];
  gripped: number[];
  /** Part id -> 16 numbers, world_from_part: the identity is where it was loaded. */
  moved: Record<string, number[]>;
  /** Parts taken out of the mock-up. */
  out: number[];
  sequence: SequenceLine[];
  /** The line of the sequence that is being replayed. */
  replaying: number | null;
  measures: Measure[];
  viewpoints: Viewpoint[];
  findings: Findings | null;
  material: string | null;
}

/** The parts of a mock-up by column. */
export interface ManifestParts {
  /** Empty for those that were left out. */
  paths: string[];
  triangles: number[];
  /** Of each part's box, metres; an empty part, or one that was left out, has lower above upper. */
  lower: Vec3[];
  upper: Vec3[];
  /** 1: so small beside the mock-up that it may be left out while the camera moves. */
  small: number[];
  /** sRGB as 0xRRGGBB, -1 for a part without one; empty: the mock-up has no colours, and the page gives its own. */
  colours: number[];
}

/** One piece of geometry, `GET /scene/pieces/K`. */
export interface ManifestPiece {
  triangles: number;
  vertices: number;
  /** Packed index of its first triangle: the number of triangles in the pieces before it. */
  first: number;
  bytes: number;
  lower: Vec3;
  upper: Vec3;
  /** Of small parts alone. */
  small: boolean;
  /** How many parts have triangles in it. */
  parts: number;
}

/**
 * The geometry of the mock-up, `GET /scene`: pieces, big shapes first, small parts at the end.
 *
 * A piece is little-endian: float32 positions[vertices][3], metres from `middle`; the part of each vertex, uint16 or
 * uint32 as `part_bytes` says, padded to 4 bytes; uint16 index[triangles][3], padded to 4 bytes. A packed triangle is
 * the index of a triangle in the order of the pieces.
 */
export interface Manifest {
  hash: string;
  name: string;
  /** Of the files that it was read from. */
  unit: string;
  up: string;
  middle: Vec3;
  lower: Vec3;
  upper: Vec3;
  /** In the pieces: those that are drawn. */
  triangles: number;
  vertices: number;
  part_bytes: number;
  parts: ManifestParts;
  pieces: ManifestPiece[];
}

/** The geometry in hand, in the hand's frame: its pieces, one after the other, are `GET /held/VERSION`. */
export interface HeldManifest {
  version: number;
  middle: Vec3;
  lower: Vec3;
  upper: Vec3;
  triangles: number;
  vertices: number;
  part_bytes: number;
  /** Paths; the part of a vertex is an index into them. */
  parts: string[];
  pieces: ManifestPiece[];
}

/** How far the tool is from the mock-up, and between which points. */
export interface NearestPoints {
  value: number;
  tool_point: Vec3;
  mockup_point: Vec3;
  part: number;
}

/** What went wrong, where, and what to do about it; "where" and "do" may be empty. */
export interface Trouble {
  what: string;
  where: string;
  do: string;
}

/** The first message, within 2 seconds; nothing else is read before it. */
export interface Hello {
  kind: "hello";
  protocol: number;
  token: string;
  /** The one that the page was in before its connection broke. */
  session: string | null;
  /** The newest that it has; 0: none. */
  last_event: number;
}

/** Where the hand wants to be. The newest counts. */
export interface Pose {
  kind: "pose";
  seq: number;
  /** By the page's clock. */
  time_ms: number;
  source: Source;
  /** world_from_tool, row by row. */
  pose: Float64Array;
}

/** A state was taken. At most two are on their way unacknowledged. */
export interface Ack {
  kind: "ack";
  seq: number;
}

/** Changes the document. Answered by a reply. */
export interface Command {
  kind: "command";
  id: number;
  name: string;
  args: Record<string, unknown>;
}

/** A question, which changes nothing. Answered by a reply. */
export interface Ask {
  kind: "ask";
  id: number;
  name: string;
  args: Record<string, unknown>;
}

/** Something that takes a while: progress comes by messages of the same id, the result as a reply. */
export interface Job {
  kind: "job";
  id: number;
  name: string;
  args: Record<string, unknown>;
}

/** Gives up a job of this page; its reply is an error then. */
export interface Cancel {
  kind: "cancel";
  id: number;
}

/** The picture that a "shot" event asked for, or the next piece of it: a message may have 1 MiB, a picture more. */
export interface Shot {
  kind: "shot";
  id: number;
  name: string;
  /** Of a multiple of 4 characters in each piece but the last. */
  png_base64: string;
  /** Another piece follows. */
  more: boolean;
}

/** What a page measured, as a "benchmark" event asked for. */
export interface Benchmarked {
  kind: "benchmarked";
  id: number;
  /** As `Figures` of `viewer/src/benchmark.ts`. */
  figures: Record<string, unknown>;
}

/** The answer to hello: everything. */
export interface Welcome {
  kind: "welcome";
  protocol: number;
  session: string;
  document: DocumentFields;
  /** The newest event that the document has in it; those that follow are greater. */
  event: number;
  /** A haptic device moves the hand. */
  device: boolean;
  recording: boolean;
  /** Of the mesh in hand; null: the hand is empty, or there is no mock-up yet. */
  held: HeldManifest | null;
  /** Of the server's software, by name. */
  versions: Record<string, string>;
}

/** What the engine found at the newest pose. A newer one replaces it. */
export interface State {
  kind: "state";
  seq: number;
  /** Of the wish that it answers. */
  pose_seq: number;
  engine_us: number;
  /** From the wish to the answer. */
  age_ms: number;
  /** Answers a second. */
  rate_hz: number;
  mode: Mode;
  /** Nothing meets, nothing is inside. */
  is_free: boolean;
  /** The solid tool is held back from the wish. */
  blocked: boolean;
  force: Vec3;
  /** About the tool's origin, N m. */
  torque: Vec3;
  /** How far the tool is out of what it is in; 0: in nothing, or not found yet. */
  depth: number;
  /** Of the depth: no way out is shorter, one may be, or this one does not free it. */
  depth_kind: DepthKind;
  /** Colliding triangles of the mock-up, listed or not. */
  hit_count: number;
  /** Of them, those not listed. */
  hit_more: number;
  /** Contact planes not listed. */
  contact_more: number;
  distance: NearestPoints | null;
  /** Touched, ids. */
  parts: number[];
  /** The solid tool's. */
  pose: Float64Array;
  /** The hand's. */
  wish: Float64Array;
  /** Packed triangles of the mock-up. */
  hits: Uint32Array;
  /** Packed triangles of the mesh in hand. */
  tool_hits: Uint32Array;
  /** A row a contact: point 3, normal 3 (from the mock-up to the tool), gap, share of the force in newtons. */
  planes: Float32Array;
  plane_parts: Uint32Array;
  /** A row a near part: distance, point on the tool 3, point on the mock-up 3. */
  clearance: Float32Array;
  clearance_parts: Uint32Array;
}

/** The document changed: the new values of some of its fields. */
export interface Patch {
  kind: "event";
  type: "patch";
  n: number;
  fields: Partial<DocumentFields>;
  /** What changed it; null: not a command. */
  command: string | null;
  undo_depth: number;
  redo_depth: number;
}

/** The tool met a part that it did not touch before. */
export interface Impact {
  kind: "event";
  type: "impact";
  n: number;
  part: number;
  /** The diagonal of its box. */
  part_size_m: number;
  speed_m_per_s: number;
  point: Vec3;
  material: string | null;
  /** Newtons. */
  force: number;
}

/** Something to tell whoever looks at the page. */
export interface Notice {
  kind: "event";
  type: "notice";
  n: number;
  level: "info" | "warning" | "error";
  text: string;
}

/** A script wants a picture: one page answers by a shot of the same id. */
export interface ShotWanted {
  kind: "event";
  type: "shot";
  n: number;
  id: number;
  width: number;
  height: number;
  /** Null: as the page stands. */
  camera: Camera | null;
}

/** A page is to measure what it draws: it answers by a "benchmarked" message of the same id. */
export interface BenchmarkWanted {
  kind: "event";
  type: "benchmark";
  n: number;
  id: number;
}

/** The hand holds something else: fetch `/held/VERSION`. */
export interface HeldChanged {
  kind: "event";
  type: "held";
  n: number;
  version: number;
  /** Null: the hand is empty. */
  manifest: HeldManifest | null;
}

/** How far a job of this page is. A newer one replaces it; it is no event, as it means nothing to other pages. */
export interface Progress {
  kind: "progress";
  id: number;
  /** 0 to 1. */
  share: number;
  stage: string;
}

/** A command, question or job was done. */
export interface Answer {
  kind: "reply";
  ok: true;
  id: number;
  result: unknown;
}

/** A command, question or job was not done; or a message was none. */
export interface Refusal {
  kind: "reply";
  ok: false;
  /** Null: the message had none. */
  id: number | null;
  error: Trouble;
}

export type FromPage = Hello | Pose | Ack | Command | Ask | Job | Cancel | Shot | Benchmarked;

export type ServerEvent = Patch | Impact | Notice | ShotWanted | BenchmarkWanted | HeldChanged;

export type FromServer = Welcome | State | ServerEvent | Progress | Answer | Refusal;

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
