/** Samples of both hands, and recordings of them in JSON Lines: `paint3d/recording`. */

import type { Quaternion, Vector } from "../core/quaternion";

/** Bits of `buttons`: the one that dips the brush, and the eraser end. */
export const DIP = 2;
export const ERASER = 4;
const UNIT_TOLERANCE = 1e-3;
const ROUNDING = 1e-12;
const MAX_FORCE_N = 7.9;

/** One reading of the two hands. */
export interface DeviceSample {
  timeNs: bigint;
  position: Vector; // the tuft's root in the world, mm
  orientation: Quaternion; // world_from_pen
  pressure: number | null;
  buttons: number;
  objectPosition: Vector;
  objectOrientation: Quaternion;
  contact: Vector | null; // the intended contact point, in the world, mm
}

export interface Recording {
  header: Record<string, unknown>;
  samples: DeviceSample[];
}

/** A recording that cannot be read. */
export class RecordingError extends Error {
  override name = "RecordingError";
}

/** Where something is and how it is turned. */
export interface Pose {
  position: Vector;
  orientation: Quaternion;
}

export const AT_REST: Pose = { position: [0.0, 0.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0] };

/** Read a recording of version 1, in the world and in mm. */
export function readRecording(text: string, name: string): Recording {
  const lines = text.split("\n").filter((line) => line.trim() !== "");
  if (lines.length < 2) throw new RecordingError(`${name}: it holds no samples`);
  const header = decodeLine(lines[0], name, 1);
  const units = (header.units ?? {}) as Record<string, string>;
  if (header.format !== "paint3d-recording" || header.version !== 1)
    throw new RecordingError(`${name}:1: expected a recording of version 1`);
  if ((header.space ?? "world") !== "world" || (units.position ?? "mm") !== "mm")
    throw new RecordingError(`${name}:1: expected a recording in the world, in mm`);
  let object: Pose = AT_REST;
  const samples: DeviceSample[] = [];
  for (const [k, line] of lines.slice(1).entries()) {
    const where = `${name}:${k + 2}`;
    const row = decodeLine(line, name, k + 2);
    const pen = (row.right ?? row.right_hand ?? row) as Record<string, unknown>;
    const held = (row.object ?? row.left ?? row.left_hand) as Pose | undefined;
    if (held !== undefined)
      object = { position: held.position, orientation: unit(held.orientation, where) };
    const force = (pen.force ?? null) as number | null;
    const sample: DeviceSample = {
      timeNs: timeIn(line, where),
      position: pen.position as Vector,
      orientation: unit(pen.orientation as Quaternion, where),
      pressure: (pen.pressure ?? (force === null ? null : force / MAX_FORCE_N)) as number | null,
      buttons: (pen.buttons ?? 0) as number,
      objectPosition: object.position,
      objectOrientation: object.orientation,
      contact: (pen.contact ?? null) as Vector | null,
    };
    if (!Array.isArray(sample.position) || sample.position.length !== 3)
      throw new RecordingError(`${where}: it has no position; expected three numbers`);
    if (samples.length > 0 && sample.timeNs <= samples[samples.length - 1].timeNs)
      throw new RecordingError(`${where}: time_ns does not increase`);
    samples.push(sample);
  }
  return { header, samples };
}

function decodeLine(line: string, name: string, number: number): Record<string, unknown> {
  try {
    return JSON.parse(line) as Record<string, unknown>;
  } catch {
    throw new RecordingError(`${name}:${number}: it is not JSON; expected an object a line`);
  }
}

/** The time of a line, whose digits may be more than a number of JavaScript holds. */
function timeIn(line: string, where: string): bigint {
  const found = /"time_ns"\s*:\s*(-?\d+)/.exec(line);
  if (found === null) throw new RecordingError(`${where}: it has no time_ns; expected an integer`);
  return BigInt(found[1]);
}

function unit(q: Quaternion, where: string): Quaternion {
  if (!Array.isArray(q) || q.length !== 4)
    throw new RecordingError(`${where}: it has no orientation; expected four numbers`);
  let sum = q[0] * q[0];
  for (let k = 1; k < 4; k++) sum = sum + q[k] * q[k];
  const length = Math.sqrt(sum);
  if (!(Math.abs(length - 1.0) <= UNIT_TOLERANCE))
    throw new RecordingError(`${where}: orientation has length ${length}; expected 1`);
  if (Math.abs(length - 1.0) <= ROUNDING) return q;
  return [q[0] / length, q[1] / length, q[2] / length, q[3] / length];
}
