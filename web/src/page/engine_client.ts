/** The page's end of the thread that paints. */

import { KernelError } from "../core/kernels";
import { RecordingError } from "../recording/recording";
import { UnknownNameError, type Fetch } from "../studio";
import { startWorker } from "./carried";
import type { Piece, Told } from "./engine";
import script from "./engine_worker.ts?worker&url";
import type { EngineCalls, Failure, OpeningWords, Reply, Request } from "./engine_worker";
import { Cancelled } from "./own_object";

interface Pending {
  done: (result: never) => void;
  failed: (cause: unknown) => void;
}

/** What is told of a painting while it is open. */
export interface Listener {
  told(told: Told): void;
  failed(cause: unknown): void;
}

export class EngineClient {
  readonly #awaited = new Map<number, Pending>();
  #opening: Pending | null = null;
  readonly #missed = new Map<string, unknown>(); // files that could not be had, and why
  #number = 0;

  private constructor(
    private readonly worker: Worker,
    private readonly fetch: Fetch,
    private readonly progress: (share: number) => void,
    private readonly listener: Listener,
  ) {
    this.worker.onmessage = ({ data }: MessageEvent<Reply>) => this.#hear(data);
    this.worker.onerror = (event) => {
      event.preventDefault();
      const cause = new Error(event.message || "the thread that paints did not start");
      this.#fail(cause);
      this.#failAll(cause);
    };
  }

  /** Open a piece in a thread of its own; `progress` is told the share of a score that is painted again. */
  static async open(
    fetch: Fetch, words: OpeningWords, progress: (share: number) => void, listener: Listener, signal: AbortSignal,
  ): Promise<[EngineClient, Piece]> {
    const client = new EngineClient(await startWorker(script), fetch, progress, listener);
    try {
      const piece = await new Promise<Piece>((done, failed) => {
        if (signal.aborted) throw new Cancelled();
        client.#opening = { done, failed };
        signal.addEventListener("abort", () => failed(new Cancelled()));
        client.#post({ open: words });
      });
      client.#opening = null;
      return [client, piece];
    } catch (cause) {
      client.close();
      throw cause;
    }
  }

  /** Have something done, after what was asked before where that matters; what came of it. */
  call<N extends keyof EngineCalls>(
    name: N, ...words: Parameters<EngineCalls[N]>
  ): Promise<Awaited<ReturnType<EngineCalls[N]>>> {
    const number = ++this.#number;
    return new Promise((done, failed) => {
      this.#awaited.set(number, { done, failed });
      this.#post({ number, name, words });
    });
  }

  /** End the thread; what is awaited of it is cancelled. */
  close(): void {
    this.worker.terminate();
    this.#failAll(new Cancelled());
  }

  #post(request: Request): void {
    this.worker.postMessage(request);
  }

  #hear(reply: Reply): void {
    if ("told" in reply) this.listener.told(reply.told);
    else if ("result" in reply) this.#settle(reply.number)?.done(reply.result as never);
    else if ("wanted" in reply) void this.#bring(reply.wanted);
    else if ("share" in reply) this.progress(reply.share);
    else if ("opened" in reply) this.#opening?.done(reply.opened as never);
    else {
      const cause = this.#missed.get(reply.failed.file ?? "") ?? errorOf(reply.failed);
      if (reply.number === null) this.#fail(cause);
      else this.#settle(reply.number)?.failed(cause);
    }
  }

  #settle(number: number): Pending | undefined {
    const awaited = this.#awaited.get(number);
    this.#awaited.delete(number);
    return awaited;
  }

  #fail(cause: unknown): void {
    if (this.#opening === null) this.listener.failed(cause);
    else this.#opening.failed(cause);
  }

  #failAll(cause: unknown): void {
    for (const { failed } of this.#awaited.values()) failed(cause);
    this.#awaited.clear();
  }

  async #bring(file: string): Promise<void> {
    let bytes: ArrayBuffer | null = null;
    try {
      bytes = await this.fetch(file);
    } catch (cause) {
      this.#missed.set(file, cause);
    }
    this.#post({ file, bytes });
  }
}

/** What the thread's error was, as one of this. */
function errorOf({ name, message, kind, unknown }: Failure): Error {
  if (kind !== undefined && unknown !== undefined) return new UnknownNameError(kind, unknown);
  const known = { RecordingError, KernelError, RangeError }[name];
  return known === undefined ? new Error(message) : new known(message);
}
