/** Reads and prepares an object beside the page, which goes on meanwhile. */

import { MeshError, type Note } from "../files/mesh_error";
import { openOwnObject, type Given } from "../files/own_object";
import type { Prepared } from "../mesh/prepared";

/** What is told of it, the last once. */
export type ObjectReply =
  | { share: number }
  | { prepared: Prepared; notes: Note[] }
  | { refused: Note }
  | { failed: string };

onmessage = ({ data }: MessageEvent<Given>): void => {
  const tell = (reply: ObjectReply, transfer: ArrayBuffer[] = []): void => postMessage(reply, { transfer });
  openOwnObject(data, (share) => tell({ share })).then(
    ({ notes, ...prepared }) => {
      const buffers = Object.values(prepared.arrays).map(({ values }) => values.buffer as ArrayBuffer);
      tell({ prepared, notes }, [...new Set(buffers)]);
    },
    (cause: unknown) => {
      if (cause instanceof MeshError) tell({ refused: cause.note });
      else tell({ failed: cause instanceof Error ? cause.message : String(cause) });
    },
  );
};
