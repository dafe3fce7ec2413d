/** Where a pen is and is about to be, drawn thinly over the picture until what it paints there is shown. */

/** What is needed of a pointer's event. */
export type Pointed = Pick<PointerEvent, "timeStamp" | "clientX" | "clientY" | "pressure">;

const COLOUR = "rgb(40 36 32 / 45%)";
const WIDTH_PX = 5.0; // of a line that is pressed fully
const FARTHEST_PX = 40.0; // that a prediction is believed
const ROUNDING_MS = 1e-3;
const PENDING = 3; // samples whose paint waits for their successors

export class Ahead {
  readonly #drawn = document.createElement("canvas");
  #heard: Pointed[] = [];
  #predicted: Pointed[] = [];
  #isClear = true;

  constructor(private readonly over: HTMLCanvasElement) {
    this.#drawn.id = "ahead";
    over.after(this.#drawn);
  }

  /** The pointer was there, and is thought to be there soon. */
  follow(heard: readonly Pointed[], predicted: readonly Pointed[]): void {
    this.#heard.push(...heard);
    const { clientX: x, clientY: y } = heard[heard.length - 1];
    this.#predicted = predicted.filter(({ clientX, clientY }) => Math.hypot(clientX - x, clientY - y) < FARTHEST_PX);
  }

  /** What was heard up to a time (ms) is painted and shown. */
  shown(upToMs: number): void {
    const first = this.#heard.findIndex(({ timeStamp }) => timeStamp > upToMs + ROUNDING_MS);
    const isShown = first < 0 ? this.#heard.length : first;
    if (first < 0) this.#predicted = []; // what was thought has come, or has not
    this.#heard.splice(0, Math.min(isShown, this.#heard.length - PENDING));
  }

  /** The pointer is up: what it did is shown, or taken back. */
  end(): void {
    this.#heard = [];
    this.#predicted = [];
  }

  draw(): void {
    const way = [...this.#heard, ...this.#predicted];
    if (way.length < 2 && this.#isClear) return;
    const { width, height } = this.over;
    if (this.#drawn.width !== width || this.#drawn.height !== height) Object.assign(this.#drawn, { width, height });
    const context = this.#drawn.getContext("2d");
    if (context === null) return;
    context.clearRect(0, 0, width, height);
    this.#isClear = way.length < 2;
    const { left, top, width: across } = this.over.getBoundingClientRect();
    const ratio = width / Math.max(1, across);
    Object.assign(context, { strokeStyle: COLOUR, lineCap: "round", lineJoin: "round" });
    for (let k = 1; k < way.length; k++) {
      context.lineWidth = ratio * (1.0 + (WIDTH_PX - 1.0) * way[k].pressure);
      context.beginPath();
      for (const { clientX, clientY } of [way[k - 1], way[k]]) context.lineTo(ratio * (clientX - left), ratio * (clientY - top));
      context.stroke();
    }
  }
}
