// Numbers in answers: little-endian, as base64.

export const floatsOf = (text: string): Float32Array => new Float32Array(bytesOf(text));

export const wholesOf = (text: string): Uint32Array => new Uint32Array(bytesOf(text));

export function bytesOf(text: string): ArrayBuffer {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}
