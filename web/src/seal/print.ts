/**
 * What a seal leaves on a surface, to the bit `find_impression` and `lay_paste` of
 * `paint3d/calligraphy/seal`, which say what each step is for.
 */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { dot, minus } from "../core/vectors";
import type { Vector } from "../core/quaternion";
import type { Frame } from "../mesh/chart";
import type { ClosestPoints } from "../mesh/closest_points";
import { gridOf, linspace, NoRoomError, SplineChart, type Pair } from "../mesh/spline_chart";
import type { PaintedSurface } from "../surface/painted_surface";
import { clip, evenExp } from "../surface/pores";

const NODES = 32.0;
const MARGIN_MM = 0.3;
const SAME_SIDE = 0.3;
const OFF_MM = 0.6;
const SOFT_MM = 0.035;
const [RIDGE_MM, RIDGE] = [0.16, 0.3];
const [PATCHY, CELL_MM] = [0.22, 1.3];
const [GRAINY, GRAIN_MM] = [0.16, 0.22];
const BARE = 1.35;
const [ROUGH_MM, RAGGED_MM] = [0.7, 0.035];
const [CHIP_MM, CHIP_FROM] = [2.6, 0.45];
const FIRM = 0.35;
const EDGE = 0.5;
const LEAST_TOUCHED = 0.02;
const ACROSS = 80.0;
const FINEST_MM = 0.05;

/** How a seal is pressed; `Pressing` of Python. */
export interface Pressing {
  coats: number;
  pad_mm: number;
  wear: number;
  seed: number;
}
export const USUAL_PRESSING: Pressing = { coats: 1.3, pad_mm: 3.0, wear: 1.0, seed: 1 };

/** The surface falls away from a stone that it should meet. */
export class NoTouchError extends Error {
  override name = "NoTouchError";
}

/** Paste on vertices: thickness times the covered fraction, and that fraction. */
export interface Impression {
  ids: Int32Array;
  coats: Float32Array;
  share: Float32Array;
}

/** What a seal leaves; the surface is refined there, nothing is painted, and nothing done where this throws. */
export function findImpression(
  kernels: Kernels, surface: PaintedSurface, closest: ClosestPoints, frame: Frame,
  rings: readonly (readonly Pair[])[], pressing: Pressing,
): Impression {
  const half = [0, 1].map((axis) => {
    let most = 0.0;
    for (const ring of rings) for (const point of ring) most = Math.max(most, Math.abs(point[axis]));
    return most + MARGIN_MM;
  }) as unknown as Pair;
  const longer = Math.max(...half);
  const chart = new SplineChart(kernels, closest, frame, half, (2.0 * longer) / NODES, sizeOf(surface));
  try {
    const stone = new Stone(rings);
    const touched = touchedOf(chart, stone, pressing);
    if (touched < LEAST_TOUCHED) throw new NoTouchError(`${Math.round(100 * touched)} % would touch`);
    refine(kernels, surface, chart, Math.max(FINEST_MM, (2.0 * longer) / ACROSS));
    const { ids, xy } = verticesUnder(surface, chart);
    const firm = firmness(chart, xy, pressing.pad_mm);
    const { area_units: units, area_unit: unit } = surface.paintMesh.arrays;
    const areas = units.data;
    const kept: number[] = [];
    const [coats, share]: number[][] = [[], []]; // prettier-ignore
    for (let i = 0; i < ids.length; i++) {
      const [x, y] = [xy[2 * i], xy[2 * i + 1]];
      let inside = stone.within(x, y);
      inside -= pressing.wear * worn(x, y, half, pressing.seed);
      const soft = Math.max(EDGE * Math.sqrt(Number(areas[ids[i]]) * unit), SOFT_MM);
      const [slow, quick] = [noise(x, y, CELL_MM, pressing.seed + 4), noise(x, y, GRAIN_MM, pressing.seed + 5)];
      const bare = Math.max(0.9 * slow + 1.1 * quick - BARE * 0.62, 0.0) * 2.4;
      let thick = 1.0 + RIDGE * fading(Math.max(inside, 0.0) / RIDGE_MM) + (PATCHY * slow + GRAINY * quick);
      const covered =
        clip(0.5 + (0.5 * inside) / soft, 0.0, 1.0) * (clip(firm[i] / FIRM, 0.0, 1.0) * clip(1.0 - pressing.wear * bare, 0.0, 1.0));
      thick *= 0.55 + 0.45 * firm[i];
      if (covered <= 1e-3) continue;
      kept.push(ids[i]);
      coats.push(pressing.coats * Math.max(thick, 0.1) * covered);
      share.push(covered);
    }
    return { ids: Int32Array.from(kept), coats: Float32Array.from(coats), share: Float32Array.from(share) };
  } finally {
    chart.free();
  }
}

/** Lay what a seal leaves on the layer that is painted on; how much ink came. */
export function layPaste(surface: PaintedSurface, left: Impression, parts: Float32Array): number {
  const before = surface.wetInk() + surface.dryInk();
  surface.settle(left.ids);
  const [amounts, coverage] = [surface.ink.amounts.data, surface.ink.coverage.data];
  const count = parts.length;
  for (const [k, id] of left.ids.entries()) {
    for (let p = 0; p < count; p++) amounts[id * count + p] = left.coats[k] * parts[p];
    coverage[id] = left.share[k];
  }
  surface.settle(left.ids);
  return surface.wetInk() + surface.dryInk() - before;
}

// -- on the surface -----------------------------------------------------------------------------

function sizeOf(surface: PaintedSurface): number {
  const { arrays, nBaseVertices: n } = surface.paintMesh;
  const sides = [arrays.px, arrays.py, arrays.pz].map(({ data }) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < n; i++) [low, high] = [Math.min(low, data[i]), Math.max(high, data[i])];
    return high - low;
  });
  return Math.hypot(...sides);
}

/** How much of the stone would touch, as its own lattice says. */
function touchedOf(chart: SplineChart, stone: Stone, pressing: Pressing): number {
  const lattice = gridOf(...(chart.half.map((one) => linspace(-one, one, ACROSS + 1)) as [Float64Array, Float64Array]));
  const firm = firmness(chart, lattice, pressing.pad_mm);
  const soft = Math.max(EDGE * ((2.0 * Math.max(...chart.half)) / ACROSS), SOFT_MM);
  let [wanted, met] = [0.0, 0.0];
  for (let i = 0; i < firm.length; i++) {
    const share = clip(0.5 + (0.5 * stone.within(lattice[2 * i], lattice[2 * i + 1])) / soft, 0.0, 1.0);
    wanted += share;
    met += share * clip(firm[i] / FIRM, 0.0, 1.0);
  }
  return met / Math.max(wanted, 1e-9);
}

/** Refine the surface wherever the chart goes; around paint no finer than it is. */
function refine(kernels: Kernels, surface: PaintedSurface, chart: SplineChart, spacing: number): void {
  const { paintMesh } = surface;
  const { arrays: fields } = paintMesh;
  const array = <K extends "f8" | "i4" | "u1">(name: string): NDArray<K> => fields[name] as NDArray<K>;
  const size = fields.cell_size as number;
  const axes = chart.half.map((reach) => linspace(-reach, reach, Math.ceil((2.0 * reach) / (0.5 * size)) + 2));
  const grid = chart.points(gridOf(axes[0], axes[1]));
  const [places, origin] = [array<"i4">("cell_place").data, array<"f8">("origin").data];
  const within = (1.2 * size) ** 2;
  const cells: number[] = [];
  for (let cell = 0; cell < places.length / 3; cell++) {
    const [x, y, z] = [0, 1, 2].map((k) => origin[k] + (places[3 * cell + k] + 0.5) * size);
    for (let k = 0; k < grid.length; k += 3) {
      const [dx, dy, dz] = [grid[k] - x, grid[k + 1] - y, grid[k + 2] - z];
      if (!(dx * dx + dy * dy + dz * dz < within)) continue;
      cells.push(cell);
      break;
    }
  }
  const { resolution } = fields;
  const wanted = paintMesh.refines ? Math.min(spacing, resolution) : resolution;
  const inked = new Set<string>();
  const [sheetCell, vertexSheet] = [array<"i4">("sheet_cell").data, array<"i4">("vertex_sheet").data];
  for (const id of surface.paintedIds()) {
    const cell = sheetCell[vertexSheet[id]];
    inked.add(`${places[3 * cell]} ${places[3 * cell + 1]} ${places[3 * cell + 2]}`);
  }
  const around = [-1, 0, 1];
  const isNear = (cell: number): boolean =>
    around.some((i) => around.some((j) => around.some((k) =>
      inked.has(`${places[3 * cell] + i} ${places[3 * cell + 1] + j} ${places[3 * cell + 2] + k}`)))); // prettier-ignore
  const near = cells.map(isNear);
  const bare = cells.filter((_, k) => !near[k]);
  if (wanted < resolution) for (const cell of bare) array<"u1">("done").data[cell] = 0;
  for (const [those, edge] of [[cells.filter((_, k) => near[k]), resolution], [bare, wanted]] as const) {
    const given = NDArray.of(kernels, "i8", BigInt64Array.from(those, BigInt));
    for (let done = 0; done < those.length; ) {
      done = kernels.call(
        "surface.kernels.diffusion.activate_cells", { ...paintMesh.arrays, resolution: edge }, given, done,
      ) as number; // prettier-ignore
      if (done < those.length) surface.makeRoom();
    }
    given.free();
  }
}

/** Vertices on the chart's own sheet of surface, and where on it they are. */
function verticesUnder(surface: PaintedSurface, chart: SplineChart): { ids: number[]; xy: Float64Array } {
  const { px, py, pz, nx, ny, nz } = surface.paintMesh.arrays;
  const [x, y, z, u, v, w] = [px, py, pz, nx, ny, nz].map(({ data }) => data.slice()); // memory may move
  const { point } = chart.frame;
  const radius = Math.hypot(...chart.half) + 1.0;
  const ids: number[] = [];
  for (let id = 0; id < surface.nVertices; id++) {
    const away = minus([x[id], y[id], z[id]], point);
    if (Math.sqrt(dot(away, away)) <= radius) ids.push(id);
  }
  const places = chart.unroll(Float64Array.from(ids.flatMap((id) => [x[id], y[id], z[id]])));
  const known = ids.map((_, k) => k).filter((k) => Number.isFinite(places[2 * k]) && Number.isFinite(places[2 * k + 1]));
  const at = Float64Array.from(known.flatMap((k) => [places[2 * k], places[2 * k + 1]]));
  const [points, normals] = [chart.points(at), chart.normals(at)];
  const row = (of: Float64Array, i: number): Vector => [of[3 * i], of[3 * i + 1], of[3 * i + 2]];
  const kept = known.map((_, i) => i).filter((i) => {
    const id = ids[known[i]];
    const away = minus([x[id], y[id], z[id]], row(points, i));
    return dot([u[id], v[id], w[id]], row(normals, i)) > SAME_SIDE && Math.sqrt(dot(away, away)) < OFF_MM;
  }); // prettier-ignore
  return {
    ids: kept.map((i) => ids[known[i]]),
    xy: Float64Array.from(kept.flatMap((i) => [at[2 * i], at[2 * i + 1]])),
  };
}

/** Pressure of the stone, 0 to 1: less where the surface falls away from its plane. */
function firmness(chart: SplineChart, xy: Float64Array, padMm: number): Float64Array {
  const points = chart.points(xy);
  const { point, normal } = chart.frame;
  return Float64Array.from({ length: xy.length / 2 }, (_, i) => {
    const away = minus([points[3 * i], points[3 * i + 1], points[3 * i + 2]], point);
    return clip(1.0 - Math.abs(dot(away, normal)) / padMm, 0.0, 1.0);
  });
}

// -- on the stone -------------------------------------------------------------------------------

/** What takes paste, by the even-odd rule of rings that do not meet. */
class Stone {
  readonly #edges: Float64Array; // ends, four numbers each, the lesser first

  constructor(rings: readonly (readonly Pair[])[]) {
    this.#edges = Float64Array.from(
      rings.flatMap((ring) =>
        ring.flatMap((one, k) => {
          const other = ring[(k + 1) % ring.length];
          return one[0] < other[0] || (one[0] === other[0] && one[1] <= other[1]) ? [...one, ...other] : [...other, ...one];
        }),
      ),
    );
  }

  /** How far within a place is, mm; negative outside. */
  within(x: number, y: number): number {
    const edges = this.#edges;
    let least = Infinity;
    let isInside = false;
    for (let k = 0; k < edges.length; k += 4) {
      const [ax, ay, bx, by] = [edges[k], edges[k + 1], edges[k + 2], edges[k + 3]];
      if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) isInside = !isInside;
      least = Math.min(least, awayFrom(ax, ay, bx, by, x, y));
    }
    return isInside ? least : -least;
  }
}

function awayFrom(ax: number, ay: number, bx: number, by: number, x: number, y: number): number {
  const [dx, dy, ux, uy] = [bx - ax, by - ay, x - ax, y - ay];
  const share = clip((ux * dx + uy * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  const [offX, offY] = [ux - share * dx, uy - share * dy];
  return Math.sqrt(offX * offX + offY * offY);
}

/** e to the power of -x. */
function fading(x: number): number {
  return evenExp(-Math.min(x, 700.0));
}

/** Wear, mm, of what was cut: little everywhere, more along the rim. */
function worn(x: number, y: number, half: Pair, seed: number): number {
  const ragged = RAGGED_MM * (noise(x, y, ROUGH_MM, seed) + 0.7 * noise(x, y, 0.3, seed + 1));
  const [fromX, fromY] = [half[0] - MARGIN_MM - Math.abs(x), half[1] - MARGIN_MM - Math.abs(y)];
  const knocked = Math.max(noise(x, y, CHIP_MM, seed + 2) - CHIP_FROM, 0.0);
  const corner = fading(Math.max(Math.abs(fromX), Math.abs(fromY)) / 1.2);
  const depth = knocked * 1.6 * fading(Math.max(Math.min(fromX, fromY), 0.0) / 0.5);
  return ragged + depth + 0.18 * corner * (1.0 + noise(x, y, ROUGH_MM, seed + 3));
}

/** Smooth noise from -1 to 1: values on a lattice, between them cubics without slope. */
function noise(x: number, y: number, cellMm: number, seed: number): number {
  const [u, v] = [x / cellMm, y / cellMm];
  const [i, j] = [Math.floor(u), Math.floor(v)];
  const eased = (share: number): number => share * share * (3.0 - 2.0 * share);
  const [s, t] = [eased(u - i), eased(v - j)];
  const [a, b, c, d] = [scattered(i, j, seed), scattered(i, j + 1, seed), scattered(i + 1, j, seed), scattered(i + 1, j + 1, seed)];
  const [low, high] = [a + t * (b - a), c + t * (d - c)];
  return low + s * (high - low);
}

const SCATTERED = new Map<number, Map<number, number>>(); // by seeds, and places of the lattice
const MOST_KNOWN = 1 << 20;

/** A number from -1 to 1 for each place of a lattice (splitmix64's finaliser). */
function scattered(i: number, j: number, seed: number): number {
  let known = SCATTERED.get(seed);
  if (known === undefined || known.size > MOST_KNOWN) SCATTERED.set(seed, (known = new Map()));
  const place = (i + 0x8000) * 0x10000 + (j + 0x8000);
  let value = known.get(place);
  if (value === undefined) {
    const wrapped = (n: bigint): bigint => BigInt.asUintN(64, n);
    let n = wrapped(BigInt(i) << 32n) ^ BigInt.asUintN(32, BigInt(j));
    n = wrapped(n + 0x9e3779b97f4a7c15n * BigInt(seed + 1));
    n = wrapped((n ^ (n >> 30n)) * 0xbf58476d1ce4e5b9n);
    n = wrapped((n ^ (n >> 27n)) * 0x94d049bb133111ebn);
    n ^= n >> 31n;
    value = Number(n >> 11n) * 2.0 ** -52 - 1.0;
    known.set(place, value);
  }
  return value;
}

export { NoRoomError };
