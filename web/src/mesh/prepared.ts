/**
 * What a page paints with of an object that somebody brings, as `object_table` of
 * `paint3d/page/tables.py` makes it of those that a page is built with: `PaintMesh.build`
 * (`paint3d/mesh/refined_mesh.py`) and the trees of boxes (`paint3d/mesh/bvh.py`).
 */

import { NDArray, type Kind, type Views } from "../core/arrays";
import type { Table } from "../core/bundle";
import type { Kernels } from "../core/kernels";
import { interleaved, pairwiseSum, roundHalfToEven, stableOrder } from "../core/numbers";
import { MeshError } from "../files/mesh_error";
import { makeBaseSurface, type BaseSurface, type Preparing } from "./base_surface";
import type { ObjectWords } from "./refined_mesh";
import { digestOf, type TriangleMesh } from "./triangle_mesh";

const REFINED_CELL = 5.0; // edges across a cell: cells are refined as a whole
const PLAIN_CELL = 12.0;
const MOST_CELLS = 4e6;
const COARSEST_CELL = 256.0; // edges
const SOFT_EDGE_PER_EDGE = 0.6;
const BLOCK_STEPS = 16; // along a cell, to sort its vertices by
const BLOCK_VERTICES = 32;
const LATTICE = 1 << 20; // cells along an axis
const AREA_BITS = 61;
const STEPS_PER_EDGE = 8; // float32 steps that a shortest edge must span
const PATH = 1 << 16;
const MOST_PAIRS = 2 ** 24; // of cells and the triangles in them: what a page has memory for
const CRACK_MM = 0.1; // widest gap that paint goes over
const SMOOTHINGS = 12; // of what vertices see of the sky
const LIFTED_MM = 0.05;
const MOST_RAYS = 1.5e6; // that this is found by
const [FEWEST_RAYS, USUAL_RAYS] = [16, 96]; // of each vertex
const GOLDEN_ANGLE = Math.PI * (3.0 - Math.sqrt(5.0));

/** Words and arrays of an object, as its file has them. */
export interface Prepared {
  words: ObjectWords;
  arrays: Record<string, Table>;
}

/** A lattice's cells as kernels take them. */
interface Cells {
  [name: string]: NDArray | number;
  cell_size: number;
  cell_place: NDArray<"i4">;
  cell_pairs: NDArray<"i8">;
  pair_root: NDArray<"i4">;
  cell_sheets: NDArray<"i4">;
}

/** Prepare an object; `progress` is told the share that is done. */
export function prepare(
  kernels: Kernels, mesh: TriangleMesh, resolution: number, say: Preparing,
  progress: (share: number) => void,
): Prepared {
  const base = makeBaseSurface(kernels, mesh, say);
  progress(0.15);
  const refines = base.longest.reduce((a, b) => Math.max(a, b), 0.0) > resolution;
  if (refines) checkPrecision(base.points.data, resolution);
  const size = cellSize(pairwiseSum(base.areas), resolution, refines);
  const { order, cells, field } = buildLattice(kernels, base, size);
  progress(0.4);
  const arrays: Record<string, Table> = {};
  const put = <K extends Kind>(name: string, kind: K, values: Views[K], ...shape: number[]): void => {
    const isWhole = values.byteLength === values.buffer.byteLength;
    arrays[name] = { kind, shape: shape.length > 0 ? shape : [values.length], values: isWhole ? values : values.slice() };
  };
  const n = order.length;
  const rank = new Int32Array(n);
  order.forEach((v, k) => (rank[v] = k));
  const faces = base.faces.data.map((v) => rank[v]);
  const roots = faces.length / 3;
  const [points, normals] = [base.points.data, base.normals.data].map((rows) => {
    const sorted = new Float32Array(3 * n);
    order.forEach((v, k) => {
      for (let c = 0; c < 3; c++) sorted[3 * k + c] = rows[3 * v + c];
    });
    return sorted;
  });
  put("base_faces", "i4", faces, roots, 3);

  const longest = base.longest.reduce((a, b) => Math.max(a, b), 0.0);
  const shift = refines ? 2 * Math.max(0, Math.ceil(Math.log2(longest / resolution))) + 6 : 0;
  const column = (rows: Float32Array, c: number): Float32Array =>
    Float32Array.from({ length: n }, (_, k) => rows[3 * k + c]);
  const unit = pairwiseSum(base.areas) / 2.0 ** (AREA_BITS - shift);
  const nodeArea = BigInt64Array.from(base.areas, (area) =>
    BigInt(Math.max(roundHalfToEven(area / unit), 1.0)) << BigInt(shift));
  const shares = [
    ...[0, 1, 2].map((c) => NDArray.of(kernels, "f4", column(points, c), [n])),
    NDArray.of(kernels, "i4", faces, [roots, 3]), NDArray.of(kernels, "i8", nodeArea, [roots]), NDArray.zeros(kernels, "i8", [n]),
  ]; // prettier-ignore
  kernels.call("mesh.kernels.refine.spread_areas", ...shares);
  const areaUnits = (shares[5] as NDArray<"i8">).data.slice();
  for (const array of shares) array.free();
  const areaUnit = unit / 2.0 ** shift;
  const areas = Float64Array.from(areaUnits, (units) => Number(units) * areaUnit);
  const forest = refines ? roots : 0;
  for (const [c, axis] of ["x", "y", "z"].entries()) {
    put(`field.p${axis}`, "f4", column(points, c));
    put(`field.n${axis}`, "f4", column(normals, c));
    put(`field.m${axis}`, "f4", column(points, c));
  }
  put("field.counts", "i8", BigInt64Array.of(BigInt(n), BigInt(forest)));
  put("field.take", "f4", new Float32Array(n).fill(1.0));
  put("field.key", "u8", positionKeys(points));
  put("field.parents", "i4", new Int32Array(2 * n).fill(-1), n, 2);
  put("field.area_units", "i8", areaUnits);
  put("field.area", "f4", Float32Array.from(areas));
  put("field.next_in_cell", "i4", new Int32Array(n).fill(-1));
  put("field.node_vertices", "i4", faces.slice(0, 3 * forest), forest, 3);
  put("field.node_root", "i4", Int32Array.from({ length: forest }, (_, k) => k));
  put("field.child", "i4", new Int32Array(forest).fill(-1));
  put("field.longest", "i1", new Int8Array(forest));
  put("field.radial", "i4", base.radial.data.slice(0, 3 * forest));
  put("field.node_area", "i8", nodeArea.slice(0, forest));
  put("field.head", "i4", new Int32Array(cells.cell_place.length).fill(-1));
  put("field.done", "u1", new Uint8Array(cells.cell_place.length).fill(refines ? 0 : 1));
  put("field.path", "i4", new Int32Array(PATH));
  for (const [name, array] of Object.entries({ ...cells, ...field }))
    if (array instanceof NDArray) put(`field.${name}`, array.kind, array.data.slice(), ...array.shape);
  const words: ObjectWords = {
    name: mesh.name, mesh: digestOf(mesh), resolution, refines, n_base_vertices: n,
    usual_material: "porcelain", most_around_edge: say.most_around_edge, most_aside_mm: say.most_aside_mm,
    leaf_sizes: say.leaf_sizes,
    field: {
      resolution, cell_size: size, soft_edge: SOFT_EDGE_PER_EDGE * resolution, area_unit: areaUnit,
      area_step: stepOf(areas), paper: 0.0,
    },
  }; // prettier-ignore
  if (refines) {
    const given: Record<string, NDArray | number> = { ...words.field };
    const all = Object.entries(arrays).filter(([name]) => name.startsWith("field."));
    for (const [name, { kind, shape, values }] of all) given[name.slice(6)] = NDArray.of(kernels, kind, values, shape);
    const none = { sheet_area: [0], sheet_normal: [0, 3], sheet_centre: [0, 3] };
    for (const [name, shape] of Object.entries(none)) given[name] = NDArray.zeros(kernels, "f8", shape);
    given.sheet_pack = NDArray.zeros(kernels, "f4", [0, 8]);
    const out = given.longest as NDArray<"i1">;
    kernels.call("mesh.kernels.refine.longest_edges", given, out);
    put("field.longest", "i1", out.data.slice());
    for (const array of Object.values(given)) if (array instanceof NDArray) array.free();
  }
  const contact = boxTree(kernels, points, faces, say.leaf_sizes.contact, false);
  put("contact.order", "i4", contact.order);
  put("contact.triangles", "i4", contact.triangles, roots, 3);
  put("contact.points", "f4", points, n, 3);
  put("contact.normals", "f4", normals, n, 3);
  const closest = boxTree(kernels, base.points.data, base.faces.data, say.leaf_sizes.closest, true);
  put("closest.order", "i4", closest.order.map((k) => base.sourceFaces[k]));
  put("closest.triangles", "i4", closest.triangles, roots, 3);
  put("closest.points", "f4", base.points.data.slice(), n, 3);
  put("closest.normals", "f4", base.normals.data.slice(), n, 3);
  progress(0.5);
  const open = openness(kernels, arrays, say.leaf_sizes.closest, points, normals,
    (share) => progress(0.5 + 0.5 * share)); // prettier-ignore
  put("openness", "u1", smoothed(open, faces));
  const source = order.map((v) => base.sourceVertices[v]);
  const { colours } = mesh;
  if (colours !== null)
    put("colours", "u1", Uint8Array.from({ length: 3 * n }, (_, k) => colours[3 * source[Math.floor(k / 3)] + (k % 3)]), n, 3);
  return { words, arrays };
}

function cellSize(area: number, resolution: number, refines: boolean): number {
  const least = Math.sqrt((2.0 * area) / MOST_CELLS);
  if (refines && least > COARSEST_CELL * resolution)
    throw new MeshError(
      "the object's surface of {area:.3g} m2 is too large for vertices every {resolution:g} mm; expected another " +
        "unit if it is not so large, or at least {least:.2g} mm",
      { area: 1e-6 * area, resolution, least: least / COARSEST_CELL },
    );
  return Math.max((refines ? REFINED_CELL : PLAIN_CELL) * resolution, least);
}

/** Distance to the next float32. */
function spacing(x: number): number {
  return 2.0 ** Math.max(Math.floor(Math.log2(Math.abs(x) || 1e-38)) - 23, -149);
}

function checkPrecision(points: Float32Array, resolution: number): void {
  let farthest = 0.0;
  const [low, high] = boundsOf(points);
  for (let c = 0; c < 3; c++) farthest = Math.max(farthest, Math.abs(low[c]), Math.abs(high[c]));
  const step = spacing(farthest);
  if (STEPS_PER_EDGE * step <= resolution) return;
  const span = Math.max(...high.map((h, c) => h - low[c]));
  const fields = { step, resolution, least: STEPS_PER_EDGE * step, farthest, span };
  if (STEPS_PER_EDGE * spacing(0.5 * span) <= resolution)
    throw new MeshError(
      "a coordinate is {farthest:g} mm, where float32 has steps of {step:g} mm, too coarse for vertices every " +
        "{resolution:g} mm; expected another unit if it is not so far, at least {least:.2g} mm, or the object moved " +
        "to the origin",
      fields,
    );
  throw new MeshError(
    "the object is {span:g} mm long, where float32 has steps of {step:g} mm, too coarse for vertices every " +
      "{resolution:g} mm; expected another unit if it is not so long, or at least {least:.2g} mm",
    fields,
  );
}

function boundsOf(points: Float32Array): [number[], number[]] {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let k = 0; k < points.length; k++) {
    const c = k % 3;
    if (points[k] < low[c]) low[c] = points[k];
    if (points[k] > high[c]) high[c] = points[k];
  }
  return [low, high];
}

/** The step (mm2, a power of two) in which weighed areas are summed. */
function stepOf(areas: Float64Array): number {
  const largest = areas.reduce((a, b) => Math.max(a, b), 0.0);
  const least = Math.max(largest * 2.0 ** -43, pairwiseSum(areas) * 2.0 ** -57);
  return 2.0 ** Math.ceil(Math.log2(least));
}

/** Hash positions (B, 3), so that both sides of a seam have the same key. */
function positionKeys(points: Float32Array): BigUint64Array {
  const bits = new Uint32Array(points.buffer, points.byteOffset, points.length);
  const short = (x: bigint): bigint => BigInt.asUintN(64, x);
  return BigUint64Array.from({ length: points.length / 3 }, (_, k) => {
    const [x, y, z] = [BigInt(bits[3 * k]), BigInt(bits[3 * k + 1]), BigInt(bits[3 * k + 2])];
    let key = short(x * 0x9e3779b97f4a7c15n);
    key ^= short(y * 0xc2b2ae3d27d4eb4fn + 1n);
    key ^= short((z * 0x165667b19e3779f9n + 7n) << 1n);
    key ^= key >> 29n;
    key = short(key * 0xbf58476d1ce4e5b9n);
    return key ^ (key >> 32n);
  });
}

// ---- The lattice ---------------------------------------------------------------------------------

/** Cells, sheets and their links, and the base vertices' order, cell by cell. */
function buildLattice(
  kernels: Kernels, base: BaseSurface, size: number,
): { order: Int32Array; cells: Cells; field: Record<string, NDArray> } {
  const [low, high] = boundsOf(base.points.data);
  const span = Math.max(...high.map((h, c) => h - low[c]));
  if (span / size > LATTICE - 4)
    throw new MeshError("the object is {span:g} mm long; expected at most {most:g} mm at this resolution", {
      span, most: LATTICE * size,
    }); // prettier-ignore
  // an irrational offset, so that faces at round coordinates do not lie between two cells
  const origin = NDArray.of(kernels, "f8", low.map((x) => x - 0.6180339887 * size));
  const { places, roots, runs } = pairsByCell(kernels, base, origin, size);
  const nCells = places.length / 3;
  let slots = 1;
  while (slots < 2 * nCells + 1) slots *= 2;
  const cells: Cells = {
    origin,
    cell_size: size,
    table: NDArray.of(kernels, "i4", new Int32Array(slots).fill(-1)),
    cell_place: NDArray.of(kernels, "i4", places, [nCells, 3]),
    cell_pairs: NDArray.of(kernels, "i8", BigInt64Array.from(runs, BigInt)),
    pair_root: NDArray.of(kernels, "i4", roots),
    pair_sheet: kernels.zeros("i4", roots.length),
    cell_sheets: kernels.zeros("i4", nCells + 1),
  };
  kernels.call("mesh.kernels.mesh_arrays.build_table", cells.cell_place, cells.table);
  const nSheets = kernels.call(
    "mesh.kernels.cell_components.split_sheets", base.points, base.faces, base.radial, cells,
  ) as number; // prettier-ignore
  const cracks = crackLinks(kernels, base, cells);
  const [links, linked] = sheetLinks(kernels, cells, runs, base.faces.length, nSheets, cracks);
  const { order, starts, sheets } = sortVertices(kernels, base, cells);
  const sheetCell = new Int32Array(nSheets);
  const ends = cells.cell_sheets.data;
  for (let c = 0; c < nCells; c++) sheetCell.fill(c, ends[c], ends[c + 1]);
  const sheetPlace = new Int32Array(4 * nSheets);
  sheetCell.forEach((c, s) => sheetPlace.set([places[3 * c], places[3 * c + 1], places[3 * c + 2], c], 4 * s));
  const { cellBlocks, balls } = blocks(base.points.data, order, starts);
  const field = {
    vertex_sheet: NDArray.of(kernels, "i4", sheets),
    base_start: NDArray.of(kernels, "i4", starts),
    cell_blocks: NDArray.of(kernels, "i4", cellBlocks),
    block_balls: NDArray.of(kernels, "f4", balls, [4, balls.length / 4]),
    sheet_cell: NDArray.of(kernels, "i4", sheetCell),
    sheet_place: NDArray.of(kernels, "i4", sheetPlace, [nSheets, 4]),
    sheet_links: NDArray.of(kernels, "i8", links),
    linked_sheet: NDArray.of(kernels, "i4", linked),
  };
  return { order, cells, field };
}

/** The cells (C, 3) in Morton order, the roots that meet them, and each cell's run. */
function pairsByCell(
  kernels: Kernels, base: BaseSurface, origin: NDArray, size: number,
): { places: Int32Array; roots: Int32Array; runs: Int32Array } {
  const area = pairwiseSum(base.areas);
  let capacity = Math.trunc(4 * base.faces.length + (2.0 * area) / size ** 2);
  let n = capacity + 1;
  let [places, roots] = [kernels.zeros("i4", 0, 3), kernels.zeros("i4", 0)];
  while (n > capacity) {
    capacity = Math.max(capacity, n);
    if (capacity > MOST_PAIRS)
      throw new MeshError(
        "the object's surface of {area:.3g} m2 would take about {n:.2g} cells at this resolution; expected at most " +
          "{most:.2g}: a coarser resolution or, if it is not so large, another unit",
        { area: 1e-6 * area, n: capacity, most: MOST_PAIRS },
      );
    places.free();
    roots.free();
    [places, roots] = [kernels.zeros("i4", capacity, 3), kernels.zeros("i4", capacity)];
    n = kernels.call(
      "mesh.kernels.cell_components.fill_pairs", base.points, base.faces, origin, size, places, roots,
    ) as number; // prettier-ignore
  }
  const [at, of] = [places.data.slice(0, 3 * n), roots.data.slice(0, n)];
  places.free();
  roots.free();
  const [low, high] = [new Uint32Array(n), new Uint32Array(n)];
  for (let k = 0; k < n; k++) {
    const [x, y, z] = [at[3 * k], at[3 * k + 1], at[3 * k + 2]];
    low[k] = interleaved(x, y, z, 10);
    high[k] = interleaved(x >> 10, y >> 10, z >> 10, 10);
  }
  const order = stableOrder(low, high);
  const runs: number[] = [];
  const cells: number[] = [];
  order.forEach((k, i) => {
    const before = i > 0 ? order[i - 1] : -1;
    if (before >= 0 && low[k] === low[before] && high[k] === high[before]) return;
    runs.push(i);
    cells.push(at[3 * k], at[3 * k + 1], at[3 * k + 2]);
  });
  runs.push(n);
  return { places: Int32Array.from(cells), roots: order.map((k) => of[k]), runs: Int32Array.from(runs) };
}

/** Sheets whose borders are at most `CRACK_MM` apart, in pairs, ascending. */
function crackLinks(kernels: Kernels, base: BaseSurface, cells: Cells): Int32Array {
  if (!base.radial.data.some((next, h) => next === h)) return new Int32Array();
  let capacity = 0;
  for (;;) {
    const links = kernels.zeros("i4", capacity, 2);
    const n = kernels.call(
      "mesh.kernels.topology.link_cracks", base.points, base.faces, base.radial, cells, CRACK_MM, links,
    ) as number; // prettier-ignore
    const rows = links.data;
    if (n <= capacity) {
      const keys = Float64Array.from({ length: n }, (_, k) => rows[2 * k] * 2 ** 26 + rows[2 * k + 1]).sort();
      const single = keys.filter((key, k) => k === 0 || key !== keys[k - 1]);
      links.free();
      return Int32Array.from(single).length === 0
        ? new Int32Array()
        : Int32Array.from([...single].flatMap((key) => [Math.floor(key / 2 ** 26), key % 2 ** 26]));
    }
    links.free();
    capacity = n;
  }
}

/** The sheets' graph as runs (S + 1,) and neighbours. */
function sheetLinks(
  kernels: Kernels, cells: Cells, runs: Int32Array, nRoots: number, nSheets: number, others: Int32Array,
): [BigInt64Array, Int32Array] {
  const rootOf = cells.pair_root.data;
  const nPairs = rootOf.length;
  const cellOf = new Int32Array(nPairs);
  for (let c = 0; c + 1 < runs.length; c++) cellOf.fill(c, runs[c], runs[c + 1]);
  const order = stableOrder(Uint32Array.from(rootOf));
  const counts = new Float64Array(nRoots + 1);
  for (const root of rootOf) counts[root + 1]++;
  for (let t = 0; t < nRoots; t++) counts[t + 1] += counts[t];
  const given = [
    NDArray.of(kernels, "i8", BigInt64Array.from(counts, BigInt)),
    NDArray.of(kernels, "i8", BigInt64Array.from(order, BigInt)),
    NDArray.of(kernels, "i4", cellOf),
  ];
  let capacity = 5 * nPairs;
  for (;;) {
    const links = kernels.zeros("i4", capacity, 2);
    const n = kernels.call("mesh.kernels.cell_components.link_sheets", cells, ...given, links) as number;
    if (n <= capacity) {
      const every = new Int32Array(2 * n + others.length);
      every.set(links.data.subarray(0, 2 * n));
      every.set(others, 2 * n);
      links.free();
      const all = NDArray.of(kernels, "i4", every, [every.length / 2, 2]);
      const graph = kernels.call("mesh.kernels.cell_components.gather_links", all, nSheets);
      for (const array of [...given, all]) array.free();
      return graph as [BigInt64Array, Int32Array];
    }
    links.free();
    capacity = n;
  }
}

/** Base vertices by cell and position in it: their order, the cells' runs, and their sheets. */
function sortVertices(
  kernels: Kernels, base: BaseSurface, cells: Cells,
): { order: Int32Array; starts: Int32Array; sheets: Int32Array } {
  const n = base.points.length;
  const rootOf = kernels.zeros("i4", n);
  const [roots, faces] = [rootOf.data, base.faces.data];
  for (let c = 0; c < 3; c++) for (let t = 0; t < base.faces.length; t++) roots[faces[3 * t + c]] = t;
  const [found, sheets] = [kernels.zeros("i4", n), kernels.zeros("i4", n)];
  kernels.call("mesh.kernels.cell_components.locate_vertices", base.points, rootOf, cells, found, sheets);
  const step = cells.cell_size / BLOCK_STEPS;
  const [points, origin] = [base.points.data, (cells.origin as NDArray<"f8">).data];
  const [low, high] = [new Uint32Array(n), new Uint32Array(n)];
  const cellOf = found.data;
  for (let v = 0; v < n; v++) {
    const at = [0, 1, 2].map((c) => Math.trunc((points[3 * v + c] - origin[c]) / step) % BLOCK_STEPS);
    const key = cellOf[v] * BLOCK_STEPS ** 3 + interleaved(at[0], at[1], at[2], 4);
    low[v] = key % 4294967296;
    high[v] = Math.floor(key / 4294967296);
  }
  const order = stableOrder(low, high);
  const nCells = cells.cell_place.length;
  const starts = new Int32Array(nCells + 1);
  for (const c of cellOf) starts[c + 1]++;
  for (let c = 0; c < nCells; c++) starts[c + 1] += starts[c];
  const sheetOf = sheets.data;
  const sorted = order.map((v) => sheetOf[v]);
  for (const array of [rootOf, found, sheets]) array.free();
  return { order, starts, sheets: sorted };
}

/** Every cell's run of vertices in blocks, each with a bounding ball. */
function blocks(
  points: Float32Array, order: Int32Array, starts: Int32Array,
): { cellBlocks: Int32Array; balls: Float32Array } {
  const f = Math.fround;
  const nCells = starts.length - 1;
  const cellBlocks = new Int32Array(nCells + 1);
  const balls: number[] = [];
  for (let cell = 0; cell < nCells; cell++) {
    for (let first = starts[cell]; first < starts[cell + 1]; first += BLOCK_VERTICES) {
      const last = Math.min(first + BLOCK_VERTICES, starts[cell + 1]);
      const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
      for (let k = first; k < last; k++)
        for (let c = 0; c < 3; c++) {
          const x = points[3 * order[k] + c];
          low[c] = Math.min(low[c], x);
          high[c] = Math.max(high[c], x);
        }
      const centre = low.map((x, c) => f(0.5 * (x + high[c])));
      let reach = 0.0;
      for (let k = first; k < last; k++) {
        const [x, y, z] = centre.map((m, c) => f(points[3 * order[k] + c] - m));
        reach = Math.max(reach, f(Math.sqrt(f(f(f(x * x) + f(y * y)) + f(z * z)))));
      }
      // slightly larger, since rounding must not leave a vertex out
      balls.push(...centre, f(f(1.0001) * reach));
    }
    cellBlocks[cell + 1] = balls.length / 4;
  }
  const n = balls.length / 4;
  const rows = Float32Array.from(balls, (_, k) => balls[4 * (k % n) + Math.floor(k / n)]);
  return { cellBlocks, balls: rows };
}

// ---- Trees of boxes, and light -------------------------------------------------------------------

/** The triangles' order in a tree of boxes, and their vertices in it. */
function boxTree(
  kernels: Kernels, points: Float32Array, faces: Int32Array, leafSize: number, halves: boolean,
): { order: Int32Array; triangles: Int32Array } {
  const f = Math.fround;
  const n = faces.length / 3;
  const centres = new Float32Array(3 * n);
  for (let t = 0; t < n; t++)
    for (let c = 0; c < 3; c++)
      centres[3 * t + c] =
        f(f(points[3 * faces[3 * t] + c] + points[3 * faces[3 * t + 1] + c]) + points[3 * faces[3 * t + 2] + c]);
  const [low, high] = boundsOf(centres);
  const span = Math.max(...high.map((h, c) => f(h - low[c])), 1e-12);
  const scale = f(1023.0 / span);
  const grid = (k: number, c: number): number => Math.trunc(f(f(centres[k + c] - low[c]) * scale));
  let order = stableOrder(
    Uint32Array.from({ length: n }, (_, t) => interleaved(grid(3 * t, 0), grid(3 * t, 1), grid(3 * t, 2), 10)),
  );
  if (halves) {
    let leaves = 1;
    while (leaves * leafSize < n) leaves *= 2;
    const sorted = new Float32Array(3 * n);
    order.forEach((t, k) => sorted.set(centres.subarray(3 * t, 3 * t + 3), 3 * k));
    const [rows, ids] = [NDArray.of(kernels, "f4", sorted, [n, 3]), NDArray.of(kernels, "i4", order)];
    kernels.call("mesh.kernels.bvh.order_by_halving", rows, leaves, leafSize, ids);
    order = ids.data.slice();
    rows.free();
    ids.free();
  }
  const triangles = new Int32Array(3 * n);
  order.forEach((t, k) => triangles.set(faces.subarray(3 * t, 3 * t + 3), 3 * k));
  return { order, triangles };
}

/** How much of the sky each vertex sees, 0 to 1: by fewer rays where there are many vertices. */
function openness(
  kernels: Kernels, arrays: Record<string, Table>, leafSize: number, points: Float32Array,
  normals: Float32Array, progress: (share: number) => void,
): Float64Array {
  const n = points.length / 3;
  const { order, triangles, points: places, normals: own } = Object.fromEntries(
    ["order", "triangles", "points", "normals"].map((name) => {
      const { kind, shape, values } = arrays[`closest.${name}`];
      return [name, NDArray.of(kernels, kind, values, shape)];
    }),
  );
  let leaves = 1;
  while (leaves * leafSize < triangles.length) leaves *= 2;
  const boxes = kernels.zeros("f4", 2 * leaves, 6);
  kernels.call("mesh.kernels.bvh.build_boxes", triangles, places, boxes, leafSize);
  const tree = { order, boxes, triangles, points: places, normals: own };
  const rays = Math.min(USUAL_RAYS, Math.max(FEWEST_RAYS, Math.floor(MOST_RAYS / n)));
  const [asked, far] = [kernels.zeros("f8", n, 6), kernels.zeros("f8", n)];
  const hit = kernels.zeros("i8", n);
  const seen = new Float64Array(n);
  const [aside, ahead] = [new Float64Array(3 * n), new Float64Array(3 * n)];
  for (let k = 0; k < 3 * n; k += 3) {
    const v = [normals[k], normals[k + 1], normals[k + 2]];
    const size = v.map(Math.abs);
    const least = size.indexOf(Math.min(...size));
    const u = [0, 1, 2].map((c) => {
      const [i, j] = [(c + 1) % 3, (c + 2) % 3];
      return v[i] * Number(j === least) - v[j] * Number(i === least);
    });
    const length = Math.hypot(...u) || 1.0;
    for (let c = 0; c < 3; c++) aside[k + c] = u[c] / length;
    for (let c = 0; c < 3; c++) {
      const [i, j] = [(c + 1) % 3, (c + 2) % 3];
      ahead[k + c] = v[i] * aside[k + j] - v[j] * aside[k + i];
    }
  }
  for (let r = 0; r < rays; r++) {
    // about the normal, denser near it, as its light counts (Malley's method)
    const [share, turn] = [(r + 0.5) / rays, GOLDEN_ANGLE * r];
    const [a, h] = [Math.sqrt(share) * Math.cos(turn), Math.sqrt(share) * Math.sin(turn)];
    const u = Math.sqrt(1.0 - share);
    const rows = asked.data;
    for (let v = 0; v < n; v++)
      for (let c = 0; c < 3; c++) {
        const k = 3 * v + c;
        rows[6 * v + c] = points[k] + LIFTED_MM * normals[k];
        rows[6 * v + 3 + c] = a * aside[k] + h * ahead[k] + u * normals[k];
      }
    kernels.call("mesh.kernels.bvh.find_hits", tree, asked, far, hit);
    const distances = far.data;
    for (let v = 0; v < n; v++) if (!Number.isFinite(distances[v])) seen[v] += 1.0;
    progress((r + 1) / rays);
  }
  for (const array of [...Object.values(tree), asked, far, hit]) array.free();
  return seen.map((count) => count / rays);
}

/** Means over neighbours, a few times, 0 to 255: without the grain of the rays. */
function smoothed(values: Float64Array, faces: Int32Array): Uint8Array {
  for (let pass = 0; pass < SMOOTHINGS; pass++) {
    const [sums, counts] = [values.slice(), new Float64Array(values.length).fill(1.0)];
    for (let k = 0; k < faces.length; k += 3) {
      const mean = (values[faces[k]] + values[faces[k + 1]] + values[faces[k + 2]]) / 3.0;
      for (let c = 0; c < 3; c++) {
        sums[faces[k + c]] += mean;
        counts[faces[k + c]] += 1.0;
      }
    }
    values = sums.map((sum, k) => sum / counts[k]);
  }
  return Uint8Array.from(values, (value) => Math.round(255.0 * value));
}
