/** The page's end of the thread that paints. */

import { KernelError } from "../core/kernels";
import { RecordingError } from "../recording/recording";
import { UnknownNameError, type Fetch } from "../studio";
import type { Piece, Told } from "./engine";
import type { Answered, Asked, Engaged, Failure, OpeningWords } from "./engine_worker";
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
  readonly #worker = new Worker(new URL("./engine_worker.ts", import.meta.url), { type: "module" });
  readonly #awaited = new Map<number, Pending>();
  #opening: Pending | null = null;
  #missed: unknown = null; // why a file could not be had
  #number = 0;

  private constructor(
    private readonly fetch: Fetch,
    private readonly progress: (share: number) => void,
    private readonly listener: Listener,
  ) {
    this.#worker.onmessage = ({ data }: MessageEvent<Answered>) => this.#hear(data);
    this.#worker.onerror = (event) => {
      event.preventDefault();
      this.#fail(new Error(event.message || "the thread that paints did not start"));
    };
  }

  /** Open a piece in a thread of its own; `progress` is told the share of a score that is painted again. */
  static async open(
    fetch: Fetch, words: OpeningWords, progress: (share: number) => void, listener: Listener, signal: AbortSignal,
  ): Promise<[EngineClient, Piece]> {
    if (signal.aborted) throw new Cancelled();
    const client = new EngineClient(fetch, progress, listener);
    try {
      const piece = await new Promise<Piece>((done, failed) => {
        client.#opening = { done, failed };
        signal.addEventListener("abort", () => failed(new Cancelled()));
        client.#say({ open: words });
      });
      client.#opening = null;
      return [client, piece];
    } catch (cause) {
      client.close();
      throw cause;
    }
  }

  /** Have something done, after all that was asked before; what came of it. */
  call<N extends keyof Engaged>(
    name: N, ...words: Parameters<Engaged[N]>
  ): Promise<Awaited<ReturnType<Engaged[N]>>> {
    const number = ++this.#number;
    return new Promise((done, failed) => {
      this.#awaited.set(number, { done, failed });
      this.#say({ number, name, words });
    });
  }

  /** Say that the picture that was told last is shown. */
  seen(): void {
    this.#say({ seen: true });
  }

  /** End the thread; what is awaited of it never comes. */
  close(): void {
    this.#worker.terminate();
    this.#awaited.clear();
  }

  #say(asked: Asked): void {
    this.#worker.postMessage(asked);
  }

  #hear(answer: Answered): void {
    if ("told" in answer) this.listener.told(answer.told);
    else if ("result" in answer) this.#settle(answer.number)?.done(answer.result as never);
    else if ("wanted" in answer) void this.#bring(answer.wanted);
    else if ("share" in answer) this.progress(answer.share);
    else if ("opened" in answer) this.#opening?.done(answer.opened as never);
    else {
      const cause = this.#missed ?? errorOf(answer.failed);
      this.#missed = null;
      if (answer.number === null) this.#fail(cause);
      else this.#settle(answer.number)?.failed(cause);
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

  async #bring(file: string): Promise<void> {
    let bytes: ArrayBuffer | null = null;
    try {
      bytes = await this.fetch(file);
    } catch (cause) {
      this.#missed = cause;
    }
    this.#say({ file, bytes });
  }
}

/** What the thread's error was, as one of this. */
function errorOf({ name, message, kind, unknown }: Failure): Error {
  if (kind !== undefined && unknown !== undefined) return new UnknownNameError(kind, unknown);
  const known = { RecordingError, KernelError, RangeError }[name];
  return known === undefined ? new Error(message) : new known(message);
}
