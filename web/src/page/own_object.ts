/** An object that somebody brings to the page: its file, and what a worker made of it. */

import type { KernelIndex } from "../core/kernels";
import { MeshError, type Note } from "../files/mesh_error";
import type { Wanted } from "../files/wanted";
import type { Prepared } from "../mesh/prepared";
import type { Contents, Fetch } from "../studio";
import { startWorker } from "./carried";
import type { ObjectReply } from "./object_worker";
import script from "./object_worker.ts?worker&url";

/** A file, and how it is to be read. */
export interface OwnFile {
  name: string;
  data: Uint8Array;
  resolution: number; // mm
  wanted: Wanted;
}

/** The same, prepared. */
export interface OwnObject {
  file: OwnFile;
  about: Contents["objects"][number];
  prepared: Prepared;
  notes: Note[];
}

/** What was waited for is not wanted any more. */
export class Cancelled extends Error {
  override name = "Cancelled";
}

/** Have a worker read and prepare a file; `progress` is told the share that is done. */
export async function bringObject(
  fetch: Fetch, contents: Contents, file: OwnFile, progress: (share: number) => void, signal: AbortSignal,
): Promise<OwnObject> {
  const [wasm, index, common] = await Promise.all(["kernels.wasm", "kernels.json", "common.bin.gz"].map(fetch));
  const worker = await startWorker(script);
  try {
    const { prepared, notes } = await new Promise<Extract<ObjectReply, { prepared: unknown }>>((done, failed) => {
      if (signal.aborted) throw new Cancelled();
      signal.addEventListener("abort", () => failed(new Cancelled()));
      worker.onerror = (event) => failed(new Error(event.message || "the worker did not start"));
      worker.onmessage = ({ data }: MessageEvent<ObjectReply>) => {
        if ("share" in data) progress(data.share);
        else if ("prepared" in data) done(data);
        else failed("refused" in data ? new MeshError(data.refused.text, data.refused.fields) : new Error(data.failed));
      };
      worker.postMessage({
        ...file, wasm, common, index: JSON.parse(new TextDecoder().decode(index)) as KernelIndex,
      }); // prettier-ignore
    });
    const usual = contents.materials.find(({ name }) => name === prepared.words.usual_material) ?? contents.materials[0];
    const { name, resolution } = file;
    return {
      file, notes, prepared,
      about: { name, chinese: "", resolution, material: usual.name, file: "" },
    }; // prettier-ignore
  } finally {
    worker.terminate();
  }
}
