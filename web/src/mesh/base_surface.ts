/** A mesh prepared for painting: welded, split at creases, without faces of no area: `paint3d/mesh/base_surface.py`. */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { stableOrder } from "../core/numbers";
import { MeshError } from "../files/mesh_error";
import type { TriangleMesh } from "./triangle_mesh";

const AGREES = 0.8; // least cosine to the computed normal at which the file's is taken

export interface BaseSurface {
  points: NDArray<"f4">; // (B, 3) mm
  normals: NDArray<"f4">; // (B, 3)
  faces: NDArray<"i4">; // (R, 3)
  radial: NDArray<"i4">; // (3 R,)
  areas: Float64Array; // (R,) mm2
  longest: Float64Array; // (R,) longest edges, mm
  sourceVertices: Int32Array; // (B,)
  sourceFaces: Int32Array; // (R,)
}

/** What Python says of preparing meshes. */
export interface Preparing {
  crease_cosine: number;
  most_around_edge: number;
  most_aside_mm: number;
  leaf_sizes: { contact: number; closest: number };
}

export function makeBaseSurface(kernels: Kernels, mesh: TriangleMesh, say: Preparing): BaseSurface {
  const nVertices = mesh.vertices.length / 3;
  const nFaces = mesh.faces.length / 3;
  const points = NDArray.of(kernels, "f4", mesh.vertices.map((x) => x + 0.0), [nVertices, 3]); // -0 becomes 0
  const table = NDArray.of(kernels, "i4", new Int32Array(1 << (32 - Math.clz32(2 * nVertices))).fill(-1));
  const ids = kernels.zeros("i4", nVertices);
  const bits = new NDArray(kernels, "u4", [nVertices, 3], points.address);
  kernels.call("mesh.kernels.topology.weld_positions", bits, table, ids);
  table.free();
  const faces = NDArray.of(kernels, "i4", mesh.faces, [nFaces, 3]);
  const [faceNormals, doubled] = [kernels.zeros("f4", nFaces, 3), kernels.zeros("f8", nFaces)];
  kernels.call("mesh.kernels.topology.measure_faces", points, faces, faceNormals, doubled);
  const welded = mesh.faces.map((v) => ids.data[v]);
  const sizes = doubled.data;
  const kept: number[] = [];
  for (let t = 0; t < nFaces; t++) {
    const [a, b, c] = [welded[3 * t], welded[3 * t + 1], welded[3 * t + 2]];
    if (sizes[t] > 0.0 && a !== b && b !== c && c !== a) kept.push(t);
  }
  if (kept.length === 0)
    throw new MeshError("{name}: none of {n} faces has an area; expected a surface", { name: mesh.name, n: nFaces });
  const keep = Int32Array.from(kept);
  const rows = (from: ArrayLike<number>, to: Float32Array | Int32Array): void =>
    keep.forEach((t, k) => {
      for (let c = 0; c < 3; c++) to[3 * k + c] = from[3 * t + c];
    });
  const [ownFaces, ownIds] = [new Int32Array(3 * keep.length), new Int32Array(3 * keep.length)];
  const ownNormals = kernels.zeros("f4", keep.length, 3);
  rows(mesh.faces, ownFaces);
  rows(welded, ownIds);
  rows(faceNormals.data, ownNormals.data);
  const areas = Float64Array.from(keep, (t) => 0.5 * doubled.data[t]);
  for (const array of [ids, faces, faceNormals, doubled]) array.free();

  const weldedFaces = NDArray.of(kernels, "i4", ownIds, [keep.length, 3]);
  const nIds = ownIds.reduce((most, id) => Math.max(most, id), 0) + 1;
  const radial = NDArray.of(
    kernels, "i4", kernels.call("mesh.kernels.topology.link_radial", weldedFaces, nIds) as Int32Array,
  ); // prettier-ignore
  const most = kernels.call("mesh.kernels.topology.count_around", radial) as number;
  if (most > say.most_around_edge)
    throw new MeshError("{name}: {n} triangles share one edge; expected at most {most}", {
      name: mesh.name, n: most, most: say.most_around_edge,
    }); // prettier-ignore
  const groups = kernels.call(
    "mesh.kernels.topology.smooth_corners", weldedFaces, ownNormals, radial, say.crease_cosine,
  ) as Int32Array; // prettier-ignore
  weldedFaces.free();
  // a group is named after its first corner
  const numbers = new Int32Array(groups.length);
  const first: number[] = [];
  for (let c = 0; c < groups.length; c++) {
    if (groups[c] === c) first.push(c);
    numbers[c] = first.length - 1;
  }
  const sources = Uint32Array.from(first, (c) => ownFaces[c]);
  const order = stableOrder(sources);
  const rank = new Int32Array(order.length);
  order.forEach((k, place) => (rank[k] = place));
  const vertexOfCorner = groups.map((lead) => rank[numbers[lead]]);
  const source = Int32Array.from(order, (k) => sources[k]);
  const n = source.length;
  const basePoints = kernels.zeros("f4", n, 3);
  const [to, from] = [basePoints.data, points.data];
  source.forEach((v, k) => {
    for (let c = 0; c < 3; c++) to[3 * k + c] = from[3 * v + c];
  });
  points.free();
  const newFaces = NDArray.of(kernels, "i4", vertexOfCorner, [keep.length, 3]);
  const corners = NDArray.of(kernels, "i4", vertexOfCorner);
  const computed = kernels.zeros("f8", n, 3);
  kernels.call("mesh.kernels.topology.corner_normals", basePoints, newFaces, ownNormals, corners, computed);
  const normals = NDArray.of(kernels, "f4", preferGiven(computed.data, mesh.normals, source), [n, 3]);
  const longest = kernels.zeros("f8", keep.length);
  kernels.call("mesh.kernels.topology.longest_sides", basePoints, newFaces, longest);
  const result = {
    points: basePoints, normals, faces: newFaces, radial, areas, longest: longest.data.slice(),
    sourceVertices: source, sourceFaces: keep,
  }; // prettier-ignore
  for (const array of [ownNormals, corners, computed, longest]) array.free();
  return result;
}

/** The file's own normal where the vertex is smooth and the two roughly agree. */
function preferGiven(normals: Float64Array, given: Float32Array | null, source: Int32Array): Float32Array {
  if (given === null) return Float32Array.from(normals);
  const counts = new Int32Array(given.length / 3);
  for (const v of source) counts[v]++;
  const result = new Float32Array(normals.length);
  source.forEach((v, k) => {
    const theirs = [given[3 * v], given[3 * v + 1], given[3 * v + 2]];
    const length = Math.sqrt(theirs[0] * theirs[0] + theirs[1] * theirs[1] + theirs[2] * theirs[2]);
    const unit = theirs.map((x) => x / (length > 0.0 ? length : 1.0));
    const agree = unit.reduce((sum, x, c) => sum + x * normals[3 * k + c], 0.0);
    const isTheirs = counts[v] === 1 && agree > AGREES;
    for (let c = 0; c < 3; c++) result[3 * k + c] = isTheirs ? unit[c] : normals[3 * k + c];
  });
  return result;
}
