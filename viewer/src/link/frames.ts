// Encodes messages as frames of the socket and of saved pages, and decodes them. Text frames are JSON; a binary one is, little-endian:
//
//     u32 version | u32 header bytes | JSON header, padded with spaces to a multiple of 8 | arrays, each at a multiple of 8
//
// The header has the message's other fields, and "arrays": name -> [type, shape, offset from the end of the header].
// Messages are small except for the arrays, which are views of the frame: nothing is copied.

import { ARRAYS, type FromPage, type FromServer, PROTOCOL_VERSION } from "./protocol";

const TYPES = {
  f8: Float64Array,
  f4: Float32Array,
  u4: Uint32Array,
  u2: Uint16Array,
  u1: Uint8Array,
} as const;

type TypeName = keyof typeof TYPES;
type Numbers = Float64Array | Float32Array | Uint32Array | Uint16Array | Uint8Array;
type Spec = readonly [TypeName, readonly (number | string)[], number | null];
type Json = Record<string, unknown>;

const SPECS: Record<string, Record<string, Spec>> = ARRAYS;
const PREFIX_BYTES = 8;

/** A frame is not a message of this protocol. */
export class FrameError extends Error {
  override name = "FrameError";
}

/** The frame of a message from the page. */
export function encodeFrame(message: FromPage): string | ArrayBuffer {
  const specs = SPECS[message.kind];
  return specs === undefined ? JSON.stringify(message) : encodeBinary({ ...message }, specs);
}

function encodeBinary(message: Json, specs: Record<string, Spec>): ArrayBuffer {
  const header: Json = {};
  const places: Record<string, [TypeName, number[], number]> = {};
  const blocks: Numbers[] = [];
  let size = 0;
  for (const [name, value] of Object.entries(message)) {
    const spec = specs[name];
    if (spec === undefined) {
      header[name] = value;
      continue;
    }
    const block = value as Numbers;
    places[name] = [spec[0], shapeOf(block.length, spec[1], name), size];
    blocks.push(block);
    size += padded(block.byteLength);
  }
  const json = new TextEncoder().encode(JSON.stringify({ ...header, arrays: places }));
  const start = PREFIX_BYTES + padded(json.length);
  const bytes = new Uint8Array(start + size);
  const prefix = new DataView(bytes.buffer);
  prefix.setUint32(0, PROTOCOL_VERSION, true);
  prefix.setUint32(4, start - PREFIX_BYTES, true);
  bytes.fill(0x20, PREFIX_BYTES + json.length, start);
  bytes.set(json, PREFIX_BYTES);
  let offset = start;
  for (const block of blocks) {
    bytes.set(new Uint8Array(block.buffer, block.byteOffset, block.byteLength), offset);
    offset += padded(block.byteLength);
  }
  return bytes.buffer;
}

/** The message of a frame from the server; its arrays are views of the frame. Throws `FrameError`. */
export function decodeFrame(frame: string | ArrayBuffer): FromServer {
  const message = typeof frame === "string" ? jsonObject(frame) : decodeBinary(frame);
  if (typeof message.kind !== "string") {
    throw new FrameError("a message without a kind");
  }
  return message as unknown as FromServer;
}

/** The fields of a binary frame, as `ARRAYS` has its kind. Throws `FrameError`. */
export function decodeBinary(frame: ArrayBuffer): Json {
  if (frame.byteLength < PREFIX_BYTES) {
    throw new FrameError(`a frame of ${frame.byteLength} bytes is shorter than its prefix`);
  }
  const prefix = new DataView(frame);
  const version = prefix.getUint32(0, true);
  const start = PREFIX_BYTES + prefix.getUint32(4, true);
  if (version !== PROTOCOL_VERSION) {
    throw new FrameError(`a frame of version ${version}: ${PROTOCOL_VERSION} is spoken here`);
  }
  if (start % 8 !== 0 || start > frame.byteLength) {
    throw new FrameError(`a header of ${start - PREFIX_BYTES} bytes in a frame of ${frame.byteLength}`);
  }
  const text = new TextDecoder().decode(new Uint8Array(frame, PREFIX_BYTES, start - PREFIX_BYTES));
  const { arrays, ...message } = jsonObject(text);
  const specs = SPECS[String(message.kind)];
  if (specs === undefined || !isObject(arrays)) {
    throw new FrameError(`a binary frame of kind ${String(message.kind)}`);
  }
  const lengths = new Map<string, number>();
  for (const [name, spec] of Object.entries(specs)) {
    message[name] = view(frame, start, arrays[name], spec, name, lengths);
  }
  return message;
}

function view(
  frame: ArrayBuffer,
  start: number,
  place: unknown,
  spec: Spec,
  name: string,
  lengths: Map<string, number>,
): Numbers {
  const [type, shape, offset]: unknown[] = Array.isArray(place) ? place : [];
  if (type !== spec[0] || !Array.isArray(shape) || shape.length !== spec[1].length || typeof offset !== "number") {
    throw new FrameError(`${name} is not an array of ${spec[0]} with shape [${spec[1].join(", ")}]`);
  }
  let count = 1;
  spec[1].forEach((wanted, i) => {
    const length: unknown = shape[i];
    if (typeof wanted === "string" && typeof length === "number" && !lengths.has(wanted)) {
      lengths.set(wanted, length);
    }
    if (typeof length !== "number" || length !== (typeof wanted === "string" ? lengths.get(wanted) : wanted)) {
      throw new FrameError(`${name} has shape [${shape.join(", ")}]: [${spec[1].join(", ")}] is needed`);
    }
    count *= length;
  });
  const make = TYPES[spec[0]];
  const isWhole = Number.isInteger(count) && count >= 0 && Number.isInteger(offset) && offset >= 0 && offset % 8 === 0;
  if (!isWhole || start + offset + count * make.BYTES_PER_ELEMENT > frame.byteLength) {
    throw new FrameError(`${name} is out of bounds`);
  }
  return new make(frame, start + offset, count);
}

/** The shape of `count` numbers; at most one length is free. */
function shapeOf(count: number, wanted: readonly (number | string)[], name: string): number[] {
  const row = wanted.reduce<number>((product, each) => product * (typeof each === "number" ? each : 1), 1);
  const shape = wanted.map((each) => (typeof each === "number" ? each : count / row));
  if (shape.reduce((product, each) => product * each, 1) !== count || !shape.every(Number.isInteger)) {
    throw new FrameError(`${name} has ${count} numbers: [${wanted.join(", ")}] is needed`);
  }
  return shape;
}

function jsonObject(text: string): Json {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch (error) {
    throw new FrameError(`not JSON: ${String(error)}`);
  }
  if (!isObject(value)) {
    throw new FrameError("a JSON object is needed");
  }
  return value;
}

function isObject(value: unknown): value is Json {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function padded(bytes: number): number {
  return Math.ceil(bytes / 8) * 8;
}
