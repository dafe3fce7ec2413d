/** Rotations: unit quaternions (w, x, y, z); the arithmetic of `paint3d/core/quaternion.py`. */

export type Quaternion = readonly [number, number, number, number];
export type Vector = readonly [number, number, number];

/** The unit quaternion, w not negative, of the rotation whose matrix has these columns. */
export function fromAxes(x: Vector, y: Vector, z: Vector): Quaternion {
  const trace = x[0] + y[1] + z[2];
  let q: [number, number, number, number];
  if (trace >= x[0] && trace >= y[1] && trace >= z[2])
    q = [1.0 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]];
  else if (x[0] >= y[1] && x[0] >= z[2])
    q = [y[2] - z[1], 1.0 + 2.0 * x[0] - trace, y[0] + x[1], z[0] + x[2]];
  else if (y[1] >= z[2])
    q = [z[0] - x[2], y[0] + x[1], 1.0 + 2.0 * y[1] - trace, z[1] + y[2]];
  else q = [x[1] - y[0], z[0] + x[2], z[1] + y[2], 1.0 + 2.0 * z[2] - trace];
  const length = Math.hypot(...q) * (q[0] < 0.0 ? -1.0 : 1.0);
  return [q[0] / length, q[1] / length, q[2] / length, q[3] / length];
}
