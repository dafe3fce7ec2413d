/** What every mesh reader hands back: polygons as the file has them, not yet checked: `paint3d/files/raw_mesh.py`. */

import { MeshError, noted, type Note } from "./mesh_error";

export interface RawMesh {
  vertices: Float64Array; // (V, 3) in the file's unit and axes
  corners: Float64Array; // vertices of all polygons, one after the other
  sizes: Int32Array; // corners of each
  colours: Uint8Array | null; // (V, 3) sRGB codes
  normals: Float64Array | null; // (V, 3)
  unitMm: number | null; // where the format says so
  up: "y" | "z" | null;
  announces: Note | null; // what it speaks of besides points
  notes: Note[]; // what the user should know
}

export const FACE_COLOURS = noted("colours of faces");

export function rawMesh(given: Partial<RawMesh> & Pick<RawMesh, "vertices" | "corners" | "sizes">): RawMesh {
  return { colours: null, normals: null, unitMm: null, up: null, announces: null, notes: [], ...given };
}

/** So many triangles' sizes. */
export function threes(n: number): Int32Array {
  return new Int32Array(n).fill(3);
}

/** One note on what a file says and is not taken; none where there is none. */
export function leftOut(what: Iterable<Note>): Note[] {
  const byText = new Map([...what].map((one) => [JSON.stringify(one), one]));
  const named = [...byText.values()].sort((a, b) => (a.text < b.text ? -1 : 1));
  if (named.length === 0) return [];
  const several = named.reduce((one, other) => noted("{one}, {other}", { one, other }));
  return [noted("left out: {what}", { what: several })];
}

const SPACE = /[ \t\n\r\f\v]+/;

/** The words of a text, which no white space is in. */
export function wordsOf(text: string): string[] {
  const words = text.split(SPACE);
  if (words.length > 0 && words[0] === "") words.shift();
  if (words.length > 0 && words[words.length - 1] === "") words.pop();
  return words;
}

/** All numbers of a text. */
export function parseNumbers(text: string, what: Note): Float64Array {
  const words = wordsOf(text);
  const numbers = new Float64Array(words.length);
  for (let k = 0; k < words.length; k++) {
    const word = words[k];
    const number = Number(word);
    if (number !== number || (word.length > 1 && /[xob]/i.test(word))) {
      const known = /^[+-]?(inf(inity)?|nan)$/i.exec(word);
      if (known === null)
        throw new MeshError("{what} has {shown!r} where a number was expected", { what, shown: word.slice(0, 20) });
      numbers[k] = known[1].toLowerCase() === "nan" ? NaN : word.startsWith("-") ? -Infinity : Infinity;
    } else numbers[k] = number;
  }
  return numbers;
}

/** Numbers read as text as indices. */
export function indexArray(numbers: ArrayLike<number>, what: Note): Float64Array {
  for (let k = 0; k < numbers.length; k++)
    if (!Number.isSafeInteger(numbers[k]))
      throw new MeshError("{what} has {numbers:g} where a vertex index was expected", { what, numbers: numbers[k] });
  return Float64Array.from(numbers);
}

/** Refuse a count that the rest of the file cannot hold, before memory is taken for it. */
export function checkCount(count: number, bytesEach: number, bytes: number, what: Note): void {
  const room = Math.floor(bytes / bytesEach);
  if (count < 0) throw new MeshError("it says it has {count} {what}; expected 0 or more", { count, what });
  if (count > room)
    throw new MeshError(
      "it says it has {count:,} {what}, but what follows has room for {room:,} at most; the file is cut short or its " +
        "header is wrong",
      { count, what, room },
    );
}

/** Bytes as text, one character a byte. */
export function latin(data: Uint8Array): string {
  let text = "";
  for (let k = 0; k < data.length; k += 32768) text += String.fromCharCode(...data.subarray(k, k + 32768));
  return text;
}

/** Text as one character per ASCII character, with lines that end in "\n"; UTF-16 is told by its mark or its zeros. */
export function plainText(data: Uint8Array): string {
  const encoding = wideOf(data);
  const from = encoding === null && data[0] === 0xef && data[1] === 0xbb && data[2] === 0xbf ? 3 : 0;
  const text = encoding === null ? latin(data.subarray(from)) : new TextDecoder(encoding).decode(data);
  return text.replace(/\r\n?/g, "\n");
}

function wideOf(data: Uint8Array): string | null {
  if (data[0] === 0xff && data[1] === 0xfe) return "utf-16le";
  if (data[0] === 0xfe && data[1] === 0xff) return "utf-16be";
  const start = data.subarray(0, 64);
  const zeros = [0, 1].map((side) => start.filter((_, k) => k % 2 === side));
  if (start.length < 8) return null;
  if (zeros[1].every((x) => x === 0) && zeros[0].every((x) => x !== 0)) return "utf-16le";
  if (zeros[0].every((x) => x === 0) && zeros[1].every((x) => x !== 0)) return "utf-16be";
  return null;
}

/** Bytes of UTF-16 with its mark as those of UTF-8; others as they are. */
export function narrowed(data: Uint8Array): Uint8Array {
  const isWide = (data[0] === 0xff && data[1] === 0xfe) || (data[0] === 0xfe && data[1] === 0xff);
  return isWide ? new TextEncoder().encode(plainText(data)) : data;
}
