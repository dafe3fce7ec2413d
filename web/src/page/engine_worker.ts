/** The thread that paints: asks the page for files, does what it is asked, and tells what came of it. */

import { Bundle } from "../core/bundle";
import type { Prepared } from "../mesh/prepared";
import { UnknownNameError } from "../studio";
import { Engine, type Opening, type Piece, type Told } from "./engine";
import { buffersOf } from "./picture_feed";

/** What the page can ask for by name. */
export type EngineCalls = {
  [name in keyof Engine as Engine[name] extends (...words: never[]) => unknown ? name : never]: Engine[name];
};

/** What an error was, where it is told in another thread. */
export interface Failure {
  name: string;
  message: string;
  file?: string; // that could not be had
  kind?: UnknownNameError["kind"];
  unknown?: string;
}

export type OpeningWords = Omit<Opening, "own"> & { own: (Prepared & { name: string }) | null };

/** What the page says. */
export type Request =
  | { open: OpeningWords }
  | { file: string; bytes: ArrayBuffer | null } // that was wanted; null where it cannot be had
  | { number: number; name: keyof EngineCalls; words: readonly unknown[] };

/** What the page is told. */
export type Reply =
  | { wanted: string } // a file of the folder
  | { share: number } // of the score that is painted again
  | { opened: Piece }
  | { told: Told }
  | { number: number; result: unknown }
  | { number: number | null; failed: Failure };

/** A file that the page cannot have. */
class NoFileError extends Error {
  constructor(readonly file: string) {
    super(`${file} cannot be had`);
  }
}

const PROGRESS_EVERY_MS = 100;
const AT_ONCE = new Set<keyof EngineCalls>(["pictureShown", "openCopybook"]); // in no order
const MEANWHILE = new Set<keyof EngineCalls>([...AT_ONCE, "write", "play"]); // nothing waits for these
const files = new Map<string, ((bytes: ArrayBuffer | null) => void)[]>(); // what awaits each
let engine: Engine | null = null;
let before: Promise<unknown> = Promise.resolve(); // what was asked before is done

function post(reply: Reply, transfer: ArrayBuffer[] = []): void {
  postMessage(reply, { transfer });
}

function failureOf(cause: unknown): Failure {
  if (!(cause instanceof Error)) return { name: "Error", message: String(cause) };
  const { name, message } = cause;
  if (cause instanceof UnknownNameError) return { name, message, kind: cause.kind, unknown: cause.unknown };
  return cause instanceof NoFileError ? { name, message, file: cause.file } : { name, message };
}

function fetchFile(name: string): Promise<ArrayBuffer> {
  return new Promise((done, failed) => {
    const came = (bytes: ArrayBuffer | null): void => (bytes === null ? failed(new NoFileError(name)) : done(bytes));
    const awaiting = files.get(name);
    files.set(name, [...(awaiting ?? []), came]);
    if (awaiting === undefined) post({ wanted: name });
  });
}

async function open({ own, ...words }: OpeningWords): Promise<void> {
  const tell = (told: Told): void => post({ told }, told.picture === undefined ? [] : buffersOf(told.picture));
  const failed = (cause: unknown): void => post({ number: null, failed: failureOf(cause) });
  const bundle = own === null ? null : Bundle.of(own.words, own.arrays, own.name);
  let postedMs = performance.now();
  const progress = (share: number): void => {
    if (performance.now() - postedMs < PROGRESS_EVERY_MS) return;
    postedMs = performance.now();
    post({ share });
  };
  engine = await Engine.open(fetchFile, { ...words, own: bundle }, progress, tell, failed);
  post({ opened: engine.piece });
}

onmessage = ({ data }: MessageEvent<Request>): void => {
  if ("file" in data) {
    for (const came of files.get(data.file) ?? []) came(data.bytes);
    files.delete(data.file);
    return;
  }
  if ("open" in data) {
    open(data.open).catch((cause: unknown) => post({ number: null, failed: failureOf(cause) }));
    return;
  }
  if (engine === null) return; // what was asked of a piece that could not be opened
  const { number, name, words } = data;
  const call = (engine[name] as (...words: readonly unknown[]) => unknown).bind(engine, ...words);
  const done = (AT_ONCE.has(name) ? Promise.resolve() : before).then(call);
  if (!MEANWHILE.has(name)) before = done.catch(() => {});
  done.then(
    (result) => post({ number, result }),
    (cause: unknown) => post({ number, failed: failureOf(cause) }),
  );
};
