/** Poses of the brush in the object's frame: `paint3d/pose/brush_pose.py`. */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import type { DeviceSample } from "../recording/recording";

/** N poses of the brush in the object's frame. */
export interface BrushPath {
  orientation: NDArray<"f8">; // (N, 4)
  points: NDArray<"f8">; // (N, 3) the intended contact points, else the tuft's root, mm
  pressures: NDArray<"f8">; // NaN where the device has none
  hasContact: NDArray<"b1">;
}

/** A recording's or live samples' poses. */
export function objectPoses(kernels: Kernels, samples: readonly DeviceSample[]): BrushPath {
  const n = samples.length;
  const rows = (columns: number, of: (sample: DeviceSample) => readonly number[]): NDArray<"f8"> =>
    NDArray.of(kernels, "f8", samples.flatMap(of), [n, columns]);
  const given = {
    origin: rows(3, (sample) => sample.objectPosition),
    frame: rows(4, (sample) => sample.objectOrientation),
    orientation: rows(4, (sample) => sample.orientation),
    place: rows(3, (sample) => sample.contact ?? sample.position),
  };
  const { origin, frame, orientation, place } = given;
  const path: BrushPath = {
    orientation: kernels.zeros("f8", n, 4),
    points: kernels.zeros("f8", n, 3),
    pressures: NDArray.of(kernels, "f8", samples.map((sample) => sample.pressure ?? NaN)),
    hasContact: NDArray.of(kernels, "b1", samples.map((sample) => Number(sample.contact !== null))),
  }; // prettier-ignore
  kernels.call("pose.kernels.hand_path.carry_to_object", orientation, frame, path.orientation);
  kernels.call("pose.kernels.hand_path.carry_points", place, origin, frame, path.points);
  for (const array of Object.values(given)) array.free();
  return path;
}
