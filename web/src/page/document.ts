/** A painting in hand: strokes, undo, and the score that the desktop replays (`paint3d replay`). */

import PLAYED from "../../../paint3d/page/played.json";
import type { Kernels } from "../core/kernels";
import { FULL_DIP, readAmount, type Brush, type DipAmount } from "../brush/brush";
import type { Contents, Studio } from "../studio";
import type { Bundle } from "../core/bundle";
import type { ObjectWords } from "../mesh/refined_mesh";
import { frameUp } from "../mesh/chart";
import { ClosestPoints } from "../mesh/closest_points";
import { readPressing, type PressedSeal } from "../seal/pressing";
import { findImpression, layPaste } from "../seal/print";
import { Painter, INK_STEP_S, type Ink, type Kept } from "../painter/painter";
import { AT_REST, ERASER, RecordingError, type DeviceSample, type Pose } from "../recording/recording";
import { readText, type LaidText } from "./copybook";
import { Eraser } from "../surface/eraser";
import type { Blend, LayerStack } from "../surface/layer_stack";
import type { PaintedSurface, Snapshot } from "../surface/painted_surface";

const MOST_STEPS = 30;
const MOST_BYTES = 1 << 28; // of the steps that can be undone, but for the last

/** What is done to the layers, as a score says it. */
export type LayerEdit =
  | { do: "add_layer" }
  | { do: "remove_layer"; place: number }
  | { do: "select_layer"; place: number }
  | { do: "move_layer"; place: number; to: number }
  | { do: "set_visible"; place: number; visible: boolean }
  | { do: "rename_layer"; place: number; name: string }
  | { do: "set_opacity"; place: number; opacity: number }
  | { do: "set_blend"; place: number; blend: Blend };
const LAYER_EDITS = new Set([
  "add_layer", "remove_layer", "select_layer", "move_layer", "set_visible", "rename_layer", "set_opacity",
  "set_blend",
]); // prettier-ignore
const SAMPLE_WORDS = ["time_ns", "position", "orientation", "pressure", "buttons", "contact", "object"];
const HEAD_WORDS = [
  "format", "version", "object", "mesh", "resolution_mm", "material", "brush", "ink", "azimuth", "pickup", "space", "units",
  "licence",
]; // prettier-ignore
const UNITS: Record<string, string> = { position: "mm", time: "ns", force: "N" };
const NOTHING = (): void => {};
const MOST_AT_ONCE = 64; // samples that are painted together where a score is repeated
const NO_STEPS = new Set(["select_layer", "set_visible", "rename_layer"]);

/** What a score's head says of how a brush is held, and takes up ink. */
export interface Handling {
  azimuth: "commanded" | "dragged";
  pickup: number; // share per mm of travel
}
const USUAL_HANDLING: Handling = { azimuth: "commanded", pickup: 0.0 };

/** The same of a head's words. */
export function handlingOf({ azimuth, pickup }: Record<string, unknown>): Handling {
  return { azimuth: azimuth === "dragged" ? "dragged" : "commanded", pickup: Number(pickup ?? 0.0) };
}

type Line = Record<string, unknown>;
type Step = (() => void | Promise<void>) | DeviceSample;

const isMark = (line: Line): boolean => line.do === "begin_stroke" || line.do === "press_seal";

interface Instant {
  texts: readonly LaidText[];
  painter: Kept;
  surface: Snapshot;
}

export class Document {
  readonly openness: Uint8Array; // of the base vertices: how much of the sky each sees
  #lines: Line[] = [];
  #steps: Instant[] = []; // before each
  #undone: Instant[] = []; // after each, the next one last
  #back: Instant | null = null; // that was returned to last
  #texts: readonly LaidText[] = [];
  #inStroke = false;
  #eraser: Eraser | null = null; // while a stroke erases
  #giveBack: (() => void) | null = null; // the brush that waits meanwhile
  #lastNs = 0n;
  #taken = 0; // lines that were handed out, and do not change any more
  #held: Pose = AT_REST; // where the object is, as the lines so far say it

  private constructor(
    private readonly kernels: Kernels,
    readonly about: Contents["objects"][number],
    readonly surface: PaintedSurface,
    readonly painter: Painter,
    readonly closest: ClosestPoints,
    public ink: string,
  ) {
    this.openness = surface.object.numbers("openness", "u1").slice();
  }

  /** Open a fresh object of the folder, or one of somebody's own. */
  static async open(
    studio: Studio, about: Contents["objects"][number], brushName: string, ink: string,
    material: string = about.material, own: Bundle<ObjectWords> | null = null,
    { azimuth, pickup }: Handling = USUAL_HANDLING,
  ): Promise<Document> {
    const [surface, brush] = await Promise.all([
      own === null ? studio.surface(about.name, about.resolution, material) : studio.surfaceOf(own, material),
      studio.brush(brushName),
    ]);
    const closest = new ClosestPoints(studio.kernels, surface.object);
    surface.useLayers();
    const painter = new Painter(
      studio.kernels, studio.sizes, surface, brush, studio.ink(ink), azimuth, FULL_DIP, pickup > 0.0 ? pickup : null,
    ); // prettier-ignore
    const document = new Document(studio.kernels, about, surface, painter, closest, ink);
    document.#lines.push({
      format: "paint3d-recording",
      version: 2,
      object: about.name,
      mesh: surface.object.words.mesh,
      resolution_mm: about.resolution,
      material: surface.material.name,
      brush: brush.name,
      ink: studio.partsOf(ink),
      azimuth,
      ...(pickup > 0.0 ? { pickup } : {}),
      space: "world",
      units: UNITS,
    });
    return document;
  }

  get canUndo(): boolean {
    return this.#steps.length > 0 && !this.#inStroke;
  }

  get canRedo(): boolean {
    return this.#undone.length > 0 && !this.#inStroke;
  }

  /** Whether something on the layer that is painted on is wet, and it is shown. */
  get canDry(): boolean {
    const { layers, active } = this.layers;
    return !this.#inStroke && layers[active].visible && this.surface.ink.coverage.data.some((c) => c > 0.0);
  }

  /** Parts of the last dip, by pigment. */
  get dipped(): Record<string, number> {
    return Object.fromEntries([...this.painter.dipped].map(([pigment, part]) => [pigment.name, part]));
  }

  /** Whether there is anything to be lost. */
  get isPainted(): boolean {
    return this.#lines.some(isMark);
  }

  /** How many strokes were begun and seals pressed, whether or not they were undone. */
  get nMarks(): number {
    return this.#lines.filter(isMark).length;
  }

  /** Take another brush; not during a stroke, which one brush paints. */
  setBrush(brush: Brush): void {
    if (this.#inStroke) return;
    this.painter.changeBrush(brush);
    this.#lines.push({ do: "set_brush", brush: brush.name });
  }

  /** Dip the brush; an amount is how much it takes up from now on. */
  dip(studio: Studio, ink: string = this.ink, amount: DipAmount | null = null): void {
    this.ink = ink;
    this.#dipIn(studio, studio.partsOf(ink), amount);
  }

  #dipIn(studio: Studio, parts: Record<string, number>, amount: DipAmount | null = null): void {
    this.painter.dip(studio.mixture(parts), null, amount);
    this.#lines.push({ do: "dip", ink: parts, ...(amount === null ? {} : { amount }) });
  }

  /** Begin a stroke, or one that takes paint off with a full brush. */
  beginStroke(erases = false): void {
    this.#begin();
    this.#inStroke = true;
    this.#lines.push({ do: "begin_stroke", ...(erases ? { erase: true } : {}) });
    if (!erases) return;
    this.#giveBack = this.painter.lend();
    this.#eraser = new Eraser(this.kernels, this.surface);
  }

  advance(samples: readonly DeviceSample[]): void {
    for (const sample of samples) {
      this.#lastNs = sample.timeNs;
      this.#lines.push(this.#lineOf(sample));
    }
    if (this.#eraser === null) {
      if (samples.length > 0) this.painter.advance(samples);
      return;
    }
    for (const sample of samples) {
      this.painter.advance([sample]);
      this.painter.loaded -= this.#eraser.wipe();
    }
  }

  #lineOf({ timeNs, position, orientation, pressure, buttons, contact, objectPosition, objectOrientation }: DeviceSample): Line {
    const line = { time_ns: timeNs, position, orientation, pressure, buttons, contact };
    const held = { position: objectPosition, orientation: objectOrientation };
    if (String([held.position, held.orientation]) === String([this.#held.position, this.#held.orientation])) return line;
    this.#held = held;
    return { ...line, object: held };
  }

  endStroke(): void {
    this.#inStroke = false; // whatever the brush may still meet
    this.#lines.push({ do: "end_stroke" });
    this.painter.finish();
    if (this.#eraser !== null) this.painter.loaded -= this.#eraser.wipe();
    this.#giveBack?.();
    this.#giveBack = this.#eraser = null;
  }

  /** Take the last step back; the brush, its ink and so much of it stay those that were chosen last. */
  undo(): void {
    const step = this.#steps.pop();
    if (step === undefined) return;
    this.#undone.push(this.#end());
    const { brush, dipped, amount } = this.painter;
    this.#return(step);
    const now = this.painter;
    if (now.brush !== brush || !isSameInk(now.dipped, dipped) || !isSameAmount(now.amount, amount)) {
      now.changeBrush(brush);
      now.dip(dipped, null, amount);
    }
    this.#lines.push({ do: "undo" });
  }

  /** Do again what was taken back last; what came since is lost. */
  redo(): void {
    const step = this.#undone.pop();
    if (step === undefined) return;
    this.#steps.push(this.#back as Instant);
    this.#return(step);
    this.#lines.push({ do: "redo" });
  }

  /** Where the last step ends: at its successor's beginning, or now. */
  #end(): Instant {
    return this.#undone.length > 0 ? (this.#back as Instant) : this.#now();
  }

  #now(): Instant {
    return { texts: this.#texts, painter: this.painter.keep(), surface: this.surface.keep() };
  }

  #return(instant: Instant): void {
    this.painter.restore(instant.painter, instant.surface);
    this.#texts = instant.texts;
    this.#back = instant;
  }

  /** Let wet ink spread and dry for a time step. */
  followTime(): void {
    this.surface.water.followTime(INK_STEP_S);
    const last = this.#lines[this.#lines.length - 1];
    if (last.do === "follow_time" && this.#lines.length > this.#taken) last.times = Number(last.times ?? 1) + 1;
    else this.#lines.push({ do: "follow_time", seconds: INK_STEP_S });
  }

  /** Let all wet paint dry at once: a step that can be undone. */
  dry(): void {
    if (this.#inStroke) return;
    this.#begin();
    this.surface.dry();
    this.#lines.push({ do: "dry" });
  }

  /** Press a seal onto the layer that is painted on: a step that can be undone. */
  pressSeal(studio: Studio, seal: PressedSeal): void {
    if (this.#inStroke) return;
    const { kernels, surface } = this;
    const { rings, at, up, ink, ...pressing } = seal;
    const frame = frameUp(this.closest.find(at), up);
    const left = findImpression(kernels, surface, this.closest, frame, rings, pressing);
    const parts = this.painter.partsOf(studio.mixture(ink));
    this.#begin();
    this.painter.loaded += layPaste(surface, left, parts);
    this.#lines.push({ do: "press_seal", ...seal });
  }

  get layers(): LayerStack {
    return this.surface.useLayers();
  }

  /** Add, remove, move, name, hide, fade or multiply a layer, or paint on another one. */
  restack(edit: LayerEdit): void {
    if (this.#inStroke) return;
    const { layers, surface } = this;
    if (!NO_STEPS.has(edit.do)) this.#begin();
    const shown = layers.paintedIds();
    if (edit.do === "add_layer") layers.add();
    else if (edit.do === "remove_layer") layers.remove(edit.place);
    else if (edit.do === "move_layer") layers.move(edit.place, edit.to);
    else if (edit.do === "select_layer") layers.activate(edit.place);
    else if (edit.do === "set_visible") layers.setProperties(edit.place, { visible: edit.visible });
    else if (edit.do === "rename_layer") layers.setProperties(edit.place, { name: edit.name });
    else if (edit.do === "set_blend") layers.setProperties(edit.place, { blend: edit.blend });
    else layers.setProperties(edit.place, { opacity: edit.opacity });
    if (edit.do !== "select_layer" && edit.do !== "rename_layer") surface.touch([...shown, ...layers.paintedIds()]);
    this.#lines.push({ ...edit });
  }

  /** What lies on the object to be written after. */
  get texts(): readonly LaidText[] {
    return this.#texts;
  }

  /** Lay a text, in the place of the one of a number or beside all: a step that can be undone. */
  layText(text: LaidText, number = this.#texts.length): void {
    const isNew = number === this.#texts.length;
    this.#changeTexts(number, [text], { do: "lay_text", text, ...(isNew ? {} : { number }) });
  }

  /** Take a text off the object: a step that can be undone. */
  removeText(number: number): void {
    this.#changeTexts(number, [], { do: "remove_text", number });
  }

  #changeTexts(number: number, by: LaidText[], line: Line): void {
    if (this.#inStroke) return;
    this.#begin();
    this.#texts = [...this.#texts.slice(0, number), ...by, ...this.#texts.slice(number + 1)];
    this.#lines.push(line);
  }

  #begin(): void {
    this.#undone = [];
    this.#back = null;
    this.#steps.push(this.#now());
    const isTooMuch = (): boolean =>
      this.#steps.reduce((sum, { surface }) => sum + bytesIn({ ...surface, stack: null }), 0) > MOST_BYTES;
    while (this.#steps.length > 1 && (this.#steps.length > MOST_STEPS || isTooMuch())) this.#steps.shift();
  }

  /** When the last sample was, which the next has to come after. */
  get lastNs(): bigint {
    return this.#lastNs;
  }

  /** What was done since this was last asked, to be kept. */
  takeNew(): string {
    const lines = this.#lines.slice(this.#taken);
    this.#taken = this.#lines.length;
    return lines.map((line) => `${textOf(line)}\n`).join("");
  }

  /**
   * Do what a score of a page says; `progress` is told the fraction that is done. What a page does not
   * play is refused before anything is painted. `pause` says what is to be waited for before a line is done.
   */
  async repeat(
    studio: Studio, text: string, progress: (fraction: number) => void,
    pause: (line: number) => Promise<void> | null = () => null,
  ): Promise<void> {
    const lines = text.split("\n").filter((line) => line !== "");
    let held = AT_REST;
    const steps = lines.map((line, k): Step => {
      const [row, where] = [JSON.parse(line) as Line, `line ${k + 1}`];
      if (k === 0) {
        checkHead(row);
        return NOTHING; // this document was opened by it
      }
      if (row.do !== undefined) return this.#stepOf(studio, row, where);
      checkWords(row, SAMPLE_WORDS, "a sample", where);
      held = (row.object as Pose | undefined) ?? held;
      return sampleOf(line, row, held, where);
    });
    const waiting: DeviceSample[] = [];
    for (const [k, step] of steps.entries()) {
      const due = pause(k);
      const isSample = typeof step !== "function";
      if (due !== null || !isSample || waiting.length >= MOST_AT_ONCE) this.advance(waiting.splice(0));
      if (due !== null) await due;
      if (isSample) waiting.push(step);
      else await step();
      progress((k + 1) / lines.length);
    }
    this.advance(waiting);
    this.#taken = this.#lines.length; // where a text is kept that ends within a stroke, its end is still to be
    if (this.#inStroke) this.endStroke();
    this.surface.refresh();
  }

  /** What a line asks for, where a page plays it. */
  #stepOf(studio: Studio, row: Line, where: string): () => void | Promise<void> {
    const name = String(row.do);
    if (row.refused === true || name === "set_tags") return NOTHING;
    const words = (PLAYED as Record<string, string[] | undefined>)[name];
    if (words === undefined) throw new RecordingError(`${where}: a page does not know ${name}`);
    checkWords(row, ["do", "refused", "time_s", ...words], name, where);
    const number = row.number as number | undefined;
    if (LAYER_EDITS.has(name)) return () => this.restack(row as unknown as LayerEdit);
    switch (name) {
      case "set_brush": {
        const brush = studio.brush(row.brush as string);
        brush.catch(() => {}); // it is said when it is taken
        return async () => this.setBrush(await brush);
      }
      case "dip": {
        const parts = row.ink as Record<string, number> | undefined;
        if (parts !== undefined) studio.mixture(parts);
        const amount = readAmount(row.amount, where);
        return () => this.#dipIn(studio, parts ?? this.dipped, amount);
      }
      case "begin_stroke":
        return () => this.beginStroke(row.erase === true);
      case "end_stroke":
        return () => {
          this.endStroke();
          this.surface.refresh(); // not all at the end
        };
      case "undo":
      case "redo":
        return () => {
          if (!(name === "undo" ? this.canUndo : this.canRedo))
            throw new RecordingError(`${where}: it goes back farther than a page keeps`);
          this[name]();
        };
      case "press_seal": {
        const seal = readPressing(row, where);
        studio.mixture(seal.ink);
        return () => this.pressSeal(studio, seal);
      }
      case "lay_text": {
        const laid = readText(row.text, where);
        return () => this.layText(laid, number);
      }
      case "remove_text":
        return () => this.removeText(number as number);
      case "follow_time":
        if (row.seconds !== INK_STEP_S)
          throw new RecordingError(
            `${where}: its ink flows in steps of ${String(row.seconds)} s; in a page these are ${INK_STEP_S} s`,
          );
        return () => {
          for (let n = Number(row.times ?? 1); n > 0; n--) this.followTime();
        };
      default: // dry
        return () => this.dry();
    }
  }

  /** What was done, one thing a line. */
  score(): string {
    return `${this.#lines.map(textOf).join("\n")}\n`;
  }
}

function isSameAmount(one: DipAmount, two: DipAmount): boolean {
  return one.wetted === two.wetted && one.fullness === two.fullness;
}

function isSameInk(one: Ink, two: Ink): boolean {
  return one.size === two.size && [...one].every(([pigment, part]) => two.get(pigment) === part);
}

/** The bytes of the arrays in something. */
function bytesIn(what: unknown): number {
  if (ArrayBuffer.isView(what)) return what.byteLength;
  if (typeof what !== "object" || what === null) return 0;
  return Object.values(what).reduce((sum: number, part) => sum + bytesIn(part), 0);
}

/** A line as JSON; times have more digits than JSON.stringify takes. */
function textOf(line: Line): string {
  const time = line.time_ns as bigint | undefined;
  if (time === undefined) return JSON.stringify(line);
  return `{"time_ns": ${time}, ${JSON.stringify({ ...line, time_ns: undefined }).slice(1)}`;
}

/** Refuse words that a page does not heed. */
function checkWords(row: Line, heeded: readonly string[], name: string, where: string): void {
  const odd = Object.keys(row).find((word) => !heeded.includes(word));
  if (odd !== undefined) throw new RecordingError(`${where}: a page does not play ${name} with ${odd}`);
}

function checkHead(head: Line): void {
  checkWords(head, HEAD_WORDS, "a recording", "line 1");
  const { space = "world", units, azimuth = "commanded" } = head;
  if (space !== "world") throw new RecordingError(`line 1: space is ${String(space)}; in a page it is the world`);
  if (azimuth !== "commanded" && azimuth !== "dragged")
    throw new RecordingError(`line 1: azimuth is ${String(azimuth)}; expected commanded or dragged`);
  for (const [name, unit] of Object.entries((units ?? {}) as Record<string, string>))
    if (UNITS[name] !== unit)
      throw new RecordingError(`line 1: the unit of ${name} is ${unit}; in a page it is ${UNITS[name]}`);
}

function sampleOf(line: string, row: Line, held: Pose, where: string): DeviceSample {
  const time = /"time_ns"\s*:\s*(-?\d+)/.exec(line);
  if (time === null) throw new RecordingError(`${where}: a sample has no time_ns`);
  if ((Number(row.buttons ?? 0) & ERASER) !== 0)
    throw new RecordingError(`${where}: a page does not play a stroke that the pen's other end erases`);
  return {
    timeNs: BigInt(time[1]),
    position: row.position as DeviceSample["position"],
    orientation: row.orientation as DeviceSample["orientation"],
    pressure: (row.pressure ?? null) as number | null,
    buttons: (row.buttons ?? 0) as number,
    objectPosition: held.position,
    objectOrientation: held.orientation,
    contact: (row.contact ?? null) as DeviceSample["contact"],
  };
}
