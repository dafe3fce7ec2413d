/** From where the object is seen: a perspective camera that turns about a place. */

import type { Vector } from "../core/quaternion";
import { cross, dot, lengthOf, minus, plus, times, turned, unit } from "../core/vectors";

const VIEW_ANGLE = (28.0 * Math.PI) / 180.0;
const TURN_A_PIXEL = 0.006; // rad
const NEAREST_TO_POLE = 0.02; // rad
const FILLED = 0.9; // of what is free of the picture, by the object

/** A column-major matrix (4, 4). */
export type Matrix = Float32Array;

export class Camera {
  focus: Vector = [0, 0, 0];
  away = 100.0; // mm from the focus
  #toEye: Vector = [0, 0, 1]; // unit
  #up: Vector = [0, 1, 0]; // unit, about

  #free: readonly [number, number, number, number] = [-1, 1, -1, 1];

  constructor(
    private readonly middle: Vector,
    private readonly radius: number,
    private readonly flat: boolean,
    private readonly points: readonly Vector[], // some, all over the object
  ) {
    this.showAll(1.0);
  }

  /** Have the focus in the middle of a part of the picture: left, right, bottom, top, -1 to 1. */
  setFree(part: readonly [number, number, number, number]): void {
    this.#free = part;
  }

  /** Where the focus is in the picture. */
  get centre(): [number, number] {
    const [left, right, bottom, top] = this.#free;
    return [0.5 * (left + right), 0.5 * (bottom + top)];
  }

  /** See the whole object, from where it is painted best. */
  showAll(aspect: number): void {
    this.focus = this.middle;
    this.#toEye = this.flat ? unit([0.0, -0.28, 1.0]) : unit([0.1, -1.0, 1.08]);
    this.#up = this.flat ? [0, 1, 0] : [0, 0, 1];
    const [left, right, bottom, top] = this.#free;
    const tall = Math.tan(0.5 * VIEW_ANGLE) * FILLED;
    const half = [0.5 * (right - left) * aspect * tall, 0.5 * (top - bottom) * tall];
    const axes = this.axes;
    const seen = this.points.map((point) => axes.map((axis) => dot(axis, minus(point, this.middle))));
    const shift = [0.0, 0.0];
    for (let again = 0; again < 6; again++) {
      this.away = 0.0;
      for (const at of seen)
        for (let k = 0; k < 2; k++)
          this.away = Math.max(this.away, at[2] + Math.abs(at[k] - shift[k]) / half[k]);
      for (let k = 0; k < 2; k++) {
        const sides = seen.map((at) => (at[k] - shift[k]) / (this.away - at[2]));
        shift[k] += 0.5 * this.away * (Math.min(...sides) + Math.max(...sides));
      }
    }
    this.focus = plus(this.middle, plus(times(axes[0], shift[0]), times(axes[1], shift[1])));
  }

  get eye(): Vector {
    return plus(this.focus, times(this.#toEye, this.away));
  }

  /** The picture's axes: right, up, and towards the eye. */
  get axes(): [Vector, Vector, Vector] {
    const right = unit(cross(this.#up, this.#toEye));
    return [right, cross(this.#toEye, right), this.#toEye];
  }

  /** Turn about the focus by a way over the picture, pixels. */
  turn(x: number, y: number): void {
    const [right] = this.axes;
    this.#toEye = turned(this.#toEye, this.#up, -x * TURN_A_PIXEL);
    const side = turned(right, this.#up, -x * TURN_A_PIXEL);
    const next = turned(this.#toEye, side, -y * TURN_A_PIXEL);
    const off = Math.acos(Math.min(1.0, Math.abs(next[0] * this.#up[0] + next[1] * this.#up[1] + next[2] * this.#up[2])));
    if (off > NEAREST_TO_POLE) this.#toEye = unit(next);
  }

  /** Move along the picture, pixels of a picture so high. */
  pan(x: number, y: number, height: number): void {
    const [right, up] = this.axes;
    const step = (2.0 * this.away * Math.tan(0.5 * VIEW_ANGLE)) / height;
    this.focus = plus(this.focus, plus(times(right, -x * step), times(up, y * step)));
  }

  /**
   * Move and turn the object as seen, by a way (mm) and a turn (rad) along and about the user's
   * axes: right, away, up. It turns about its middle.
   */
  steer(way: Vector, turn: Vector): void {
    const [right, up, back] = this.axes;
    const along = ([x, y, z]: Vector, [a, b, c]: readonly Vector[]): Vector => plus(plus(times(a, x), times(b, -y)), times(c, z));
    const spin = along(turn, [right, back, up]);
    const angle = lengthOf(spin);
    if (angle > 0.0) {
      const axis = times(spin, 1.0 / angle);
      const round = (vector: Vector): Vector => turned(vector, axis, -angle);
      this.#up = unit(round(up));
      this.#toEye = unit(round(back));
      this.focus = plus(this.middle, round(minus(this.focus, this.middle)));
    }
    const [side, above, near] = this.axes;
    this.focus = minus(this.focus, along(way, [side, near, above]));
  }

  /** Go nearer by a factor, towards a place of the picture (-1 to 1). */
  zoom(factor: number, x: number, y: number, aspect: number): void {
    const away = Math.min(Math.max(this.away / factor, 0.05 * this.radius), 12.0 * this.radius);
    const [right, up] = this.axes;
    const step = (this.away - away) * Math.tan(0.5 * VIEW_ANGLE);
    const [cx, cy] = this.centre;
    const [aside, above] = [(x - cx) * aspect * step, (y - cy) * step];
    this.focus = plus(this.focus, plus(times(right, aside), times(up, above)));
    this.away = away;
  }

  /** The unit direction of the ray through a place of the picture (-1 to 1). */
  ray(x: number, y: number, aspect: number): Vector {
    const [right, up, back] = this.axes;
    const tall = Math.tan(0.5 * VIEW_ANGLE);
    const [cx, cy] = this.centre;
    const aside = plus(times(right, (x - cx) * tall * aspect), times(up, (y - cy) * tall));
    return unit(minus(aside, back));
  }

  /** From the object's frame to the picture's. */
  matrix(aspect: number): Matrix {
    const [right, up, back] = this.axes;
    const eye = this.eye;
    const f = 1.0 / Math.tan(0.5 * VIEW_ANGLE);
    const far = this.away + 20.0 * this.radius;
    const near = Math.max(0.02 * this.away, this.away - 12.0 * this.radius);
    const [a, b] = [(far + near) / (near - far), (2.0 * far * near) / (near - far)];
    const at = (axis: Vector): number => -(axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]);
    const rows = [right, up, back].map((axis) => [...axis, at(axis)]);
    const result = new Float32Array(16);
    const [cx, cy] = this.centre;
    for (let k = 0; k < 4; k++) {
      result[4 * k] = (f / aspect) * rows[0][k] - cx * rows[2][k];
      result[4 * k + 1] = f * rows[1][k] - cy * rows[2][k];
      result[4 * k + 2] = a * rows[2][k] + (k === 3 ? b : 0.0);
      result[4 * k + 3] = -rows[2][k];
    }
    return result;
  }
}

/** The middle of points and the radius of a ball around them. */
export function ballAround(x: Float32Array, y: Float32Array, z: Float32Array, n: number): [Vector, number] {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < n; i++)
    for (const [k, axis] of [x, y, z].entries()) {
      low[k] = Math.min(low[k], axis[i]);
      high[k] = Math.max(high[k], axis[i]);
    }
  const middle: Vector = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])];
  return [middle, 0.5 * lengthOf(minus(high as unknown as Vector, low as unknown as Vector))];
}
