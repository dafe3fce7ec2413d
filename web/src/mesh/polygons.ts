/** Polygons to triangles: fans, and ear clipping where a corner points inwards: `paint3d/mesh/polygons.py`. */

import { MeshError } from "../files/mesh_error";

const MOST_CORNERS = 100_000;
const MOST_CONCAVE_CORNERS = 5_000;
const MOST_EAR_TESTS = 100_000;
const MOST_FORCED_CUTS = 10; // where an outline crosses itself
const SAME_AREA = 1e-6;
const ROUNDING = 1e-12;

type Point = readonly [number, number, number];
type Flat = readonly [number, number];

const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a: Point, b: Point): Point =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; // prettier-ignore
const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** The triangles of polygons, in their order and with their orientation; those of fewer than three corners go. */
export function triangulate(vertices: Float64Array, corners: Float64Array, sizes: Int32Array): Float64Array {
  const most = sizes.reduce((a, b) => Math.max(a, b), 0);
  if (most > MOST_CORNERS)
    throw new MeshError("face {which} has {sizes:,} corners; expected at most {most:,}", {
      which: sizes.indexOf(most), sizes: most, most: MOST_CORNERS,
    }); // prettier-ignore
  if (sizes.every((size) => size === 3)) return corners;
  const faces = new Float64Array(3 * sizes.reduce((n, size) => n + Math.max(size - 2, 0), 0));
  let [at, to] = [0, 0];
  for (const size of sizes) {
    const polygon = Array.from(corners.subarray(at, at + size));
    at += size;
    if (size < 3) continue;
    let cut = fanOf(polygon);
    if (size > 3) {
      const points = polygon.map((v): Point => [vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]]);
      if (isConcave(points)) {
        const local = polygon.map((_, k) => k);
        const [fan, ears] = [fanOf(local), clipEars(points)];
        cut = (areaOf(points, fan) < (1.0 - SAME_AREA) * areaOf(points, ears) ? fan : ears).map((k) => polygon[k]);
      }
    }
    faces.set(cut, to);
    to += cut.length;
  }
  return faces;
}

function fanOf(ids: readonly number[]): number[] {
  const faces: number[] = [];
  for (let k = 1; k + 1 < ids.length; k++) faces.push(ids[0], ids[k], ids[k + 1]);
  return faces;
}

function areaOf(points: Point[], faces: number[]): number {
  let sum = 0.0;
  for (let k = 0; k < faces.length; k += 3) {
    const [a, b, c] = [points[faces[k]], points[faces[k + 1]], points[faces[k + 2]]];
    const v = cross(minus(b, a), minus(c, a));
    sum += Math.sqrt(dot(v, v));
  }
  return sum;
}

/** The sum of the cross products of corners that follow one another. */
function newellOf(points: Point[]): Point {
  return points.reduce<Point>((sum, p, k) => {
    const v = cross(p, points[(k + 1) % points.length]);
    return [sum[0] + v[0], sum[1] + v[1], sum[2] + v[2]];
  }, [0, 0, 0]);
}

function isConcave(corners: Point[]): boolean {
  const n = corners.length;
  const points = corners.map((p) => minus(p, corners[0]));
  const newell = newellOf(points);
  const tolerance = 1e-9 * dot(newell, newell);
  return points.some((p, k) => {
    const turn = cross(minus(p, points[(k + n - 1) % n]), minus(points[(k + 1) % n], p));
    return dot(turn, newell) < -tolerance;
  });
}

/** The triangles of one polygon, by the numbers of its corners. */
function clipEars(points: Point[]): number[] {
  const total = points.length;
  if (total > MOST_CONCAVE_CORNERS)
    throw new MeshError("a face with inward corners has {n:,} of them; expected at most {most:,}", {
      n: total, most: MOST_CONCAVE_CORNERS,
    }); // prettier-ignore
  const flat = flattened(points);
  const spans = [0, 1].map((c) => Math.max(...flat.map((p) => p[c])) - Math.min(...flat.map((p) => p[c])));
  const rounding = ROUNDING * Math.max(...spans) ** 2;
  const left = points.map((_, k) => k);
  const faces: number[] = [];
  let [at, misses, tests, forced] = [0, 0, 0, 0];
  while (left.length > 3 && forced <= MOST_FORCED_CUTS) {
    const n = left.length;
    const trio = [left[(at + n - 1) % n], left[at % n], left[(at + 1) % n]];
    tests++;
    if (tests > MOST_EAR_TESTS)
      throw new MeshError(
        "a face with {n:,} corners is too tangled to be cut into triangles; expected a simpler outline",
        { n: total },
      );
    const near = misses <= n ? rounding : -rounding; // in a second round what nearly touches passes
    const isCrossing = misses > 2 * n; // such outlines have no ear: cut anyway
    if (isCrossing || isEar(flat, trio, left, near)) {
      forced += Number(isCrossing);
      faces.push(...trio);
      left.splice(at % n, 1);
      at %= n - 1;
      misses = 0;
    } else {
      at = (at + 1) % n;
      misses++;
    }
  }
  return [...faces, ...fanOf(left)];
}

/** The corners as seen along the Newell normal, counter-clockwise. */
function flattened(corners: Point[]): Flat[] {
  const sums = corners.reduce<Point>((s, p) => [s[0] + p[0], s[1] + p[1], s[2] + p[2]], [0, 0, 0]);
  const middle: Point = [sums[0] / corners.length, sums[1] / corners.length, sums[2] / corners.length];
  const points = corners.map((p) => minus(p, middle));
  const newell = newellOf(points);
  const sizes = newell.map(Math.abs);
  const drop = sizes.indexOf(Math.max(...sizes));
  const axes = [(drop + 1) % 3, (drop + 2) % 3];
  if (newell[drop] < 0.0) axes.reverse();
  const lean = axes.map((axis) => (newell[drop] !== 0.0 ? newell[axis] / newell[drop] : 0.0));
  return points.map((p): Flat => [p[axes[0]] - p[drop] * lean[0], p[axes[1]] - p[drop] * lean[1]]);
}

/** Whether the line that cuts off three consecutive corners stays inside the polygon. */
function isEar(flat: Flat[], trio: number[], left: number[], near: number): boolean {
  const [a, b, c] = trio.map((k) => flat[k]);
  const side = (p: Flat, q: Flat, r: Flat): number => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  if ((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) <= Math.max(near, 0.0)) return false;
  return left.every((k) => {
    const p = flat[k];
    if (!(side(a, b, p) >= -near && side(b, c, p) >= -near && side(c, a, p) >= -near)) return true;
    return [a, b, c].some((q) => q[0] === p[0] && q[1] === p[1]); // in the way, unless it is one of the three
  });
}
