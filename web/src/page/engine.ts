/**
 * A painting in a thread of its own: what the page asks of it, and what it tells the page to show. The
 * page's thread has the window, the camera and the picture; nothing that paints runs there.
 */

import type { Vector } from "../core/quaternion";
import { frameAt } from "../mesh/chart";
import type { DipAmount } from "../brush/brush";
import type { Bundle } from "../core/bundle";
import type { ObjectWords } from "../mesh/refined_mesh";
import { INK_STEP_S } from "../painter/painter";
import { NoRoomError, NoTouchError, USUAL_PRESSING } from "../seal/print";
import { Studio, type Contents, type Fetch } from "../studio";
import type { Layer } from "../surface/layer_stack";
import {
  Copybook, handFor, largestThatFits, USUAL, WritingHand, type Apex, type Guides, type LaidText,
} from "./copybook"; // prettier-ignore
import { Document, type Handling, type LayerEdit } from "./document";
import { glbOf, plyOf } from "./export";
import { Hand, type HandSettings, type PointerInput } from "./hand";
import { Pacing } from "./pacing";
import { PictureFeed, type PictureChange } from "./picture_feed";
import type { CutSeal } from "./seal_list";
import type { Gloss } from "./stage";

const MOST_BEHIND_MS = 200; // of wet ink's time, that is caught up with
const WRITTEN_FASTER = 3.0; // than the planned hand goes
const WRITTEN_EVERY_MS = 16;
const KEPT_EVERY_MS = 1000; // while a stroke, or wet ink, goes on
const APART_NS = 2_000_000n; // between two strokes, at least

/** How a piece is opened. */
export interface Opening {
  about: Contents["objects"][number];
  brush: string;
  ink: string;
  material?: string;
  own: Bundle<ObjectWords> | null; // an object that somebody has brought
  score: string; // that is painted again
  handling?: Handling;
  hand: HandSettings;
}

/** What the page knows of a painting. */
export interface State {
  canUndo: boolean;
  canRedo: boolean;
  canDry: boolean;
  isPainted: boolean;
  nMarks: number;
  inkLeft: number; // fraction of a full dip
  amount: DipAmount; // of the next dip
  brush: string;
  dipped: Record<string, number>; // parts by pigment
  layers: readonly Layer[];
  layerKeys: readonly number[]; // of each, the same wherever it is moved
  active: number;
  texts: readonly LaidText[];
}

/** What of it does not change. */
export interface Piece {
  mesh: string; // digest
  material: string;
  gloss: Gloss;
  isPorous: boolean;
  nBaseVertices: number;
}

/** What is told of a painting without being asked. */
export interface Told {
  state: State;
  score: string; // lines that came since, to be kept
  guides?: Guides;
  fits?: readonly (number | null)[]; // with guides: of each text `largestThatFits`
  picture?: PictureChange;
  paintedToMs: number; // up to when what the pointer did is painted, by its clock
}

export class Engine {
  readonly #hand: Hand;
  readonly #feed: PictureFeed;
  #copybook: Copybook | null = null;
  #guided: readonly LaidText[] = []; // whose lines were told
  #clockOffsetNs = 0n; // added to a pointer's time to get the painting's
  #paintedToMs = 0.0;
  #inStroke = false;
  #spreads = false; // whether time passes for wet ink
  #isShown = true;
  #timer: ReturnType<typeof setTimeout> | null = null;
  #passedMs = 0.0; // of that time
  #keptMs = 0.0;
  #pacing: Pacing | null = null; // of a score that is being played, or could not be to its end
  #stops = false; // a planned hand
  #mayPush = true; // no picture is on its way to the page
  #isDue = false; // something is to be told
  #amount: DipAmount | null = null; // of the next dip; null: as of the last

  private constructor(
    private readonly studio: Studio,
    private readonly painting: Document,
    settings: HandSettings,
    private readonly tell: (told: Told) => void,
    private readonly fail: (cause: unknown) => void,
  ) {
    this.#hand = new Hand(studio.kernels, studio.sizes, painting.closest, settings);
    this.#feed = new PictureFeed(painting);
  }

  /** Open a piece, fresh, or as a score leaves it; `progress` is told the share that is painted again. */
  static async open(
    fetch: Fetch, { about, brush, ink, material, own, score, handling, hand }: Opening, progress: (share: number) => void,
    tell: (told: Told) => void, fail: (cause: unknown) => void,
  ): Promise<Engine> {
    const studio = await Studio.open(fetch);
    const painting = await Document.open(studio, about, brush, ink, material, own, handling);
    if (score !== "") await painting.repeat(studio, score, progress);
    const engine = new Engine(studio, painting, hand, tell, fail);
    engine.#tellNow(true);
    return engine;
  }

  get piece(): Piece {
    const { surface } = this.painting;
    return {
      mesh: surface.object.words.mesh,
      material: surface.material.name,
      gloss: { roughness: surface.material.seen_roughness, paper: surface.material.paper },
      isPorous: surface.material.pores_mm > 0.0,
      nBaseVertices: surface.paintMesh.nBaseVertices,
    };
  }

  get #apex(): Apex {
    return (this.painting.surface.object.words.apex as Vector | undefined) ?? null;
  }

  get #state(): State {
    const { painting } = this;
    const { layers, keys, active } = painting.layers;
    return {
      canUndo: painting.canUndo || this.#inStroke, // of what is heard after its end
      canRedo: painting.canRedo,
      canDry: painting.canDry,
      isPainted: painting.isPainted,
      nMarks: painting.nMarks,
      inkLeft: Math.min(1.0, painting.painter.inkLeft()),
      amount: this.#nextAmount,
      brush: painting.painter.brush.name,
      dipped: painting.dipped,
      layers: layers.map((layer) => ({ ...layer })),
      layerKeys: keys,
      active,
      texts: painting.texts,
    };
  }

  // -- what is told ---------------------------------------------------------------------------

  /** The page has shown the last picture. */
  pictureShown(): void {
    this.#mayPush = true;
    if (this.#isDue) this.#tellNow();
  }

  /** Something has changed: tell it when what was heard meanwhile is painted too. */
  #changed(): void {
    this.#wake();
    if (this.#isDue) return;
    this.#isDue = true;
    if (this.#mayPush)
      setTimeout(() => {
        if (this.#isDue && this.#mayPush) this.#guard(() => this.#tellNow());
      });
  }

  /** Tell what has changed; `isDone`: all is to be kept; `withPicture`: also where the page has not shown the last one. */
  #tellNow(isDone = false, withPicture = this.#mayPush): void {
    const { painting } = this;
    const now = performance.now();
    const told: Told = { state: this.#state, score: "", paintedToMs: this.#paintedToMs };
    if (painting.texts !== this.#guided && this.#copybook !== null) {
      told.guides = this.#copybook.guides(painting.closest, painting.texts, this.#apex);
      told.fits = painting.texts.map((laid) => largestThatFits(painting.closest, laid, this.#apex));
      this.#guided = painting.texts;
    }
    if (withPicture) {
      told.picture = this.#feed.change();
      this.#mayPush = this.#isDue = false;
    }
    if (this.#pacing === null && (isDone || now - this.#keptMs > KEPT_EVERY_MS)) {
      this.#keptMs = now;
      told.score = painting.takeNew(); // last, as what is taken has to be told: the rest may fail
    }
    this.tell(told);
  }

  /** Do something to the painting, and tell what has changed. */
  #act<T>(work: () => T): T {
    const result = work();
    this.#isDue = true;
    this.#tellNow(true);
    this.#wake();
    return result;
  }

  #guard(work: () => void): void {
    try {
      work();
    } catch (cause) {
      this.fail(cause);
    }
  }

  // -- a hand ---------------------------------------------------------------------------------

  setHand(settings: HandSettings): void {
    Object.assign(this.#hand.settings, settings);
  }

  /** The brush comes down, dipped first where an ink is named; whether it paints, or why it does not. */
  down(input: PointerInput, erases: boolean, ink: string | null): "paints" | "beside" | "hidden" {
    const { painting } = this;
    if (this.#inStroke) this.#endStroke(painting.lastNs);
    const least = painting.lastNs + APART_NS;
    if (input.timeNs + this.#clockOffsetNs < least) this.#clockOffsetNs = least - input.timeNs;
    const { brush } = painting.painter;
    const samples = this.#hand.begin(this.#timed(input), brush);
    const { layers, active } = painting.layers;
    if (samples === null) return "beside";
    if (!layers[active].visible) {
      this.#hand.end(painting.lastNs, brush);
      return "hidden";
    }
    if (ink !== null) this.#dip(ink);
    painting.beginStroke(erases);
    this.#inStroke = true;
    painting.advance(samples);
    this.#changed();
    return "paints";
  }

  move(inputs: readonly PointerInput[]): void {
    if (!this.#inStroke) return;
    const { painting } = this;
    for (const input of inputs) {
      painting.advance(this.#hand.move(this.#timed(input), painting.painter.brush));
      this.#paintedToMs = Number(input.timeNs) * 1e-6;
    }
    this.#changed();
  }

  up(timeNs: bigint): void {
    if (this.#inStroke) this.#act(() => this.#endStroke(timeNs + this.#clockOffsetNs));
  }

  /** What was painted since the brush came down was no stroke. */
  takeBack(): void {
    if (!this.#inStroke) return;
    this.#act(() => {
      this.#endStroke(this.painting.lastNs);
      this.painting.undo();
    });
  }

  #endStroke(timeNs: bigint): void {
    const { painting } = this;
    this.#inStroke = false;
    painting.advance(this.#hand.end(timeNs, painting.painter.brush));
    painting.endStroke();
  }

  #timed(input: PointerInput): PointerInput {
    return { ...input, timeNs: input.timeNs + this.#clockOffsetNs };
  }

  // -- what is done between strokes -----------------------------------------------------------

  undo(): void {
    this.#act(() => this.painting.undo());
  }

  redo(): void {
    this.#act(() => this.painting.redo());
  }

  dry(): void {
    this.#act(() => this.painting.dry());
  }

  dip(ink: string): void {
    this.#act(() => this.#dip(ink));
  }

  get #nextAmount(): DipAmount {
    return this.#amount ?? this.painting.painter.amount;
  }

  #dip(ink: string): void {
    this.painting.dip(this.studio, ink, this.#amount);
    this.#amount = null;
  }

  /** How much the next dip takes up. */
  setAmount(change: Partial<DipAmount>): void {
    this.#amount = { ...this.#nextAmount, ...change };
    this.#changed();
  }

  async takeBrush(name: string): Promise<void> {
    const brush = await this.studio.brush(name);
    this.#act(() => this.painting.setBrush(brush));
  }

  /** Edit the layers, unless there are others by now than those that were shown, by their keys. */
  restack(edit: LayerEdit, shown: readonly number[]): void {
    const { keys } = this.painting.layers;
    if (edit.do === "add_layer" || String(shown) === String(keys)) this.#act(() => this.painting.restack(edit));
  }

  /** Press a seal where a ray meets the object; what came of it. */
  pressSeal(
    { origin, direction }: Pick<PointerInput, "origin" | "direction">, { rings, turn }: CutSeal, ink: string,
  ): "pressed" | "beside" | "hidden" | "no touch" | { noRoom: string } {
    const { painting, studio } = this;
    const found = painting.closest.cast(origin, direction);
    if (found === null) return "beside";
    const { layers, active } = painting.layers;
    if (!layers[active].visible) return "hidden";
    const { up } = frameAt(found, turn);
    try {
      this.#act(() => painting.pressSeal(studio, { rings, at: found.point, up, ink: studio.partsOf(ink), ...USUAL_PRESSING }));
    } catch (cause) {
      if (cause instanceof NoRoomError) return { noRoom: cause.message };
      if (cause instanceof NoTouchError) return "no touch";
      throw cause;
    }
    return "pressed";
  }

  // -- texts ----------------------------------------------------------------------------------

  /** Have the characters of a file shown, and written. */
  async openCopybook(file: string): Promise<void> {
    this.#copybook ??= await Copybook.read(this.studio.fetch, file);
    this.#guided = [];
    this.#act(() => {});
  }

  /** Lay a text where a ray meets the object, or as near as it can be told. */
  layText(text: Partial<LaidText>, origin: Vector, direction: Vector): void {
    const { closest } = this.painting;
    const point = closest.cast(origin, direction)?.point ?? closest.find([0, 0, 0]).point;
    this.#act(() => this.painting.layText({ ...USUAL, point, grid: "mi", ...text }));
  }

  /** Change a text that lies there. */
  changeText(number: number, words: Partial<LaidText>): void {
    const laid = this.painting.texts.at(number);
    if (laid !== undefined) this.#act(() => this.painting.layText({ ...laid, ...words }, number));
  }

  /** Move a text to where a ray meets the object, if it does. */
  moveText(number: number, { origin, direction }: Pick<PointerInput, "origin" | "direction">): void {
    const found = this.painting.closest.cast(origin, direction);
    if (found !== null) this.changeText(number, { point: found.point });
  }

  /** Take a text away, unless there are more or fewer by now than were shown. */
  removeText(number: number, nShown: number): void {
    if (this.painting.texts.length === nShown) this.#act(() => this.painting.removeText(number));
  }

  /** Have the planned hand stop, after its stroke. */
  stopWriting(): void {
    this.#stops = true;
  }

  /** Have a planned hand write a text, by its brush. */
  async write(number: number, ink: string): Promise<void> {
    const { painting, studio } = this;
    const { copybook } = studio.contents;
    const laid = painting.texts.at(number);
    if (copybook === undefined || laid === undefined || this.#inStroke) return;
    const planned = handFor(copybook, laid);
    if (planned === null) return;
    const [hand, brush] = await Promise.all([WritingHand.read(studio.fetch, planned), studio.brush(planned.brush)]);
    if (painting.painter.brush !== brush) painting.setBrush(brush);
    this.#stops = false;
    for (const stroke of hand.strokes(painting.closest, laid, this.#apex)) {
      if (this.#stops) return;
      this.#dip(ink);
      painting.beginStroke();
      try {
        const startNs = painting.lastNs + 500_000_000n;
        const began = performance.now();
        for (let done = 0; done < stroke.length; ) {
          await new Promise((next) => setTimeout(next, WRITTEN_EVERY_MS));
          const due = BigInt(Math.round(1e6 * WRITTEN_FASTER * (performance.now() - began)));
          const part = stroke.slice(done).filter(({ timeNs }) => timeNs <= due);
          painting.advance(part.map((one) => ({ ...one, timeNs: startNs + one.timeNs })));
          done += part.length;
          this.#changed();
        }
      } finally {
        painting.endStroke();
      }
      this.#act(() => {});
    }
  }

  /**
   * Play a score on the bare object, as it was painted, within so many seconds; 0: as fast as can be. None
   * of its lines is told to be kept, and where it fails, nothing that comes later: half of it is no piece.
   */
  async play(score: string, mostS: number): Promise<void> {
    const pacing = new Pacing(score, 1000.0 * mostS);
    this.#pacing = pacing;
    const pause = (line: number): Promise<void> | null => {
      const due = pacing.before(line);
      if (due !== null) this.#changed();
      return due;
    };
    await this.painting.repeat(this.studio, score, () => {}, pause);
    this.#pacing = null;
    this.#act(() => {});
  }

  /** Play the rest of a score at once. */
  hurry(): void {
    this.#pacing?.hurry();
  }

  // -- wet ink --------------------------------------------------------------------------------

  setSpreads(on: boolean): void {
    this.#spreads = on;
    this.#wake();
  }

  /** Time passes while the page is looked at. */
  setShown(on: boolean): void {
    this.#isShown = on;
    this.#tellNow(true);
    this.#wake();
  }

  get #passes(): boolean {
    return this.#spreads && this.#isShown && this.#pacing === null && !this.painting.surface.water.isStill;
  }

  /** Let time pass from now on, if there is something that it changes. */
  #wake(): void {
    if (this.#timer !== null || !this.#passes) return;
    this.#passedMs = performance.now();
    this.#awaitPiece();
  }

  #awaitPiece(): void {
    const due = this.#passedMs + 1000.0 * INK_STEP_S - performance.now();
    this.#timer = setTimeout(() => this.#guard(() => this.#letPass()), Math.max(0.0, due));
  }

  #letPass(): void {
    this.#timer = null;
    if (!this.#passes) return this.#tellNow(true); // all is dry, or not looked at
    this.#passedMs = Math.max(this.#passedMs + 1000.0 * INK_STEP_S, performance.now() - MOST_BEHIND_MS);
    this.painting.followTime();
    this.#awaitPiece();
    this.#changed();
  }

  // -- what is asked --------------------------------------------------------------------------

  /** Have the page show all that was done. */
  show(): void {
    this.#tellNow(true, true);
  }

  /** The same by a picture that is whole, where the page has lost it. */
  showAnew(): void {
    this.#feed.forget();
    this.#tellNow(true, true);
  }

  score(): string {
    return this.painting.score();
  }

  glb(name: string): Blob {
    return glbOf(this.painting.surface, name);
  }

  ply(): Blob {
    return plyOf(this.painting.surface);
  }

  /** The SHA-256 of the colours and of the amounts, as the tests compare them. */
  async hashes(): Promise<Record<string, string | number>> {
    const { surface } = this.painting;
    surface.refresh();
    const n = surface.nVertices;
    const sha = async (bytes: Uint8Array): Promise<string> => {
      const digest = await crypto.subtle.digest("SHA-256", bytes.slice());
      return [...new Uint8Array(digest)].map((b) => b.toString(16).padStart(2, "0")).join("");
    };
    return {
      vertices: n,
      srgb: await sha(surface.codes.bytes.subarray(0, 3 * n)),
      amounts: await sha(surface.ink.amounts.bytes.subarray(0, 4 * n * surface.pigments.length)),
    };
  }
}
