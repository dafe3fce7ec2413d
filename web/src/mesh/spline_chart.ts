/**
 * A sheet of paper laid on a surface, to the bit `SurfaceChart` and `unroll` of `paint3d/mesh/chart.py`,
 * which says what each step is for.
 */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { dot, lengthOf, minus, plus, times } from "../core/vectors";
import type { Vector } from "../core/quaternion";
import type { Frame } from "./chart";
import type { ClosestPoints } from "./closest_points";

const DEGREE = 3;
const STEP_MM = 0.5;
const FINEST_STEP = 1e-3;
const LEAST_ADVANCE = 0.6;
const MOST_NODES = 400;
const PROBES = 5;
const FARTHEST_SIZES = 8.0;
const GUESSES = 65; // along each side of the grid that gives the first guess
const ROUNDS = 4;
const DIFFERENCE = 1e-3;
const AROUND = [-1, 0, 1];

export type Pair = readonly [number, number];

/** The surface ends, or is too small, where a sheet was to lie. */
export class NoRoomError extends Error {
  override name = "NoRoomError";
}

/** Even numbers from one to another, as NumPy's `linspace`. */
export function linspace(low: number, high: number, n: number): Float64Array {
  const step = (high - low) / (n - 1);
  return Float64Array.from({ length: n }, (_, k) => (k === n - 1 ? high : k * step + low));
}

/** Places (N, 2) of a grid, the first coordinate outermost. */
export function gridOf(xs: Float64Array, ys: Float64Array): Float64Array {
  const places = new Float64Array(2 * xs.length * ys.length);
  let at = 0;
  for (const x of xs)
    for (const y of ys) {
      places[at++] = x;
      places[at++] = y;
    }
  return places;
}

/** Three functions of (x, y), each a bicubic spline through its values at the nodes of a grid. */
class SplineMap {
  readonly #knots: readonly [NDArray<"f8">, NDArray<"f8">];
  readonly #coefficients: NDArray<"f8">;

  constructor(
    private readonly kernels: Kernels,
    xs: Float64Array,
    ys: Float64Array,
    values: Float64Array, // (A, B, 3)
  ) {
    const [a, b] = [xs.length, ys.length];
    const knots = (nodes: Float64Array): NDArray<"f8"> =>
      NDArray.of(kernels, "f8", [
        ...new Array<number>(DEGREE + 1).fill(nodes[0]), ...nodes.subarray(2, -2),
        ...new Array<number>(DEGREE + 1).fill(nodes[nodes.length - 1]),
      ]); // prettier-ignore
    this.#knots = [knots(xs), knots(ys)];
    const eliminate = (nodes: Float64Array, at: NDArray<"f8">, rows: NDArray<"f8">): NDArray<"f8"> => {
      const places = NDArray.of(kernels, "f8", nodes);
      const triangle = kernels.call("mesh.kernels.tensor_spline.eliminate_spline", places, at, rows) as Float64Array;
      places.free();
      return NDArray.of(kernels, "f8", triangle, [nodes.length, triangle.length / nodes.length]);
    };
    const solve = (triangle: NDArray<"f8">, rows: NDArray<"f8">): Float64Array => {
      kernels.call("mesh.kernels.tensor_spline.solve_spline", triangle, rows);
      const solved = rows.data.slice();
      rows.free();
      triangle.free();
      return solved;
    };
    const alongX = NDArray.of(kernels, "f8", values, [a, 3 * b]);
    const triangle = eliminate(xs, this.#knots[0], alongX);
    const alongY = NDArray.of(kernels, "f8", swapped(alongX.data, a, b), [b, 3 * a]);
    alongX.free();
    const solved = solve(eliminate(ys, this.#knots[1], alongY), alongY);
    const both = solve(triangle, NDArray.of(kernels, "f8", swapped(solved, b, a), [a, 3 * b]));
    this.#coefficients = NDArray.of(kernels, "f8", both, [a, b, 3]);
  }

  /** Values (N, 3) at places (N, 2). */
  at(xy: Float64Array): Float64Array {
    const n = xy.length / 2;
    const [given, out] = [NDArray.of(this.kernels, "f8", xy, [n, 2]), this.kernels.zeros("f8", n, 3)];
    this.kernels.call(
      "mesh.kernels.tensor_spline.evaluate_splines",
      ...this.#knots, [DEGREE, DEGREE], this.#coefficients, given, out,
    ); // prettier-ignore
    const values = out.data.slice();
    given.free();
    out.free();
    return values;
  }

  free(): void {
    for (const array of [...this.#knots, this.#coefficients]) array.free();
  }
}

/** Values (A, B, 3) with the first two axes swapped. */
function swapped(values: Float64Array, a: number, b: number): Float64Array {
  const to = new Float64Array(values.length);
  for (let i = 0; i < a; i++)
    for (let j = 0; j < b; j++) for (let f = 0; f < 3; f++) to[3 * (j * a + i) + f] = values[3 * (i * b + j) + f];
  return to;
}

/** A smooth map from a rectangle, mm around a frame, onto a surface. */
export class SplineChart {
  readonly #points: SplineMap;
  readonly #normals: SplineMap;

  /** Lay it, its nodes `spacing` mm apart; `size` is the object's, mm. */
  constructor(
    kernels: Kernels,
    surface: ClosestPoints,
    readonly frame: Frame,
    readonly half: Pair,
    spacing: number,
    size: number,
  ) {
    const reach = Math.sqrt(half[0] * half[0] + half[1] * half[1]);
    if (reach > FARTHEST_SIZES * size) throw new NoRoomError(`the object is ${size.toFixed(0)} mm in size`);
    const nodes = (one: number): Float64Array => {
      const n = Math.min(Math.max(2, Math.ceil(one / spacing)), MOST_NODES / 2);
      return linspace(-one, one, 2 * n + 1);
    };
    const [xs, ys] = [nodes(half[0]), nodes(half[1])];
    // the rim first: where the surface ends within the rectangle, a few geodesics show it
    const along = linspace(-1.0, 1.0, PROBES);
    const rim: number[] = [];
    for (const x of along)
      for (const y of along) if (Math.max(Math.abs(x), Math.abs(y)) === 1.0) rim.push(half[0] * x, half[1] * y);
    trace(surface, frame, Float64Array.from(rim));
    const [points, normals] = trace(surface, frame, gridOf(xs, ys));
    this.#points = new SplineMap(kernels, xs, ys, points);
    this.#normals = new SplineMap(kernels, xs, ys, normals);
  }

  /** Points (N, 3) of the surface at places (N, 2), mm. */
  points(xy: Float64Array): Float64Array {
    return this.#points.at(xy);
  }

  /** Outward unit normals (N, 3). */
  normals(xy: Float64Array): Float64Array {
    const found = this.#normals.at(xy);
    for (let k = 0; k < found.length; k += 3) {
      const length = Math.sqrt(found[k] * found[k] + found[k + 1] * found[k + 1] + found[k + 2] * found[k + 2]);
      for (let f = k; f < k + 3; f++) found[f] /= length > 0.0 ? length : 1.0;
    }
    return found;
  }

  /** Places (N, 2), mm, of points (N, 3) on the surface; NaN outside the chart. */
  unroll(points: Float64Array): Float64Array {
    const { half } = this;
    const nodes = gridOf(linspace(-half[0], half[0], GUESSES), linspace(-half[1], half[1], GUESSES));
    const there = this.points(nodes);
    const step = (2.0 * Math.max(...half)) / (GUESSES - 1);
    let stretch = 0.0;
    for (let k = 3 * GUESSES; k < there.length; k += 3) stretch = Math.max(stretch, distance(there, k, there, k - 3 * GUESSES));
    const bound = 2.0 * Math.max(step, stretch);
    const n = points.length / 3;
    const flat = new Float64Array(2 * n).fill(NaN);
    const near: number[] = [];
    const boxes = new Map<string, number[]>(); // of the nodes, as wide as they may be away
    const boxOf = (of: Float64Array, k: number): number[] => [0, 1, 2].map((axis) => Math.floor(of[k + axis] / bound));
    for (let k = 0; k < there.length / 3; k++) {
      const box = boxOf(there, 3 * k).join();
      boxes.set(box, [...(boxes.get(box) ?? []), k]);
    }
    for (let i = 0; i < n; i++) {
      let [least, best] = [bound, -1];
      const [x, y, z] = boxOf(points, 3 * i);
      for (const dx of AROUND)
        for (const dy of AROUND)
          for (const dz of AROUND)
            for (const k of boxes.get(`${x + dx},${y + dy},${z + dz}`) ?? []) {
              const apart = distance(there, 3 * k, points, 3 * i);
              if (apart < least || (apart === least && k < best)) [least, best] = [apart, k]; // of several the first
            }
      if (best < 0) continue;
      near.push(i);
      flat[2 * i] = nodes[2 * best];
      flat[2 * i + 1] = nodes[2 * best + 1];
    }
    let at: Float64Array = Float64Array.from(near.flatMap((i) => [flat[2 * i], flat[2 * i + 1]]));
    const wanted = Float64Array.from(near.flatMap((i) => [...points.subarray(3 * i, 3 * i + 3)]));
    const beyond = new Uint8Array(near.length);
    for (let round = 0; round < ROUNDS; round++) {
      const by = this.#newtonStep(at, wanted);
      const moved = at.map((value, k) => value + by[k]);
      at = moved.map((value, k) => Math.min(Math.max(value, -half[k % 2]), half[k % 2]));
      for (let i = 0; i < near.length; i++)
        beyond[i] = Number([2 * i, 2 * i + 1].some((k) => Math.abs(moved[k] - at[k]) > 0.01 * step));
    }
    for (const [k, i] of near.entries()) {
      flat[2 * i] = beyond[k] === 1 ? NaN : at[2 * k];
      flat[2 * i + 1] = beyond[k] === 1 ? NaN : at[2 * k + 1];
    }
    return flat;
  }

  /** The least-squares steps (N, 2) in the chart towards points (N, 3). */
  #newtonStep(at: Float64Array, wanted: Float64Array): Float64Array {
    const { half } = this;
    const here = this.points(at);
    const columns = [0, 1].map((axis) => {
      const by = DIFFERENCE * half[axis];
      const high = at.map((value, k) => Math.min(k % 2 === axis ? value + by : value, half[k % 2]));
      const low = at.map((value, k) => Math.max(k % 2 === axis ? value - by : value, -half[k % 2]));
      const [above, below] = [this.points(high), this.points(low)];
      return above.map((value, k) => {
        const place = 2 * Math.floor(k / 3) + axis;
        return (value - below[k]) / (high[place] - low[place]);
      });
    });
    const steps = new Float64Array(at.length);
    for (let i = 0; i < at.length / 2; i++) {
      const row = (of: Float64Array): Vector => [of[3 * i], of[3 * i + 1], of[3 * i + 2]];
      const [x, y, away] = [row(columns[0]), row(columns[1]), minus(row(wanted), row(here))];
      const [xx, xy, yy, bx, by] = [dot(x, x), dot(x, y), dot(y, y), dot(x, away), dot(y, away)];
      const determinant = xx * yy - xy * xy;
      steps[2 * i] = (yy * bx - xy * by) / determinant;
      steps[2 * i + 1] = (xx * by - xy * bx) / determinant;
    }
    return steps;
  }

  free(): void {
    this.#points.free();
    this.#normals.free();
  }
}

function distance(one: Float64Array, i: number, two: Float64Array, k: number): number {
  const [x, y, z] = [one[i] - two[k], one[i + 1] - two[k + 1], one[i + 2] - two[k + 2]];
  return Math.sqrt(x * x + y * y + z * z);
}

/** Ends of geodesics from a frame to places (N, 2), and the normals there, (N, 3) each. */
function trace(surface: ClosestPoints, frame: Frame, xy: Float64Array): [Float64Array, Float64Array] {
  const n = xy.length / 2;
  const reach = Float64Array.from({ length: n }, (_, i) => Math.sqrt(xy[2 * i] * xy[2 * i] + xy[2 * i + 1] * xy[2 * i + 1]));
  const nSteps = Math.max(1, Math.ceil(reach.reduce((most, one) => Math.max(most, one), 0.0) / STEP_MM));
  const ways = Array.from(reach, (one, i) => {
    const safe = one > 0.0 ? one : 1.0;
    const [x, y] = [times(frame.ahead, xy[2 * i]), times(frame.up, xy[2 * i + 1])];
    const heading = plus(x, y).map((value) => value / safe) as unknown as Vector;
    return { point: frame.point, normal: frame.normal, heading, step: one / nSteps };
  });
  const wanted = new Float64Array(3 * n);
  for (let k = 0; k < nSteps; k++) {
    for (const [i, { point, heading, step }] of ways.entries()) wanted.set(plus(point, times(heading, step)), 3 * i);
    for (const [i, found] of surface.findAll(wanted).entries()) {
      const way = ways[i];
      const advance = dot(minus(found.point, way.point), way.heading);
      const turned = dot(found.normal, way.normal); // cosine between the two normals
      if (advance < LEAST_ADVANCE * way.step - FINEST_STEP || turned <= 0.0)
        throw new NoRoomError(`the surface ends ${(way.step * k).toFixed(1)} mm from the middle`);
      const ratio = dot(way.heading, found.normal) / (1.0 + turned);
      const carried = minus(way.heading, times(plus(way.normal, found.normal), ratio));
      const inPlane = minus(carried, times(found.normal, dot(carried, found.normal)));
      const length = lengthOf(inPlane);
      const heading = inPlane.map((value) => value / (length > 0.0 ? length : 1.0)) as unknown as Vector;
      ways[i] = { ...found, heading, step: way.step };
    }
  }
  const flat = (name: "point" | "normal"): Float64Array => Float64Array.from(ways.flatMap((way) => [...way[name]]));
  return [flat("point"), flat("normal")];
}
