/** Which files a page reads, and how they may be asked to be read. */

import { MeshError } from "./mesh_error";

export const SUFFIXES = [".glb", ".obj", ".ply", ".stl"];

const MOST_BYTES = 1 << 28;

/** Refuse a file of more bytes than are read. */
export function checkSize(bytes: number): void {
  if (bytes > MOST_BYTES) throw new MeshError("it is larger than {most:,} bytes; expected less", { most: MOST_BYTES });
}

export const UNITS_MM = { mm: 1.0, cm: 10.0, m: 1000.0, in: 25.4 };
export type Unit = keyof typeof UNITS_MM;

export const UP_AXES = ["z", "y", "x", "-z", "-y", "-x"] as const;
export type Up = (typeof UP_AXES)[number];

/** What is not said is as the format says, else millimetres, z up. */
export interface Wanted {
  unit?: Unit;
  up?: Up;
}
