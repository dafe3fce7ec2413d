/** The piece in hand, kept by what shows this page in a frame: a notebook (`paint3d/page/editor.py`). */

import type { Keeping } from "./keeper";
import type { OwnFile } from "./own_object";

const SILENT_MS = 30_000; // how long to wait for its answer: a notebook's kernel may be busy, or gone

export class Host implements Keeping {
  readonly isUpToDate = true; // what is told leaves this page at once

  private constructor(private readonly text: string) {}

  /** Ask for the piece; null where nobody answers. */
  static open(): Promise<Host | null> {
    return new Promise((done) => {
      const heard = ({ source, data }: MessageEvent<{ paint3d?: string; text: string } | null>): void => {
        if (source === parent && data?.paint3d === "kept") end(new Host(data.text));
      };
      const end = (host: Host | null): void => {
        clearTimeout(timer);
        removeEventListener("message", heard);
        done(host);
      };
      const timer = setTimeout(() => end(null), SILENT_MS);
      addEventListener("message", heard);
      tell("read");
    });
  }

  read(): Promise<string> {
    return Promise.resolve(this.text);
  }

  readObject(): Promise<OwnFile | undefined> {
    return Promise.resolve(undefined);
  }

  begin(_: OwnFile | null, text: string): void {
    tell("begin", text);
  }

  append(text: string): void {
    if (text !== "") tell("append", text);
  }
}

function tell(what: "read" | "begin" | "append", text = ""): void {
  parent.postMessage({ paint3d: what, text }, "*"); // whoever shows it has given it what it shows
}
