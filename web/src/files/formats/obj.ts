/** Wavefront OBJ: polygons, relative indices, colours after the position: `paint3d/files/formats/obj.py`. */

import { colourCodes } from "../colours";
import { MeshError, noted, type Note } from "../mesh_error";
import { indexArray, leftOut, parseNumbers, plainText, rawMesh, wordsOf, type RawMesh } from "../raw_mesh";

const OPAQUE = [1.0, 255.0];
const POLYPAINT = /^[ \t]*#MRGB[ \t]+([0-9a-fA-F]+)/gm;
const ODD_EXPONENT = /(\d)([+-])[eE](?=\d)/g;
const NO_POINTS: Record<string, Note> = {
  l: noted("lines"),
  curv: noted("curves, which are not read"),
  surf: noted("free-form surfaces, which are not read"),
};
const PASSED_OVER: Record<string, Note> = {
  l: noted("lines"),
  p: noted("points"),
  curv: noted("curves"),
  surf: noted("free-form surfaces"),
};

/** Read an OBJ file; lines, points, curves and free-form surfaces are passed over, and noted. */
export function readObj(data: Uint8Array): RawMesh {
  const text = plainText(data);
  const lines = text.replaceAll("\t", " ").replaceAll("\\\n", " ").split("\n").map((line) => line.split("#", 1)[0].trim());
  const vertexLines: string[] = [];
  const faceLines: string[] = [];
  const before: number[] = []; // vertices, of each face
  const kinds = new Set<string>();
  for (const line of lines) {
    const space = line.indexOf(" ");
    const kind = space < 0 ? line : line.slice(0, space);
    kinds.add(kind);
    if (kind === "v" && space > 0) vertexLines.push(line.slice(2));
    if (kind !== "f" || space < 0) continue;
    faceLines.push(line.slice(2));
    before.push(vertexLines.length);
  }
  const { vertices, colours: own, notes } = readVertices(vertexLines);
  let colours = own;
  if (colours === null && text.includes("#MRGB")) {
    const painted = polypaint(text, vertexLines.length);
    colours = painted.codes;
    notes.push(...painted.notes);
  }
  const sizes = Int32Array.from(faceLines, (line) => wordsOf(line).length);
  const numbers = parseNumbers(faceLines.join("\n").replace(/\/[^ \t\n\r\f\v]*/g, ""), noted("a face"));
  const corners = indexArray(numbers, noted("a face"));
  if (corners.includes(0)) throw new MeshError("a face refers to vertex 0; OBJ counts from 1");
  for (let face = 0, at = 0; face < sizes.length; face++)
    for (const end = at + sizes[face]; at < end; at++) corners[at] += corners[at] < 0 ? before[face] : -1;
  const dropped = Object.keys(PASSED_OVER).filter((kind) => kinds.has(kind)).map((kind) => PASSED_OVER[kind]);
  if (kinds.has("mtllib") && kinds.has("usemtl")) dropped.push(noted("its colours and pictures"));
  const besides = Object.keys(NO_POINTS).find((kind) => kinds.has(kind));
  const announces = sizes.length === 0 && besides !== undefined ? NO_POINTS[besides] : null;
  return rawMesh({ vertices, corners, sizes, colours, announces, notes: [...notes, ...leftOut(dropped)] });
}

function readVertices(lines: string[]): { vertices: Float64Array; colours: Uint8Array | null; notes: Note[] } {
  const widths = lines.map((line) => wordsOf(line).length);
  const narrow = widths.indexOf(widths.reduce((a, b) => Math.min(a, b), 3));
  if (lines.length > 0 && widths[narrow] < 3)
    throw new MeshError("a vertex line holds {line!r}; expected three numbers", { line: lines[narrow].slice(0, 40) });
  const numbers = readNumbers(lines.join("\n"));
  const n = lines.length;
  const [vertices, rgb] = [new Float64Array(3 * n), new Float64Array(3 * n)];
  const first = new Int32Array(n);
  for (let v = 1; v < n; v++) first[v] = first[v - 1] + widths[v - 1];
  const coloured: number[] = [];
  const rows: Record<number, number[]> = { 6: [], 7: [], 8: [] };
  for (let v = 0; v < n; v++) {
    vertices.set(numbers.subarray(first[v], first[v] + 3), 3 * v);
    if (!(widths[v] in rows)) continue;
    rows[widths[v]].push(first[v]);
    coloured.push(v);
  }
  if (coloured.length === 0) return { vertices, colours: null, notes: [] };
  const columns = { 6: 3, 7: columnOfSeven(numbers, rows[7]), 8: 4 };
  for (const v of coloured) {
    const at = first[v] + columns[widths[v] as 6 | 7 | 8];
    rgb.set(numbers.subarray(at, at + 3), 3 * v);
  }
  const told = Float64Array.from(coloured.flatMap((v) => [...rgb.subarray(3 * v, 3 * v + 3)]));
  const { codes, notes } = colourCodes(told, "f8");
  if (codes === null) return { vertices, colours: null, notes };
  const colours = new Uint8Array(3 * n).fill(255);
  coloured.forEach((v, k) => colours.set(codes.subarray(3 * k, 3 * k + 3), 3 * v));
  return { vertices, colours, notes };
}

/** Where red stands in lines of seven: before an opacity, the same everywhere, or after a weight of 1. */
function columnOfSeven(numbers: Float64Array, rows: number[]): number {
  if (rows.length === 0) return 3;
  const last = numbers[rows[0] + 6];
  const isOpaque = OPAQUE.includes(last) && rows.every((at) => numbers[at + 6] === last);
  return rows.every((at) => numbers[at + 3] === 1.0) && !isOpaque ? 4 : 3;
}

/** The colours that ZBrush writes as comments: MMRRGGBB for each vertex. */
function polypaint(text: string, n: number): { codes: Uint8Array | null; notes: Note[] } {
  const digits = Array.from(text.matchAll(POLYPAINT), ([, some]) => some).join("");
  if (digits === "") return { codes: null, notes: [] };
  if (digits.length !== 8 * n) {
    const what = noted("its polypaint, of {n:,} vertices instead of {wanted:,}", { n: digits.length >> 3, wanted: n });
    return { codes: null, notes: leftOut([what]) };
  }
  const codes = Uint8Array.from({ length: 3 * n }, (_, k) => {
    const at = 8 * Math.floor(k / 3) + 2 + 2 * (k % 3);
    return parseInt(digits.slice(at, at + 2), 16);
  });
  return { codes, notes: [] };
}

/** Parse numbers; where that fails, read exponents like 3.1+e2, which some programs write. */
function readNumbers(text: string): Float64Array {
  try {
    return parseNumbers(text, noted("a vertex"));
  } catch (cause) {
    if (!(cause instanceof MeshError)) throw cause;
    return parseNumbers(text.replace(ODD_EXPONENT, "$1e$2"), noted("a vertex"));
  }
}
