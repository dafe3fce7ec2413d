/** An object that somebody brings: read, checked, and prepared to be painted on. */

import { Bundle } from "../core/bundle";
import { Kernels, type KernelIndex } from "../core/kernels";
import { prepare, type Prepared } from "../mesh/prepared";
import type { StudioWords } from "../studio";
import type { Note } from "./mesh_error";
import { readMesh } from "./reading";
import type { Wanted } from "./wanted";

/** What is needed of the folder, and the file. */
export interface Given {
  wasm: ArrayBuffer;
  index: KernelIndex;
  common: ArrayBuffer;
  name: string;
  data: Uint8Array;
  resolution: number; // mm
  wanted?: Wanted;
}

/** Open a file, by kernels of its own: what they took of memory goes with them. */
export async function openOwnObject(
  { wasm, index, common, name, data, resolution, wanted }: Given, progress: (share: number) => void,
): Promise<Prepared & { notes: Note[] }> {
  const { mesh, notes } = await readMesh(name, data, wanted);
  progress(0.1);
  const [kernels, bundle] = await Promise.all([
    Kernels.load(wasm, index), Bundle.read<StudioWords>(common, "common.bin.gz"),
  ]); // prettier-ignore
  const prepared = prepare(kernels, mesh, resolution, bundle.words.preparing, (share) => progress(0.1 + 0.9 * share));
  return { ...prepared, notes };
}
