/** When each line of a score is done where it is played as it was painted, or as fast as can be. */

const LONGEST_PAUSE_MS = 300; // between two strokes, or where a hand thinks
const SHOWN_EVERY_MS = 30; // meanwhile

/** Milliseconds from the beginning at which each line is due, all of them within so many. */
function dueTimes(text: string, mostMs: number): Float64Array {
  const lines = text.split("\n").filter((line) => line !== "");
  const due = new Float64Array(lines.length);
  let [now, before] = [0.0, NaN];
  for (const [k, line] of lines.entries()) {
    const time = /"time_ns"\s*:\s*(-?\d+)/.exec(line);
    const ms = time === null ? NaN : 1e-6 * Number(time[1]);
    if (time === null) now += /"do"\s*:\s*"follow_time"/.test(line) ? LONGEST_PAUSE_MS / 10 : 0.0;
    else now += ms >= before ? Math.min(ms - before, LONGEST_PAUSE_MS) : LONGEST_PAUSE_MS;
    if (time !== null) before = ms;
    due[k] = now;
  }
  const faster = Math.min(1.0, mostMs / Math.max(now, 1.0));
  return due.map((ms) => ms * faster);
}

export class Pacing {
  readonly #due: Float64Array;
  readonly #beganMs = performance.now();
  #shownMs = this.#beganMs;

  /** `mostMs`: that it takes if the painter is fast enough. */
  constructor(text: string, mostMs: number) {
    this.#due = dueTimes(text, mostMs);
  }

  /** All that is left is due now. */
  hurry(): void {
    this.#due.fill(0.0);
  }

  /** What is to be waited for before line `k` is done; null where it is due and nothing is to be shown. */
  before(k: number): Promise<void> | null {
    const now = performance.now();
    const wait = this.#beganMs + this.#due[k] - now;
    if (wait <= 0.0 && now - this.#shownMs < SHOWN_EVERY_MS) return null;
    this.#shownMs = now + Math.max(0.0, wait);
    return new Promise((done) => setTimeout(done, Math.max(0.0, wait)));
  }
}
