/** A seal as a score has it: `press_seal`. */

import type { Vector } from "../core/quaternion";
import type { Pair } from "../mesh/spline_chart";
import { RecordingError } from "../recording/recording";
import type { Pressing } from "./print";
import { USUAL_PRESSING } from "./print";

/** What a stone of some rings leaves, where, and how it is pressed. */
export interface PressedSeal extends Pressing {
  rings: readonly (readonly Pair[])[]; // mm from the middle of the stone, y upwards
  at: Vector; // where the middle of the stone goes, mm
  up: Vector; // what is up on it
  ink: Record<string, number>; // the paste, parts by pigment
}

export const PASTE = "cinnabar";
const MOST_POINTS = 200_000;
const RANGES = { coats: [0.01, 10.0], pad_mm: [0.01, 100.0], wear: [0.0, 3.0], seed: [0, 1_000_000] } as const;

/** The seal that a score's line says, if a page can press it. */
export function readPressing(words: Record<string, unknown>, where: string): PressedSeal {
  const said = { up: [0.0, 0.0, 1.0], ink: PASTE, ...USUAL_PRESSING, ...words } as Record<string, unknown>;
  const refuse = (name: string, expected: string): never => {
    throw new RecordingError(`${where}: the ${name} of a seal is ${JSON.stringify(said[name])}; expected ${expected}`);
  };
  const isTuple = (value: unknown, n: number): boolean =>
    Array.isArray(value) && value.length === n && value.every((one) => Number.isFinite(one));
  const { rings } = said;
  const isRing = (ring: unknown): boolean => Array.isArray(ring) && ring.length >= 3 && ring.every((point) => isTuple(point, 2));
  if (!Array.isArray(rings) || rings.length === 0 || !rings.every(isRing) || rings.flat().length > MOST_POINTS)
    throw new RecordingError(`${where}: the rings of a seal are none, or too many; expected rings of three points at least`);
  for (const name of ["at", "up"]) if (!isTuple(said[name], 3)) refuse(name, "three numbers");
  for (const [name, [low, high]] of Object.entries(RANGES)) {
    const value = said[name];
    if (typeof value !== "number" || !(value >= low && value <= high)) refuse(name, `${low} to ${high}`);
  }
  const ink = typeof said.ink === "string" ? { [said.ink]: 1.0 } : (said.ink as Record<string, number>);
  if (typeof ink !== "object" || ink === null || Object.keys(ink).length === 0 || !Object.values(ink).every((part) => part >= 1e-9))
    refuse("ink", "parts of pigments");
  const { at, up, coats, pad_mm, wear, seed } = said as unknown as PressedSeal;
  return { rings: rings as Pair[][], at, up, ink, coats, pad_mm, wear, seed };
}
