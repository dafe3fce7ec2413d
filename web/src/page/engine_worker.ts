/** The thread that paints: asks the page for files, does what it is asked in that order, and tells what came of it. */

import { Bundle } from "../core/bundle";
import type { Prepared } from "../mesh/prepared";
import { UnknownNameError } from "../studio";
import { Engine, type Opening, type Piece, type Told } from "./engine";
import { buffersOf } from "./picture_feed";

/** What the page can ask for by name. */
export type Engaged = {
  [name in keyof Engine as Engine[name] extends (...words: never[]) => unknown ? name : never]: Engine[name];
};

/** What an error was, where it is told in another thread. */
export interface Failure {
  name: string;
  message: string;
  kind?: UnknownNameError["kind"];
  unknown?: string;
}

export type OpeningWords = Omit<Opening, "own"> & { own: (Prepared & { name: string }) | null };

/** What the page says. */
export type Asked =
  | { open: OpeningWords }
  | { file: string; bytes: ArrayBuffer | null } // that was wanted; null where it cannot be had
  | { seen: true }
  | { number: number; name: keyof Engaged; words: readonly unknown[] };

/** What the page is told. */
export type Answered =
  | { wanted: string } // a file of the folder
  | { share: number } // of the score that is painted again
  | { opened: Piece }
  | { told: Told }
  | { number: number; result: unknown }
  | { number: number | null; failed: Failure };

const SAID_EVERY_MS = 100;
const files = new Map<string, { had: (bytes: ArrayBuffer) => void; missed: (cause: Error) => void }>();
let engine: Engine | null = null;

function say(answer: Answered, transfer: ArrayBuffer[] = []): void {
  postMessage(answer, { transfer });
}

function failureOf(cause: unknown): Failure {
  if (cause instanceof UnknownNameError) {
    const { name, message, kind, unknown } = cause;
    return { name, message, kind, unknown };
  }
  if (cause instanceof Error) return { name: cause.name, message: cause.message };
  return { name: "Error", message: String(cause) };
}

function fetched(name: string): Promise<ArrayBuffer> {
  return new Promise((had, missed) => {
    files.set(name, { had, missed });
    say({ wanted: name });
  });
}

async function open({ own, ...words }: OpeningWords): Promise<void> {
  const told = (told: Told): void => say({ told }, told.picture === undefined ? [] : buffersOf(told.picture));
  const failed = (cause: unknown): void => say({ number: null, failed: failureOf(cause) });
  const bundle = own === null ? null : Bundle.of(own.words, own.arrays, own.name);
  let saidMs = performance.now();
  const progress = (share: number): void => {
    if (performance.now() - saidMs < SAID_EVERY_MS) return;
    saidMs = performance.now();
    say({ share });
  };
  engine = await Engine.open(fetched, { ...words, own: bundle }, progress, told, failed);
  say({ opened: engine.piece });
}

onmessage = ({ data }: MessageEvent<Asked>): void => {
  if ("file" in data) {
    const { file, bytes } = data;
    if (bytes === null) files.get(file)?.missed(new Error(`${file} cannot be had`));
    else files.get(file)?.had(bytes);
    files.delete(file);
    return;
  }
  if ("open" in data) {
    open(data.open).catch((cause: unknown) => say({ number: null, failed: failureOf(cause) }));
    return;
  }
  if (engine === null) return; // what was asked of a piece that could not be opened
  const asked = engine;
  if ("seen" in data) {
    try {
      asked.seen();
    } catch (cause) {
      say({ number: null, failed: failureOf(cause) });
    }
    return;
  }
  const { number, name, words } = data;
  const failed = (cause: unknown): void => say({ number, failed: failureOf(cause) });
  try {
    const result = (asked[name] as (...words: readonly unknown[]) => unknown).apply(asked, words as unknown[]);
    if (result instanceof Promise) result.then((later: unknown) => say({ number, result: later }), failed);
    else say({ number, result });
  } catch (cause) {
    failed(cause);
  }
};
