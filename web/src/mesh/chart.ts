/** A piece of the surface unrolled around a place, for what lies on it: millimetres to points. */

import type { Vector } from "../core/quaternion";
import { cross, dot, lengthOf, minus, plus, times, turned, unit } from "../core/vectors";
import type { ClosestPoints, Found } from "./closest_points";

const MOST_OFF = 0.5; // steps that a node may lie off the way to it: beyond, the surface has ended
const NEARLY_FLAT = 0.9; // of a normal's z: from there on +y is up, not +z

/** Axes at a place of the surface; `ahead` is to the right, `up` upwards. */
export interface Frame extends Found {
  ahead: Vector;
  up: Vector;
}

/** The frame at a place whose up is turned to the left by so many degrees. */
export function frameAt({ point, normal }: Found, turn: number): Frame {
  const upwards: Vector = Math.abs(normal[2]) < NEARLY_FLAT ? [0.0, 0.0, 1.0] : [0.0, 1.0, 0.0];
  const level = unit(minus(upwards, times(normal, dot(upwards, normal))));
  const up = turned(level, normal, (turn * Math.PI) / 180.0);
  return { point, normal, up, ahead: cross(up, normal) };
}

/** The frame at a place whose up is as near a direction as can be: `frame_at` of Python. */
export function frameUp({ point, normal }: Found, wanted: Vector): Frame {
  const tangent = minus(wanted, times(normal, dot(wanted, normal)));
  const length = lengthOf(tangent);
  const up = tangent.map((value) => value / length) as unknown as Vector;
  return { point, normal, up, ahead: cross(up, normal) };
}

export class Chart {
  readonly #nodes: (Frame | null)[][];
  readonly #reach: [number, number];

  /** Walk `half` mm to each side of a frame, by steps: up and down its middle, and from there aside. */
  constructor(
    private readonly surface: ClosestPoints,
    middle: Frame,
    half: readonly [number, number],
    private readonly step: number,
  ) {
    this.#reach = [Math.ceil(half[0] / step), Math.ceil(half[1] / step)];
    const column = this.#line(middle, "up", this.#reach[1]);
    this.#nodes = column.map((node) => (node === null ? [] : this.#line(node, "ahead", this.#reach[0])));
  }

  /** Frames along an axis of one, both ways; null from where the surface has ended. */
  #line(from: Frame, axis: "up" | "ahead", n: number): (Frame | null)[] {
    const way = (sign: number): (Frame | null)[] => {
      const found: (Frame | null)[] = [];
      let at: Frame | null = from;
      for (let k = 0; k < n; k++) found.push((at = at && this.#next(at, times(at[axis], sign))));
      return found;
    };
    return [...way(-1.0).reverse(), from, ...way(1.0)];
  }

  #next(from: Frame, direction: Vector): Frame | null {
    const wanted = plus(from.point, times(direction, this.step));
    const { point, normal } = this.surface.find(wanted);
    if (lengthOf(minus(point, wanted)) > MOST_OFF * this.step) return null;
    const up = unit(minus(from.up, times(normal, dot(from.up, normal))));
    return { point, normal, up, ahead: cross(up, normal) };
  }

  /** The frame at x mm to the right and y mm up; null where there is no surface. */
  at(x: number, y: number): Frame | null {
    const [i, j] = [x / this.step + this.#reach[0], y / this.step + this.#reach[1]];
    const [column, row] = [Math.floor(i), Math.floor(j)];
    let [place, up, sum]: [Vector, Vector, number] = [[0, 0, 0], [0, 0, 0], 0.0]; // prettier-ignore
    for (const [k, l] of [[0, 0], [1, 0], [0, 1], [1, 1]]) {
      const share = (k === 1 ? i - column : 1.0 - i + column) * (l === 1 ? j - row : 1.0 - j + row);
      if (share === 0.0) continue;
      const node = this.#nodes[row + l]?.[column + k] ?? null;
      if (node === null) return null;
      place = plus(place, times(node.point, share));
      up = plus(up, times(node.up, share));
      sum += share;
    }
    const found = this.surface.find(times(place, 1.0 / sum));
    const level = unit(minus(up, times(found.normal, dot(up, found.normal))));
    return { ...found, up: level, ahead: cross(level, found.normal) };
  }
}
