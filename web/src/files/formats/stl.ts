/** STL, binary and ASCII: equal positions become one vertex: `paint3d/files/formats/stl.py`. */

import { MeshError, noted } from "../mesh_error";
import { checkCount, FACE_COLOURS, latin, leftOut, parseNumbers, rawMesh, threes, type RawMesh } from "../raw_mesh";

const HEADER = 84;
const FACET = 50; // bytes
const VERTEX = /^[ \t\f\v]*vertex[ \t\n\r\f\v]+([^ \t\n\r\f\v]+[ \t\n\r\f\v]+[^ \t\n\r\f\v]+[ \t\n\r\f\v]+[^ \t\n\r\f\v]+)/gim;
const FACETS = /^[ \t\f\v]*facet\b/gim;
const ENDS = /^[ \t\f\v]*endfacet\b/gim;
const COLOURS = /^[ \t\f\v]*colou?r[ \t\n\r\f\v]+[\d.]/im;

/** Read an STL file: binary where its length fits the count at byte 80, whatever its header says. */
export function readStl(data: Uint8Array): RawMesh {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const count = data.length >= HEADER ? view.getUint32(80, true) : 0;
  if (data.length < HEADER || data.length !== HEADER + FACET * count) {
    if (/^[ \t\n\r\f\v]*solid/i.test(latin(data.subarray(0, 512)))) {
      const text = latin(data);
      if (text.search(FACETS) >= 0) return readText(text);
    }
    if (data.length < HEADER)
      throw new MeshError("it has {n} bytes; a binary STL has at least {header}", { n: data.length, header: HEADER });
  }
  checkCount(count, FACET, data.length - HEADER, noted("triangles"));
  const corners = new Float64Array(9 * count);
  let isColoured = latin(data.subarray(0, HEADER - 4)).includes("COLOR=");
  for (let t = 0; t < count; t++) {
    const at = HEADER + FACET * t;
    for (let k = 0; k < 9; k++) corners[9 * t + k] = view.getFloat32(at + 12 + 4 * k, true);
    isColoured ||= view.getUint16(at + 48, true) >> 15 === 1;
  }
  return { ...merged(corners), notes: isColoured ? leftOut([FACE_COLOURS]) : [] };
}

function readText(text: string): RawMesh {
  const found = Array.from(text.matchAll(VERTEX), ([, numbers]) => numbers);
  const [facets, ends] = [FACETS, ENDS].map((words) => (text.match(words) ?? []).length);
  if (found.length !== 3 * facets || ends !== facets)
    throw new MeshError(
      "it has {n_facets} facets, {n_ends} of them ended, with {n} vertices; expected {expected}: the file is cut " +
        "short or damaged",
      { n_facets: facets, n_ends: ends, n: found.length, expected: 3 * facets },
    );
  const mesh = merged(parseNumbers(found.join("\n"), noted("a vertex")));
  return { ...mesh, notes: COLOURS.test(text) ? leftOut([FACE_COLOURS]) : [] };
}

/** The distinct positions in order of appearance, and the triangles that refer to them. */
function merged(corners: Float64Array): RawMesh {
  const keys = corners.map((x) => x + 0.0); // makes -0 equal to 0, byte by byte
  const bits = new Uint32Array(keys.buffer);
  const n = keys.length / 3;
  let slots = 16;
  while (slots < 2 * n) slots *= 2;
  const table = new Int32Array(slots).fill(-1);
  const first: number[] = []; // corners
  const ids = new Float64Array(n);
  for (let c = 0; c < n; c++) {
    let hash = 0;
    for (let k = 0; k < 6; k++) hash = Math.imul(hash ^ bits[6 * c + k], 0x9e3779b1) ^ (hash >>> 15);
    let slot = (hash ^ (hash >>> 13)) & (slots - 1);
    for (; table[slot] >= 0; slot = (slot + 1) & (slots - 1)) {
      const other = 6 * first[table[slot]];
      let k = 0;
      while (k < 6 && bits[6 * c + k] === bits[other + k]) k++;
      if (k === 6) break;
    }
    if (table[slot] < 0) {
      table[slot] = first.length;
      first.push(c);
    }
    ids[c] = table[slot];
  }
  const vertices = new Float64Array(3 * first.length);
  first.forEach((c, k) => vertices.set(keys.subarray(3 * c, 3 * c + 3), 3 * k));
  return rawMesh({ vertices, corners: ids, sizes: threes(n / 3) });
}
