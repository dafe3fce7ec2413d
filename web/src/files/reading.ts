/** From a mesh file to checked triangles: `paint3d/files/reading.py`, for what a page reads. */

import { makeMesh, type TriangleMesh } from "../mesh/triangle_mesh";
import { triangulate } from "../mesh/polygons";
import { readGlb, readyForGlb } from "./formats/glb";
import { readObj } from "./formats/obj";
import { readPly } from "./formats/ply";
import { readStl } from "./formats/stl";
import { damaged, MeshError, noted, type Note } from "./mesh_error";
import { narrowed, type RawMesh } from "./raw_mesh";
import { checkSize, SUFFIXES, UNITS_MM, type Up, type Wanted } from "./wanted";

const READERS: Record<string, (data: Uint8Array) => RawMesh> = {
  ".glb": readGlb, ".obj": readObj, ".ply": readPly, ".stl": readStl,
}; // prettier-ignore
const ON_THE_DESKTOP = [".off", ".3mf", ".gltf", ".xyz", ".dae", ".zae"];
const UNREAD: Record<string, string> = {
  ".usd": "USD", ".usda": "USD", ".usdc": "USD", ".usdz": "USD", ".wrl": "VRML", ".vrml": "VRML", ".x3d": "VRML",
  ".fbx": "FBX", ".blend": "a .blend file", ".xaml": "XAML", ".ctm": "OpenCTM", ".3ds": "3DS",
}; // prettier-ignore
const MOST_TRIANGLES = 500_000; // that a page has memory for

/** Rows of the rotation, of quarter turns, that brings an axis to z. */
const TURNS: Record<Up, number[][]> = {
  z: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  y: [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
  x: [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
  "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
  "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
}; // prettier-ignore
export interface Reading {
  mesh: TriangleMesh;
  notes: Note[]; // what its reader has to tell
}

/** Read a file of this name. */
export async function readMesh(name: string, data: Uint8Array, wanted: Wanted = {}): Promise<Reading> {
  const read = readerOf(name);
  checkSize(data.length);
  if (data.length === 0) throw new MeshError("the file is empty");
  if (read === readGlb) await readyForGlb();
  const raw = structured(() => read(narrowed(data)));
  check(raw);
  const turn = TURNS[wanted.up ?? raw.up ?? "z"];
  const unit = wanted.unit === undefined ? (raw.unitMm ?? 1.0) : UNITS_MM[wanted.unit];
  const vertices = turned(raw.vertices, turn).map((x) => x * unit);
  const normals = raw.normals === null ? null : turned(raw.normals, turn);
  if (raw.sizes.length === 0) {
    const n = vertices.length / 3;
    if (raw.announces !== null)
      throw new MeshError(
        "it has {n:,} points but no triangles, though it says it has {announces}; expected a surface",
        { n, announces: raw.announces },
      );
    throw new MeshError("it has {n:,} points but no triangles; expected a surface", { n });
  }
  let faces = Int32Array.from(triangulate(vertices, raw.corners, raw.sizes));
  const notes = [...raw.notes];
  const isDistinct = (t: number): boolean =>
    faces[t] !== faces[t + 1] && faces[t + 1] !== faces[t + 2] && faces[t + 2] !== faces[t];
  let distinct = 0;
  for (let t = 0; t < faces.length; t += 3) distinct += Number(isDistinct(t));
  const n = faces.length / 3 - distinct;
  if (n > 0 && distinct > 0) {
    const text = "left out {n:,} face that names a vertex twice";
    notes.push(noted(text, { n }, "left out {n:,} faces that name a vertex twice"));
    faces = faces.filter((_, k) => isDistinct(k - (k % 3)));
  }
  if (faces.length > 3 * MOST_TRIANGLES)
    throw new MeshError("it has {n:,} triangles; a page takes {most:,} at most: Blender can decimate it", {
      n: faces.length / 3, most: MOST_TRIANGLES,
    }); // prettier-ignore
  const mesh = makeMesh(name.split(".")[0], vertices, faces, raw.colours, unitNormals(normals, vertices, faces));
  return { mesh, notes };
}

/** What damaged structure makes a reader stumble over, in words. */
function structured<T>(read: () => T): T {
  try {
    return read();
  } catch (cause) {
    if (cause instanceof MeshError) throw cause;
    if (!(cause instanceof RangeError)) throw damaged(noted("a part of it is of another kind than is expected there"));
    if (/call stack/i.test(cause.message)) throw damaged(noted("its parts are nested too deeply"));
    if (/memory|alloc|array (?:buffer )?(?:length|size)/i.test(cause.message)) throw cause; // there is not enough of it
    throw damaged(noted("it refers to something that it does not have")); // beyond the end of an array
  }
}

function readerOf(name: string): (data: Uint8Array) => RawMesh {
  const dot = name.lastIndexOf(".");
  const suffix = dot > 0 ? name.slice(dot).toLowerCase() : "";
  const known = SUFFIXES.join(" ");
  if (suffix in READERS) return READERS[suffix];
  if (suffix in UNREAD)
    throw new MeshError("{kind} is not read (Blender saves it as .glb); expected one of {known}", {
      kind: UNREAD[suffix], known,
    }); // prettier-ignore
  if (ON_THE_DESKTOP.includes(suffix))
    throw new MeshError("a page does not read {suffix}, the desktop does; expected one of {known}", { suffix, known });
  if (suffix !== "")
    throw new MeshError("the suffix {suffix!r} is not known; expected one of {known}", { suffix, known });
  throw new MeshError("it has no suffix; expected one of {known}", { known });
}

function check({ vertices, corners, sizes }: RawMesh): void {
  const n = vertices.length / 3;
  if (n === 0) throw new MeshError("it has no vertices and no triangles; expected a surface");
  const bad = vertices.findIndex((x) => !Number.isFinite(x));
  if (bad >= 0) {
    const first = Math.floor(bad / 3);
    const where = Array.from(vertices.subarray(3 * first, 3 * first + 3), (x) =>
      Number.isFinite(x) ? String(Number(x.toPrecision(6))) : String(x).toLowerCase().replace("infinity", "inf"));
    throw new MeshError("vertex {first} is ({where}); expected finite numbers", { first, where: where.join(", ") });
  }
  const outside = corners.findIndex((v) => !(v >= 0 && v < n));
  if (outside < 0) return;
  let face = 0;
  for (let end = sizes[0]; end <= outside; end += sizes[face]) face++;
  throw new MeshError("face {face} refers to vertex {index}; expected 0 to {last}", {
    face, index: corners[outside], last: n - 1,
  }); // prettier-ignore
}

/** Vectors (N, 3) after quarter turns, exact to the last bit. */
function turned(rows: Float64Array, turn: number[][]): Float64Array {
  const axes = turn.map((row) => row.findIndex((x) => x !== 0));
  return rows.map((_, k) => rows[k - (k % 3) + axes[k % 3]] * turn[k % 3][axes[k % 3]]);
}

/** Normals of length 1; those of no length, or that are no numbers, are worked out from the faces. */
function unitNormals(
  normals: Float64Array | null, vertices: Float64Array, faces: Int32Array,
): Float64Array | null {
  if (normals === null) return null;
  const n = normals.length / 3;
  const lengths = Float64Array.from({ length: n }, (_, v) => {
    const [x, y, z] = normals.subarray(3 * v, 3 * v + 3);
    return Math.sqrt(x * x + y * y + z * z);
  });
  const isSound = lengths.map((length) => Number(Number.isFinite(length) && length > 1e-6));
  if (!isSound.includes(1)) return null;
  const unit = normals.map((x, k) => x / (isSound[Math.floor(k / 3)] ? lengths[Math.floor(k / 3)] : 1.0));
  if (!isSound.includes(0)) return unit;
  const sums = new Float64Array(3 * n);
  for (let t = 0; t < faces.length; t += 3) {
    const corner = (k: number): Float64Array => vertices.subarray(3 * faces[t + k], 3 * faces[t + k] + 3);
    const [a, b, c] = [corner(0), corner(1), corner(2)];
    const [u, v] = [b.map((x, k) => x - a[k]), c.map((x, k) => x - a[k])];
    const doubled = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (let k = 0; k < 3; k++) for (let axis = 0; axis < 3; axis++) sums[3 * faces[t + k] + axis] += doubled[axis];
  }
  for (let v = 0; v < n; v++) {
    if (isSound[v]) continue;
    const own = sums.subarray(3 * v, 3 * v + 3);
    if (own.every((x) => x === 0.0)) own[2] = 1.0; // of no triangle
    const length = Math.sqrt(own[0] * own[0] + own[1] * own[1] + own[2] * own[2]);
    for (let axis = 0; axis < 3; axis++) unit[3 * v + axis] = own[axis] / length;
  }
  return unit;
}
