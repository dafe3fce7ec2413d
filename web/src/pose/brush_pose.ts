/**
 * Poses of the brush in the object's frame, and the cubics between samples, in the arithmetic of
 * `paint3d/pose/brush_pose.py`, to the bit.
 */

import { multiply, turn, type Quaternion, type Vector } from "../core/quaternion";
import type { DeviceSample } from "../recording/recording";

const MAX_CURVED_GAP_S = 0.1;
const STEEPEST = 3.0;

/** N poses of the brush in the object's frame. */
export interface BrushPath {
  timeS: Float64Array;
  orientation: Float64Array; // (N, 4)
  way: Float64Array; // (N, 3) the intended contact points, else the tuft's root, mm
  pressure: Float64Array | null;
  buttons: Int32Array;
  hasContact: Uint8Array;
}

/** A recording's or live samples' poses; time counts from the first. */
export function objectPoses(samples: readonly DeviceSample[]): BrushPath {
  const n = samples.length;
  const path: BrushPath = {
    timeS: new Float64Array(n),
    orientation: new Float64Array(4 * n),
    way: new Float64Array(3 * n),
    pressure: samples[0].pressure === null ? null : new Float64Array(n),
    buttons: new Int32Array(n),
    hasContact: new Uint8Array(n),
  };
  for (const [i, sample] of samples.entries()) {
    const [w, x, y, z] = sample.objectOrientation;
    const objectFromWorld: Quaternion = [w, x * -1.0, y * -1.0, z * -1.0];
    const turned = multiply(objectFromWorld, sample.orientation);
    const length = lengthOf(turned);
    for (let k = 0; k < 4; k++) path.orientation[4 * i + k] = turned[k] / length;
    const place = sample.contact ?? sample.position;
    const [ox, oy, oz] = sample.objectPosition;
    const from: Vector = [place[0] - ox, place[1] - oy, place[2] - oz];
    path.way.set(turn(objectFromWorld, from), 3 * i);
    path.hasContact[i] = Number(sample.contact !== null);
    if (path.pressure !== null) path.pressure[i] = sample.pressure ?? NaN;
    path.buttons[i] = sample.buttons;
    path.timeS[i] = Number(sample.timeNs - samples[0].timeNs) * 1e-9;
  }
  return path;
}

function lengthOf(v: readonly number[]): number {
  let sum = v[0] * v[0];
  for (let k = 1; k < v.length; k++) sum = sum + v[k] * v[k];
  return Math.sqrt(sum);
}

/** Which samples are joined by a stroke to the one before. */
export function joinedSamples(path: BrushPath): Uint8Array {
  const n = path.timeS.length;
  const joined = new Uint8Array(n).fill(1);
  joined[0] = 0;
  for (let i = 1; i < n; i++) {
    if (path.pressure !== null && !(path.pressure[i] > 0.0 || path.pressure[i - 1] > 0.0))
      joined[i] = 0;
    if (path.hasContact[i] !== path.hasContact[i - 1]) joined[i] = 0;
  }
  return joined;
}

/** Tangents of the cubics along the way, mm/s, (N, 3). */
export function velocities(path: BrushPath, joined: Uint8Array): Float64Array {
  const n = path.timeS.length;
  const velocity = new Float64Array(3 * n);
  if (n < 2) return velocity;
  const { timeS: time, way } = path;
  const steps = new Float64Array(n - 1);
  const chords = new Float64Array(3 * (n - 1));
  const curved = new Uint8Array(n - 1);
  for (let i = 0; i < n - 1; i++) {
    steps[i] = joined[i + 1] ? time[i + 1] - time[i] : 1.0; // the others are not used
    for (let k = 0; k < 3; k++)
      chords[3 * i + k] = (way[3 * i + 3 + k] - way[3 * i + k]) / steps[i];
    curved[i] = Number(joined[i + 1] === 1 && steps[i] <= MAX_CURVED_GAP_S);
  }
  for (let i = 0; i < n; i++) {
    const left = i > 0 && curved[i - 1] === 1;
    const right = i < n - 1 && curved[i] === 1;
    if (left && right) {
      // Each chord is weighted by the other's duration:
      const total = steps[i] + steps[i - 1];
      for (let k = 0; k < 3; k++)
        velocity[3 * i + k] =
          (steps[i] * chords[3 * i - 3 + k] + steps[i - 1] * chords[3 * i + k]) / total;
    } else if (left || right) setEnd(velocity, chords, steps, curved, i, right ? 1 : -1);
  }
  for (let i = 0; i < n; i++) {
    const before = i > 0 && joined[i] === 1 && curved[i - 1] === 0;
    const after = i < n - 1 && joined[i + 1] === 1 && curved[i] === 0;
    for (let k = 0; k < 3; k++) {
      if (after && before) velocity[3 * i + k] = 0.0;
      else if (after) velocity[3 * i + k] = chords[3 * i + k];
      else if (before) velocity[3 * i + k] = chords[3 * i - 3 + k];
    }
  }
  for (let i = 0; i < n; i++) {
    const limit = limitAt(velocity, chords, joined, i);
    for (let k = 0; k < 3; k++) velocity[3 * i + k] *= limit;
  }
  return velocity;
}

/** Fill the tangent at an end of a curved run that lies after (`side` 1) or before it (-1). */
function setEnd(
  velocity: Float64Array, chords: Float64Array, steps: Float64Array, curved: Uint8Array,
  end: number, side: number,
): void {
  const near = side === 1 ? end : end - 1;
  const far = Math.min(Math.max(near + side, 0), steps.length - 1);
  const hasFar = far === near + side && curved[far] === 1;
  const weight = hasFar ? steps[near] / (steps[near] + steps[far]) : 0.0;
  for (let k = 0; k < 3; k++)
    velocity[3 * end + k] =
      chords[3 * near + k] + (chords[3 * near + k] - chords[3 * far + k]) * weight;
}

/** The factor in [0, 1] that keeps a tangent from overshooting. */
function limitAt(
  velocity: Float64Array, chords: Float64Array, joined: Uint8Array, i: number,
): number {
  const n = joined.length;
  let slowest = Infinity;
  if (i > 0 && joined[i] === 1) slowest = lengthOf3(chords, i - 1);
  if (i < n - 1 && joined[i + 1] === 1) slowest = Math.min(slowest, lengthOf3(chords, i));
  const length = lengthOf3(velocity, i);
  return length > STEEPEST * slowest ? (STEEPEST * slowest) / length : 1.0;
}

function lengthOf3(rows: Float64Array, i: number): number {
  const [x, y, z] = [rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]];
  return Math.sqrt(x * x + y * y + z * z);
}
