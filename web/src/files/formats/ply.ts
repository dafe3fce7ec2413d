/** PLY: polygons of any sizes, triangle strips, colours and normals of vertices: `paint3d/files/formats/ply.py`. */

import type { Kind } from "../../core/arrays";
import { colourCodes } from "../colours";
import { MeshError, noted, type Note } from "../mesh_error";
import { checkCount, FACE_COLOURS, indexArray, latin, leftOut, parseNumbers, rawMesh, wordsOf, type RawMesh } from "../raw_mesh";

const TYPES = new Map<string, Kind>(Object.entries({
  char: "i1", int8: "i1", uchar: "u1", uint8: "u1", short: "i2", int16: "i2", ushort: "u2", uint16: "u2",
  int: "i4", int32: "i4", uint: "u4", uint32: "u4", float: "f4", float32: "f4", double: "f8", float64: "f8",
})); // prettier-ignore
const FORMATS = new Map<string, "ascii" | "little" | "big">([
  ["ascii", "ascii"], ["binary_little_endian", "little"], ["binary_big_endian", "big"],
]); // prettier-ignore
const KEYWORDS = ["format", "element", "property", "comment", "obj_info"];
const MOST_HEADER = 1 << 20;
const WANTED = ["vertex", "face", "tristrips"];
const INDEX_NAMES = ["vertex_indices", "vertex_index"];
const COLOUR_NAMES = [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];
const LISTS_OF_COLOURS = ["rgb", "rgba", "color", "colors", "colour", "colours"];
const NAMED_AS_COLOUR = /(?:^|_)(?:red|green|blue|rgba?|bgra?|colou?rs?|f_dc)(?:_|\d|$)/i;
const SPLATS = ["f_dc_0", "f_dc_1", "f_dc_2"]; // of Gaussian splatting: spherical harmonics of degree 0
const SH_0 = 0.28209479177387814; // 1 / (2 sqrt(pi))
const STRIP_END = -1;
const LONGEST = 4_294_967_295;

interface Property {
  name: string;
  kind: Kind;
  count: Kind | null; // of a list
}

interface Column {
  kind: Kind;
  values: Float64Array;
  sizes: Int32Array | null; // of a list
}

interface Element {
  name: string;
  count: number;
  properties: Property[];
  columns: Map<string, Column>;
}

const bytesOf = (kind: Kind): number => Number(kind[1]);

export function readPly(data: Uint8Array): RawMesh {
  const { order, elements, comments, unknown, body } = readHeader(data);
  const last = elements.reduce((k, element, place) => (WANTED.includes(element.name) ? place : k), -1);
  const wanted = elements.slice(0, last + 1);
  if (order === "ascii") readText(wanted, latin(data.subarray(body)));
  else readBinary(wanted, data, body, order === "little");

  const vertex = elements.find((element) => element.name === "vertex");
  const places = vertex === undefined ? null : columnsOf(vertex, ["x", "y", "z"]);
  if (vertex === undefined || places === null)
    throw new MeshError("no vertex positions; expected an element vertex with x, y and z");
  const { corners, sizes } = polygons(elements);
  const { colours, notes } = coloursOf(vertex);
  for (const line of unknown) notes.push(noted("its header's line {line!r} is passed over", { line: line.slice(0, 60) }));
  const dropped: Note[] = [];
  if (elements.some((element) => element.name === "edge" && element.count > 0)) dropped.push(noted("lines"));
  if (comments.some((comment) => comment.split(" ", 1)[0] === "TextureFile")) dropped.push(noted("its pictures"));
  if (elements.some((element) => element.name === "face" && colourNames(element).length > 0)) dropped.push(FACE_COLOURS);
  for (const element of elements) {
    const names = element.count === 0 ? [] : element.properties.map(({ name }) => name)
      .filter((name) => NAMED_AS_COLOUR.test(name) && !colourNames(element).includes(name)); // prettier-ignore
    if (names.length > 0) dropped.push(noted("what it calls {names}", { names: names.join(", ").slice(0, 60) }));
  }
  return rawMesh({
    vertices: places, corners, sizes, colours,
    normals: columnsOf(vertex, ["nx", "ny", "nz"]),
    announces: announced(elements),
    notes: [...notes, ...leftOut(dropped)],
  }); // prettier-ignore
}

/** Columns of numbers side by side; null where one is missing. */
function columnsOf(element: Element, names: string[]): Float64Array | null {
  const columns = names.map((name) => element.columns.get(name));
  if (columns.some((column) => column === undefined)) return null;
  const all = new Float64Array(names.length * element.count);
  columns.forEach((column, c) => column?.values.forEach((x, k) => (all[names.length * k + c] = x)));
  return all;
}

function readHeader(data: Uint8Array): {
  order: "ascii" | "little" | "big"; elements: Element[]; comments: string[]; unknown: string[]; body: number;
} {
  const start = latin(data.subarray(0, MOST_HEADER));
  if (!start.startsWith("ply")) throw new MeshError("it does not start with 'ply'; expected a PLY file");
  const end = start.indexOf("end_header");
  if (end < 0) throw new MeshError("the header has no end; expected a line end_header");
  const loneReturn = start[3] === "\r" && start[4] !== "\n";
  let body = end + "end_header".length;
  while (start[body] === " " || start[body] === "\t") body++;
  body += start.slice(body, body + 2) === "\r\n" && !loneReturn ? 2 : 1;
  let order: "ascii" | "little" | "big" | undefined;
  const elements: Element[] = [];
  const [comments, unknown]: [string[], string[]] = [[], []];
  for (const line of start.slice(0, end).split(/\r\n|\r|\n/).slice(1)) {
    const words = wordsOf(line);
    const odd = (cause = words.join(" ").slice(0, 60)): never => {
      throw new MeshError("the header cannot be understood near {cause}", { cause });
    };
    const known = <T>(all: Map<string, T>, word?: string): T =>
      all.get(word ?? "") ?? odd(word === undefined ? undefined : `'${word.slice(0, 60)}'`);
    if (words.length === 0 || words[0] === "obj_info") continue;
    if (words[0] === "comment") comments.push(line.trim().slice("comment".length).trim());
    else if (words[0] === "format") order = known(FORMATS, words[1]);
    else if (words[0] === "element") {
      const count = /^[+-]?\d+$/.test(words[2] ?? "") ? Number(words[2]) : odd();
      elements.push({ name: words[1], count, properties: [], columns: new Map() });
    } else if (words[0] === "property" && elements.length > 0) {
      const isList = words[1] === "list";
      const [kind, count] = isList ? [known(TYPES, words[3]), known(TYPES, words[2])] : [known(TYPES, words[1]), null];
      const name = isList ? words[4] : words[2];
      if (name === undefined) return odd();
      elements[elements.length - 1].properties.push({ name, kind, count });
    } else if (elements.length > 0 || KEYWORDS.some((keyword) => isNearly(words[0].toLowerCase(), keyword)))
      throw new MeshError("the header has an unknown line {words!r}", { words: words.join(" ").slice(0, 40) });
    else unknown.push(words.join(" "));
  }
  if (order === undefined) throw new MeshError("the header has no format line");
  return { order, elements, comments, unknown, body };
}

/** Whether a word is a keyword with a letter more, less or changed. */
function isNearly(word: string, keyword: string): boolean {
  if (Math.abs(word.length - keyword.length) > 1) return false;
  let [start, end] = [0, 0];
  const least = Math.min(word.length, keyword.length);
  while (start < least && word[start] === keyword[start]) start++;
  while (end < least - start && word.at(-1 - end) === keyword.at(-1 - end)) end++;
  return Math.max(word.length, keyword.length) - start - end <= 1;
}

function readBinary(elements: Element[], data: Uint8Array, at: number, isLittle: boolean): void {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const read = (kind: Kind, place: number): number => {
    switch (kind) {
      case "i1": return view.getInt8(place);
      case "u1": return view.getUint8(place);
      case "i2": return view.getInt16(place, isLittle);
      case "u2": return view.getUint16(place, isLittle);
      case "i4": return view.getInt32(place, isLittle);
      case "u4": return view.getUint32(place, isLittle);
      case "f4": return view.getFloat32(place, isLittle);
      default: return view.getFloat64(place, isLittle);
    }
  }; // prettier-ignore
  for (const element of elements) {
    if (element.properties.length === 0) continue;
    const least = element.properties.reduce((sum, { kind, count }) => sum + bytesOf(count ?? kind), 0);
    checkCount(element.count, least, data.length - at, noted("rows of {name}", { name: element.name }));
    const short = (): never => {
      throw new MeshError("it ends within the {element} rows; the file is cut short", { element: element.name });
    };
    const columns = element.properties.map(({ count }) => ({
      values: count === null ? new Float64Array(element.count) : ([] as number[]),
      sizes: count === null ? null : new Int32Array(element.count),
    }));
    for (let row = 0; row < element.count; row++)
      for (const [k, { name, kind, count }] of element.properties.entries()) {
        const { values, sizes } = columns[k];
        const width = bytesOf(kind);
        if (count === null || sizes === null) {
          if (at + width > data.length) short();
          (values as Float64Array)[row] = read(kind, at);
          at += width;
          continue;
        }
        if (at + bytesOf(count) > data.length) short();
        const n = Math.trunc(read(count, at));
        at += bytesOf(count);
        checkCount(n, width, data.length - at, noted("entries in a {name} list", { name }));
        sizes[row] = n;
        for (let i = 0; i < n; i++, at += width) (values as number[]).push(read(kind, at));
      }
    element.properties.forEach(({ name, kind }, k) => {
      const { values, sizes } = columns[k];
      element.columns.set(name, { kind, values: Float64Array.from(values), sizes });
    });
  }
}

function readText(elements: Element[], text: string): void {
  for (const { count, properties, name } of elements)
    checkCount(count, 2 * Math.max(1, properties.length), text.length + 1, noted("rows of {name}", { name }));
  const numbers = parseNumbers(text, noted("the body"));
  let at = 0;
  for (const element of elements) {
    const columns = element.properties.map(({ count }) => ({ values: [] as number[], sizes: count === null ? null : ([] as number[]) }));
    const short = (): never => {
      throw new MeshError("it ends within the {element} rows; the file is cut short", { element: element.name });
    };
    for (let row = 0; row < element.count; row++)
      for (const { values, sizes } of columns) {
        let n = 1;
        if (sizes !== null) {
          if (!(numbers[at] >= 0 && numbers[at] <= numbers.length - at)) short();
          n = Math.trunc(numbers[at++]);
          sizes.push(n);
        }
        if (at + n > numbers.length) short();
        for (let i = 0; i < n; i++) values.push(numbers[at++]);
      }
    element.properties.forEach(({ name, kind }, k) => {
      const { values, sizes } = columns[k];
      const own = Float64Array.from(values);
      element.columns.set(name, { kind: fitting(own, kind), values: own, sizes: sizes === null ? null : Int32Array.from(sizes) });
    });
  }
}

/** The declared type where text's numbers fit in it; only colours need to know it. */
function fitting(values: Float64Array, kind: Kind): Kind {
  if (kind[0] === "f" || values.length === 0) return kind[0] === "f" ? "f8" : kind;
  const bits = 8 * bytesOf(kind);
  const [low, high] = kind[0] === "u" ? [0, 2 ** bits - 1] : [-(2 ** (bits - 1)), 2 ** (bits - 1) - 1];
  return values.every((x) => x >= low && x <= high && x === Math.floor(x)) ? kind : "f8";
}

function announced(elements: Element[]): Note | null {
  const others = elements.filter(({ name, count }) => name !== "vertex" && (count > 0 || WANTED.includes(name)));
  if (others.some(({ name }) => WANTED.includes(name))) return noted("faces");
  return others.length > 0 ? noted("{name!r}, which is not read", { name: others[0].name.slice(0, 40) }) : null;
}

/** The corners of all polygons, then of the triangles of all strips, and their sizes. */
function polygons(elements: Element[]): { corners: Float64Array; sizes: Int32Array } {
  const [corners, sizes]: [Float64Array[], Int32Array[]] = [[], []];
  for (const [kind, what] of [["face", noted("a face")], ["tristrips", noted("a strip")]] as const)
    for (const element of elements.filter(({ name }) => name === kind)) {
      const list = INDEX_NAMES.map((name) => element.columns.get(name)).find((column) => column?.sizes);
      if (list?.sizes == null) continue;
      const ids = indexArray(list.values, what);
      if (kind === "face") {
        corners.push(ids);
        sizes.push(list.sizes);
      } else {
        const faces = Float64Array.from(strips(ids, list.sizes));
        corners.push(faces);
        sizes.push(new Int32Array(faces.length / 3).fill(3));
      }
    }
  const all = new Float64Array(corners.reduce((n, part) => n + part.length, 0));
  let at = 0;
  for (const part of corners) {
    all.set(part, at);
    at += part.length;
  }
  return { corners: all, sizes: Int32Array.from(sizes.flatMap((part) => [...part])) };
}

/** The corners of the triangles of strips; every second one is turned round, those that name a vertex twice go. */
function strips(ids: Float64Array, sizes: Int32Array): number[] {
  const faces: number[] = [];
  let at = 0;
  for (const size of sizes) {
    let start = at;
    const end = at + size;
    const isEnd = (k: number): boolean => ids[k] === STRIP_END || ids[k] === LONGEST;
    for (let k = at; k < end; k++) {
      if (isEnd(k)) start = k + 1;
      if (k < start + 2) continue;
      const [a, b, c] = [ids[k - 2], ids[k - 1], ids[k]];
      if (a === b || b === c || c === a) continue;
      faces.push(...((k - 2 - start) % 2 === 1 ? [b, a, c] : [a, b, c]));
    }
    at = end;
  }
  return faces;
}

function coloursOf(vertex: Element): { colours: Uint8Array | null; notes: Note[] } {
  const names = colourNames(vertex);
  if (names.length === 0) return { colours: null, notes: [] };
  if (names === SPLATS) {
    const shares = (columnsOf(vertex, SPLATS) as Float64Array).map((x) => Math.min(Math.max(0.5 + SH_0 * x, 0.0), 1.0));
    const { codes, notes } = colourCodes(shares, "f8");
    return { colours: codes, notes: [noted("its Gaussian splats are taken as points"), ...notes] };
  }
  const first = vertex.columns.get(names[0]) as Column;
  const width = first.sizes === null ? 0 : first.sizes[0];
  const rows = width === 0 ? (columnsOf(vertex, names) as Float64Array) : first.values.filter((_, k) => k % width < 3);
  const { codes, notes } = colourCodes(rows, commonKind(names.map((name) => (vertex.columns.get(name) as Column).kind)));
  return { colours: codes, notes };
}

/** The type that columns of several have side by side. */
function commonKind(kinds: Kind[]): Kind {
  return kinds.every((kind) => kind === kinds[0]) ? kinds[0] : "f8";
}

/** The names of the columns that are an element's colours: three, or one of lists. */
function colourNames(element: Element): string[] {
  const triples = element.name === "vertex" ? [...COLOUR_NAMES, SPLATS] : COLOUR_NAMES;
  const scalar = (name: string): boolean => element.columns.get(name)?.sizes === null;
  const triple = triples.find((names) => names.every(scalar));
  if (triple !== undefined) return triple;
  const list = LISTS_OF_COLOURS.find((name) => {
    const sizes = element.columns.get(name)?.sizes;
    return sizes != null && sizes.length > 0 && (sizes[0] === 3 || sizes[0] === 4) && sizes.every((n) => n === sizes[0]);
  });
  return list === undefined ? [] : [list];
}
