/** A painting in hand: strokes, undo, and the score that the desktop replays (`paint3d replay`). */

import type { Kernels } from "../core/kernels";
import type { Brush } from "../brush/brush";
import type { Contents, Studio } from "../studio";
import { ClosestPoints } from "../mesh/closest_points";
import { Painter, type Kept } from "../painter/painter";
import type { DeviceSample } from "../recording/recording";
import type { PaintedSurface, Snapshot } from "../surface/painted_surface";

const MOST_STEPS = 30;

type Line = Record<string, unknown>;

interface Step {
  painter: Kept;
  surface: Snapshot;
}

export class Document {
  readonly closest: ClosestPoints;
  readonly openness: Uint8Array; // of the base vertices: how much of the sky each sees
  #lines: Line[] = [];
  #steps: Step[] = [];
  #inStroke = false;
  #lastNs = 0n;

  private constructor(
    kernels: Kernels,
    readonly about: Contents["objects"][number],
    readonly surface: PaintedSurface,
    readonly painter: Painter,
    public ink: string,
  ) {
    const { object } = surface;
    this.closest = new ClosestPoints(kernels, object);
    this.openness = object.numbers("openness", "u1").slice();
  }

  /** Open a fresh object. */
  static async open(
    studio: Studio, about: Contents["objects"][number], brushName: string, ink: string,
  ): Promise<Document> {
    const [{ surface }, brush] = await Promise.all([
      studio.surface(about.name, about.resolution),
      studio.brush(brushName),
    ]);
    const painter = new Painter(studio.kernels, studio.sizes, surface, brush, studio.ink(ink));
    const document = new Document(studio.kernels, about, surface, painter, ink);
    document.#lines.push({
      format: "paint3d-recording",
      version: 2,
      object: about.name,
      mesh: surface.object.words.mesh,
      resolution_mm: about.resolution,
      material: surface.material.name,
      brush: brush.name,
      ink: studio.partsOf(ink),
      azimuth: "commanded",
      space: "world",
      units: { position: "mm", time: "ns", force: "N" },
    });
    return document;
  }

  get canUndo(): boolean {
    return this.#steps.length > 0 && !this.#inStroke;
  }

  /** Whether there is anything to be lost. */
  get isPainted(): boolean {
    return this.#lines.some((line) => line.do === "begin_stroke");
  }

  setBrush(brush: Brush): void {
    this.painter.changeBrush(brush);
    this.#lines.push({ do: "set_brush", brush: brush.name });
  }

  dip(studio: Studio, ink: string = this.ink): void {
    this.ink = ink;
    this.painter.dip(studio.ink(ink));
    this.#lines.push({ do: "dip", ink: studio.partsOf(ink) });
  }

  beginStroke(): void {
    this.#steps.push({ painter: this.painter.keep(), surface: this.surface.keep() });
    if (this.#steps.length > MOST_STEPS) this.#steps.shift();
    this.#inStroke = true;
    this.#lines.push({ do: "begin_stroke" });
  }

  advance(samples: readonly DeviceSample[]): void {
    for (const sample of samples) {
      this.#lastNs = sample.timeNs;
      this.#lines.push(lineOf(sample));
    }
    if (samples.length > 0) this.painter.advance(samples);
  }

  endStroke(): void {
    this.painter.finish();
    this.#inStroke = false;
    this.#lines.push({ do: "end_stroke" });
  }

  /** Take the last stroke back. */
  undo(): void {
    const step = this.#steps.pop();
    if (step === undefined) return;
    this.painter.restore(step.painter, step.surface);
    this.#lines.push({ do: "undo" });
  }

  /** When the last sample was, which the next has to come after. */
  get lastNs(): bigint {
    return this.#lastNs;
  }

  /** What was done, one thing a line. */
  score(): string {
    return `${this.#lines.map(textOf).join("\n")}\n`;
  }
}

function lineOf(sample: DeviceSample): Line {
  const { position, orientation, pressure, contact } = sample;
  return { time_ns: sample.timeNs, position, orientation, pressure, buttons: sample.buttons, contact };
}

/** A line as JSON; times have more digits than JSON.stringify takes. */
function textOf(line: Line): string {
  const time = line.time_ns as bigint | undefined;
  if (time === undefined) return JSON.stringify(line);
  return `{"time_ns": ${time}, ${JSON.stringify({ ...line, time_ns: undefined }).slice(1)}`;
}
