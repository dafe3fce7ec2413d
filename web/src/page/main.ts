/** The studio as a page. */

import type { DipAmount } from "../brush/brush";
import { KernelError } from "../core/kernels";
import type { Vector } from "../core/quaternion";
import { times } from "../core/vectors";
import { MULTI_AXIS } from "../device/six_dof";
import { hidOf, SpaceMouse, type HidDevice } from "../device/space_mouse";
import { SCORE, UnknownNameError, type Contents, type Fetch } from "../studio";
import { Ahead } from "./ahead";
import { ballAround, Camera } from "./camera";
import { carried } from "./carried";
import { askForFile, button, choice, element, note, numbered, save, section, slider, tick } from "./controls";
import { Panel, type Tab } from "./panel";
import { Copybook, usualLaidOut, type Guides, type LaidText } from "./copybook";
import { CopybookList } from "./copybook_list";
import { SealList, type CutSeal } from "./seal_list";
import { PASTE } from "../seal/pressing";
import { SealLines } from "../seal/stone";
import { handlingOf, type LayerEdit } from "./document";
import type { Piece, State, Told } from "./engine";
import { EngineClient } from "./engine_client";
import type { EngineCalls } from "./engine_worker";
import { LayerList } from "./layer_list";
import type { HandSettings, PointerInput } from "./hand";
import { Host } from "./host";
import { Keeper, type Keeping } from "./keeper";
import { MeshError, type Note } from "../files/mesh_error";
import { checkSize, SUFFIXES, UNITS_MM, UP_AXES, type Unit } from "../files/wanted";
import { bringObject, Cancelled, type OwnFile, type OwnObject } from "./own_object";
import type { PictureChange } from "./picture_feed";
import { Stage, StageError } from "./stage";
import { choose, language, named, say, sayNotes, type Texts } from "./texts";

// What SIMD is tried by: a function whose body is one instruction of it.
const SIMD = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15,
  253, 98, 11,
]); // prettier-ignore
const WHEEL_NOTCH = 1.0015; // nearer by this a unit of the wheel
const SEEN = 2000; // vertices, at most, that the picture is fitted to
const ERASER_END = 5; // the button that a pen's other end says
const RECORDING = /\.jsonl$/i;
const OWN_MM = 0.4;
const FINENESS_MM = [0.2, 0.3, 0.4, 0.6, 0.8, 1.6];
const SPEED_MM_S = 150.0; // of a 3-D mouse at full deflection
const TURN_RAD_S = 1.5;
const [RECENTRE, DIP, UNDO, REDO] = [1, 2, 4, 8]; // its buttons, as bits
const TAP_PX = 12; // that a tap may slip
const TAP_MS = 350; // that a tap of several fingers takes, at most
const SLIP_PX = 6; // that a finger goes before it paints,
const SLIP_MS = 90; // or how long it is alone
const STEP_PX = 40; // that a key turns, or moves
const KEY_ZOOM = 1.2;
const PLAYED_IN_S = 30.0; // at most
const SILENT_MS = 20_000; // that a host may be while it is asked for a file
const PALM_MS = 700; // after a pen's last word a touch is a palm

/** How a piece is opened. */
interface OpenOptions {
  signal?: AbortSignal; // it is not wanted any more
  material?: string;
  score?: string; // that is painted again
  playedIn?: number; // s, at most, while it is seen to grow; without, it is shown when it is done
  own?: OwnObject | null; // that somebody has brought
  isKept?: boolean; // whether the browser keeps it already
  brush?: string;
  ink?: string;
}

/** A piece that is painted on. */
interface Opened {
  readonly engine: EngineClient;
  readonly piece: Piece;
  readonly about: Contents["objects"][number];
  state: State;
}

/** What the page cannot do without. */
class Missing extends Error {
  constructor(
    readonly key: keyof Texts,
    readonly fields: Record<string, string | number> = {},
  ) {
    super(key);
  }
}

class Page {
  readonly #canvas = element<HTMLCanvasElement>("canvas");
  readonly #message = element("message");
  readonly #panel = new Panel(() => this.#resize());
  readonly #texts = new CopybookList({
    lay: (text) => this.#layText(text),
    sealSize: (mm) => this.#seals.setSize(mm),
    change: (number, words) => this.#changeTexts("changeText", number, words),
    remove: (number) => this.#changeTexts("removeText", number, this.#inHand().state.texts.length),
    place: (number) => this.#whenTapped(say("place"), (event) => this.#changeTexts("moveText", number, this.#inputOf(event))),
    write: (number) => void this.#write(number),
  });
  #copybook: Copybook | null = null;
  #fits: readonly (number | null)[] = []; // of each text the largest size, where it is too large
  readonly #seals = new SealList((seal) => this.#whenTapped(say("tapForSeal"), (event) => void this.#pressSeal(event, seal)));
  #sealLines: SealLines | null = null;
  #tapping: PointerEvent | null = null; // that is down there
  #tapped: ((event: PointerEvent) => void) | null = null; // what is done where the object is tapped next
  #writes = false; // a planned hand, or a painting that grows
  #plays = false; // the latter
  #opening: AbortController | null = null; // what is opened last, or was
  #nMarks = 0; // of the painting in hand, when it was asked whether it may go
  #asked: OwnFile | null = null; // that is being prepared
  readonly #layers = new LayerList((edit) => this.#restack(edit));
  readonly #files = new Map<string, Promise<ArrayBuffer>>();
  readonly #stage: Stage;
  readonly #ahead = new Ahead(this.#canvas);
  readonly #amount = Object.assign(document.createElement("div"), { className: "fields" }); // of a dip
  #contents: Contents | null = null;
  #opened: Opened | null = null; // the piece in hand
  #camera: Camera | null = null;
  #object = 0; // of `#objects`
  #own: OwnObject | null = null; // that was brought last
  #brush = "";
  #ink = "";
  #dipAlways = true;
  #erases = false;
  #spreads = false; // whether time passes for wet ink
  #press = 0.5;
  #drawn = false; // whether a frame is asked for
  #isMoved = false; // whether the object is seen as somebody has turned it
  #changes: PictureChange[] = []; // that are not shown yet
  #paintedToMs = 0.0; // up to when what the pointer did is in them
  #pointer: number | null = null; // that is down and paints
  #nBegun = 0; // strokes
  #nAsked = 0; // of the thread that paints, and not answered
  #touches = new Map<number, { x: number; y: number }>();
  #gesture = { beganMs: 0.0, fingers: 0, way: 0.0 }; // of the touches that are down, or were
  #alone: { down: PointerEvent; moves: PointerEvent[]; timer: ReturnType<typeof setTimeout> } | null = null; // a finger that may paint
  #turning: { pointer: number; pans: boolean; x: number; y: number } | null = null;
  #penAt = -Infinity;
  #isPenKnown = false;
  #fingersPaint = true;
  #keeper: Keeping | null = null;
  #mouse: SpaceMouse | null = null;
  #steeredMs = 0.0; // up to when it has steered
  #isSteered = false; // at the last frame

  constructor() {
    this.#stage = new Stage(this.#canvas);
    const lost = (event: Event): void => {
      event.preventDefault();
      this.tell("noWebGl");
    };
    this.#canvas.addEventListener("webglcontextlost", lost);
    this.#canvas.addEventListener("webglcontextrestored", () => this.#restore());
    this.#listen();
    this.#panel.show(matchMedia("(min-width: 1081px) and (min-height: 481px)").matches ? "more" : null);
    new ResizeObserver(() => this.#resize()).observe(this.#canvas);
  }

  readonly #fetch: Fetch = (name) => {
    let file = this.#files.get(name);
    if (file === undefined) {
      file = carried(name) ?? fetched(name);
      file.catch(() => this.#files.delete(name)); // it may be had later
      this.#files.set(name, file);
    }
    return file;
  };

  /** Say something in place of the picture. */
  tell(key: keyof Texts, fields: Record<string, string | number> = {}): void {
    showMessage(say(key, fields));
  }

  /** Say what went wrong. */
  fail(cause: unknown): void {
    this.#pointer = null;
    this.#ahead.end();
    if (cause instanceof Missing) this.tell(cause.key, cause.fields);
    else if (cause instanceof StageError) this.tell("noWebGl");
    else if (cause instanceof RangeError || (cause instanceof KernelError && /memory/.test(cause.message)))
      this.tell("noMemory");
    else this.tell("failed", { cause: cause instanceof Error ? cause.message : String(cause) });
    console.error(cause);
  }

  /** What can be painted on: the folder's, and what somebody has brought. */
  get #objects(): Contents["objects"] {
    const own = this.#own === null ? [] : [this.#own.about];
    return [...(this.#contents?.objects ?? []), ...own];
  }

  /** Whether what shows the page has the object, and keeps what is painted. */
  get #isHosted(): boolean {
    return this.#contents?.hosted === true;
  }

  /** Whether the piece is on what somebody has brought. */
  get #isOnOwn(): boolean {
    return this.#own !== null && this.#opened?.about === this.#own.about;
  }

  /** Open the piece that is kept, or the folder's first object. */
  async begin(): Promise<void> {
    const contents = JSON.parse(
      new TextDecoder().decode(await this.#fetch("contents.json")),
    ) as Contents;
    this.#contents = contents;
    this.#brush = contents.brushes[0].name;
    this.#ink = contents.inks[0].name;
    const { painting } = contents;
    const score = painting === undefined ? "" : new TextDecoder().decode(await this.#fetch(SCORE));
    this.#keeper = contents.hosted === true ? await Host.open()
      : await Keeper.open(painting === undefined ? "paint3d" : `paint3d ${painting.id}`); // prettier-ignore
    const text = (await this.#keeper?.read().catch(() => "")) ?? "";
    if (/begin_stroke|press_seal/.test(text) && text !== score) {
      const file = await this.#keeper?.readObject().catch(() => undefined);
      try {
        await this.#goOn(contents, text, this.#another(), { file, isKept: true });
        return;
      } catch (cause) {
        console.warn("the piece cannot be opened:", cause);
        save(new Blob([text], { type: "application/jsonl" }), "kept.score.jsonl"); // what is not opened is not lost
      }
    }
    if (painting === undefined) return this.open(contents, contents.objects[0], { signal: this.#another() });
    await this.#goOn(contents, score, this.#another(), { playedIn: 0.0 });
    this.#notice(say("replayNote"));
  }

  /** Give up what is being opened, for something else. */
  #another(): AbortSignal {
    this.#opening?.abort();
    this.#opening = new AbortController();
    this.#nMarks = this.#opened?.state.nMarks ?? 0;
    this.#asked = null;
    return this.#opening.signal;
  }

  /** Open something in place of the piece in hand, if that may be lost. */
  async #replace(name: string, work: (contents: Contents, signal: AbortSignal) => Promise<void>): Promise<void> {
    if (this.#isPainted && !confirm(say("leave"))) return this.showBar();
    await this.#tryToOpen(name, work);
  }

  /** Open something in place of the piece in hand, which stays where that is not wanted or cannot be. */
  async #tryToOpen(name: string, work: (contents: Contents, signal: AbortSignal) => Promise<void>): Promise<void> {
    const [contents, before] = [this.#contents, this.#inHand()];
    if (contents === null) return;
    const signal = this.#another();
    try {
      await work(contents, signal);
    } catch (cause) {
      if (this.#opening?.signal !== signal) return; // something else is being opened
      this.#asked = null;
      if (this.#opened !== before) return this.fail(cause);
      const said = cause instanceof Cancelled ? "" : say("notOpened", { name, cause: await this.#causeOf(cause) });
      this.#message.hidden = true;
      this.showBar();
      if (said === "") return;
      console.warn("it cannot be opened:", cause);
      this.#notice(said);
    }
  }

  /** Paint on a file's object. */
  async #bring(contents: Contents, file: OwnFile, signal: AbortSignal): Promise<void> {
    this.#asked = file;
    const own = await this.#prepared(contents, file, signal);
    await this.open(contents, own.about, { signal, own });
    if (own.notes.length > 0) this.#notice(say("told", { name: file.name, notes: await this.#inWords(...own.notes) }));
  }

  /** Notes on a file in the language that is spoken. */
  async #inWords(...notes: Note[]): Promise<string> {
    if (language() === "en") return sayNotes(notes, {});
    const read = async (): Promise<Record<string, string>> =>
      JSON.parse(new TextDecoder().decode(await this.#fetch("notes.zh.json"))) as Record<string, string>;
    return sayNotes(notes, await read().catch(() => ({})));
  }

  /** Have a file's object prepared, while it is said how far that is. */
  #prepared(contents: Contents, file: OwnFile, signal: AbortSignal): Promise<OwnObject> {
    const progress = (share: number): void => {
      if (!signal.aborted) this.#tellOf(say("reading", { name: file.name, percent: Math.round(100 * share) }));
    };
    progress(0);
    return bringObject(this.#fetch, contents, file, progress, signal);
  }

  /** Say how far it is with what is being opened, which may be cancelled. */
  #tellOf(text: string): void {
    showMessage(text, () => this.#opening?.abort());
  }

  /** Open what was dropped or chosen: a recording, or an object. */
  #openFile(file: File): void {
    void this.#replace(file.name, async (contents, signal) => {
      if (RECORDING.test(file.name)) {
        const text = await file.text();
        const own = this.#own;
        const isOn = headOf(text)?.mesh === own?.prepared.words.mesh;
        return this.#goOn(contents, text, signal, { file: isOn ? own?.file : undefined });
      }
      checkSize(file.size);
      const data = new Uint8Array(await file.arrayBuffer());
      if (signal.aborted) throw new Cancelled();
      return this.#bring(contents, { name: file.name, data, resolution: OWN_MM, wanted: {} }, signal);
    });
  }

  /** Say something below the picture for a while. */
  #notice(text: string): void {
    const hint = element("hint");
    hint.textContent = text;
    hint.classList.remove("done");
    setTimeout(() => hint.classList.add("done"), 8000);
  }

  /** Open the piece that a score of a page says, on a file where it is none of the folder's. */
  async #goOn(
    contents: Contents, text: string, signal: AbortSignal,
    { file, isKept, playedIn }: { file?: OwnFile; isKept?: boolean; playedIn?: number },
  ): Promise<void> {
    const head = headOf(text);
    if (head === null) throw new Missing("noHead");
    const [object, mm] = [String(head.object), Number(head.resolution_mm)];
    let about = contents.objects.find((one) => one.name === object && one.resolution === mm);
    let own: OwnObject | null = null;
    if (about === undefined && file !== undefined) {
      own = this.#own?.file === file && file.resolution === mm ? this.#own
        : await this.#prepared(contents, { ...file, resolution: mm }, signal);
      about = { ...own.about, name: object };
      own = { ...own, about };
    }
    if (about === undefined) {
      if (SUFFIXES.some((suffix) => object.toLowerCase().endsWith(suffix))) throw new Missing("ownFirst", { object });
      throw new Missing("noObject", { object, mm });
    }
    const ink = inkOf(contents, head.ink);
    if (ink === undefined) throw new Missing("noInk", { ink: JSON.stringify(head.ink) });
    await this.open(contents, about, {
      signal, score: text, own, isKept, playedIn, material: head.material as string | undefined, brush: String(head.brush), ink: ink.name,
    }); // prettier-ignore
  }

  /** Why something cannot be opened, in the language that is spoken. */
  async #causeOf(cause: unknown): Promise<string> {
    if (cause instanceof Missing) return say(cause.key, cause.fields);
    if (cause instanceof UnknownNameError) return say("noName", { kind: say(cause.kind), name: cause.unknown });
    if (cause instanceof MeshError) return this.#inWords(cause.note);
    return cause instanceof Error ? cause.message : String(cause);
  }

  /** Open an object, fresh, or as a score leaves it; nothing is changed where `signal` comes before it is ready. */
  async open(
    contents: Contents, about: Contents["objects"][number],
    {
      signal = this.#another(), material, score = "", playedIn, own = null, isKept = false, brush = this.#brush, ink = this.#ink,
    }: OpenOptions = {},
  ): Promise<void> {
    const goOn = (): void => {
      if (signal.aborted) throw new Cancelled();
    };
    goOn();
    this.tell("loading", { name: named(about) });
    const heard: Told[] = [];
    let listen = (told: Told): void => void heard.push(told);
    const listener = { told: (told: Told) => listen(told), failed: (cause: unknown) => this.fail(cause) };
    const words = {
      about, brush, ink, material, hand: this.#handSettings, handling: handlingOf(headOf(score) ?? {}),
      score: playedIn === undefined ? score : "",
      own: own === null ? null : { ...own.prepared, name: own.file.name },
    }; // prettier-ignore
    const progress = (share: number): void => {
      if (!signal.aborted) this.#tellOf(say("repeating", { percent: Math.round(100 * share) }));
    };
    const [engine, piece] = await EngineClient.open(this.#fetch, words, progress, listener, signal);
    let whole = "";
    try {
      goOn();
      if (score !== "" && headOf(score)?.mesh !== piece.mesh) throw new Missing("otherMesh", { object: named(about) });
      whole = await engine.call("score");
      goOn();
      // it was painted on while this was made ready
      if ((this.#opened?.state.nMarks ?? 0) > this.#nMarks && !confirm(say("leave"))) throw new Cancelled();
    } catch (cause) {
      engine.close();
      throw cause;
    }
    const told = heard[0];
    const keep = (text: string): void => this.#keeper?.begin(own?.file ?? null, text);
    const camera = playedIn !== undefined && this.#opened?.piece.mesh === piece.mesh ? this.#camera : null;
    if (isKept) this.#keeper?.append(told.score); // the end of a stroke without one
    else if (playedIn === undefined) keep(whole); // else when all of it is painted
    this.#opened?.engine.close();
    if (own !== null) this.#own = own;
    this.#asked = null;
    this.#opened = { engine, piece, about, state: told.state };
    if (score !== "") [brush, ink] = [told.state.brush, inkOf(contents, told.state.dipped)?.name ?? ink];
    [this.#brush, this.#ink] = [brush, ink];
    this.#object = this.#objects.indexOf(about);
    this.#show(piece, told.picture as PictureChange);
    listen = (later) => this.#hear(later);
    for (const later of heard.slice(1)) this.#hear(later);
    this.#spreads = piece.isPorous && contents.painting === undefined; // what was painted elsewhere is shown as it was left
    void this.#ask("setSpreads", this.#spreads);
    void this.#ask("setShown", !document.hidden);
    this.#tapped = this.#tapping = this.#pointer = this.#turning = null; // what is down was down on the piece before
    this.#touches.clear();
    this.#setWrites(false);
    if (told.state.texts.length > 0) await this.#openCopybook();
    else if (this.#copybook !== null) void this.#ask("openCopybook", contents.copybook?.file ?? "");
    if (this.#opening?.signal === signal) this.#message.hidden = true; // else something else is being opened
    this.showBar();
    if (camera === null) this.#showAll();
    else this.#camera = camera; // the same object, as it was seen
    this.draw();
    if (playedIn === undefined) return;
    await this.#play(score, playedIn);
    keep(score);
  }

  /** Let a painting grow on the bare object that is open, before anybody else paints on it. */
  async #play(score: string, playedIn: number): Promise<void> {
    const opened = this.#inHand();
    this.#setPlays(true);
    try {
      await opened.engine.call("play", score, playedIn);
    } finally {
      if (this.#opened === opened) this.#setPlays(false); // else something else is open by now
    }
  }

  #setPlays(on: boolean): void {
    this.#plays = on;
    this.#setWrites(on);
    this.showBar();
  }

  /** Show how the piece in hand was painted, from the bare object on. */
  async #replay(): Promise<void> {
    if (this.#plays) return void this.#ask("hurry");
    if (this.#writes || this.#pointer !== null || !this.#message.hidden) return; // or another piece is being opened
    const opened = this.#inHand();
    this.#setWrites(true); // what was done now would not be played
    const score = await this.#ask("score");
    const file = this.#isOnOwn ? this.#own?.file : undefined;
    if (score !== undefined && this.#opened === opened)
      await this.#tryToOpen(named(opened.about), (contents, signal) =>
        this.#goOn(contents, score, signal, { file, playedIn: PLAYED_IN_S }),
      );
    if (this.#opened === opened) this.#setWrites(false);
  }

  /** See an object from where it is painted best. */
  #show({ nBaseVertices: n, gloss }: Piece, picture: PictureChange): void {
    const [x, y, z] = picture.axes.map((axis) => axis.subarray(0, n));
    const [middle, radius] = ballAround(x, y, z, n);
    let [low, high] = [Infinity, -Infinity];
    for (const at of z) [low, high] = [Math.min(low, at), Math.max(high, at)];
    const flat = high - low < 0.01 * radius;
    const points: Vector[] = [];
    for (let i = 0; i < n; i += Math.ceil(n / SEEN)) points.push([x[i], y[i], z[i]]);
    this.#camera = new Camera(middle, radius, flat, points);
    this.#isMoved = false;
    this.#stage.open([x, y, z], gloss, flat);
    this.#stage.guide({ outlines: new Float32Array(), grid: new Float32Array() });
    this.#changes = [picture];
  }

  // -- the thread that paints -----------------------------------------------------------------

  /** Have something done to the painting, and say if it went wrong: what cannot be had now ends nothing. */
  async #ask<N extends keyof EngineCalls>(
    name: N, ...words: Parameters<EngineCalls[N]>
  ): Promise<Awaited<ReturnType<EngineCalls[N]>> | undefined> {
    const { engine } = this.#inHand();
    this.#nAsked++;
    try {
      return await engine.call(name, ...words);
    } catch (cause) {
      if (engine !== this.#opened?.engine) return undefined; // another piece is open by now
      if (cause instanceof Missing) this.#notice(say(cause.key, cause.fields));
      else this.fail(cause);
      return undefined;
    } finally {
      this.#nAsked--;
    }
  }

  /** Take up what is told of the painting. */
  #hear({ state, score, guides, fits, picture, paintedToMs }: Told): void {
    const opened = this.#inHand();
    const before = opened.state;
    opened.state = state;
    this.#keeper?.append(score);
    const differs = (name: keyof State): boolean => JSON.stringify(before[name]) !== JSON.stringify(state[name]);
    if (guides !== undefined) this.#stage.guide(guides);
    if (fits !== undefined) this.#fits = fits;
    if (differs("texts") || fits !== undefined) this.#showTexts();
    if (differs("layers") || differs("active")) this.#showLayers();
    if (differs("amount") && !this.#amount.contains(document.activeElement)) this.#showAmount();
    if (differs("brush") || differs("dipped")) this.#showInHand();
    else this.#showState();
    if (picture !== undefined) {
      this.#changes.push(picture);
      this.#paintedToMs = paintedToMs;
    }
    this.draw();
  }

  #inHand(): Opened {
    if (this.#opened === null) throw new Error("nothing is open");
    return this.#opened;
  }

  get #isPainted(): boolean {
    return this.#pointer !== null || this.#opened?.state.isPainted === true;
  }

  /** The browser has given back what it had taken of the picture. */
  #restore(): void {
    this.#stage.restore();
    this.#changes = [];
    if (this.#opened === null) return;
    if (this.#message.textContent === say("noWebGl")) this.#message.hidden = true; // else another piece is being opened
    void this.#ask("showAnew");
  }

  // -- the bar --------------------------------------------------------------------------------

  /** Show what there is to choose, in the language that is spoken. */
  showBar(): void {
    const [contents, opened] = [this.#contents, this.#opened];
    if (contents === null || opened === null) return;
    document.title = contents.painting?.title ?? say("title");
    element("hint").textContent = say(matchMedia("(pointer: coarse)").matches ? "hintTouch" : "hint");
    const objects = this.#objects.map((one) => `${named(one)} · ${say("size", { mm: one.resolution })}`);
    const filled = document.createElement("span");
    filled.id = "ink";
    for (const [key, value] of Object.entries({ role: "meter", "aria-valuemin": "0", "aria-valuemax": "100" }))
      filled.setAttribute(key, value);
    filled.setAttribute("aria-label", say("inkLeft"));
    filled.append(document.createElement("div"));
    const dip = button("dip", say("dip"), () => void this.#ask("dip", this.#ink), "dip");
    dip.append(filled);
    const erase = button("erase", say("erase"), () => this.#setErases(!this.#erases), "erase");
    erase.setAttribute("aria-pressed", String(this.#erases));
    element("tools").replaceChildren(
      choice("brush", say("brush"), contents.brushes.map(named),
        contents.brushes.findIndex((one) => one.name === this.#brush),
        (k) => void this.#takeBrush(contents.brushes[k].name)),
      choice("inks", say("ink"), contents.inks.map(named),
        contents.inks.findIndex((one) => one.name === this.#ink),
        (k) => this.#takeInk(contents.inks[k].name)),
      dip,
      erase,
    ); // prettier-ignore
    const tab = (id: Tab, text: string): HTMLElement => {
      const toggle = (): void => {
        this.#panel.toggle(id);
        if (id === "copybook" && this.#copybook === null)
          this.#openCopybook().catch((cause: unknown) => this.fail(cause));
        if (id === "copybook" && this.#sealLines === null)
          this.#openSeals().catch((cause: unknown) => this.fail(cause));
      };
      return this.#panel.opener(button(`show-${id}`, text, toggle, id));
    };
    const copybook = tab("copybook", say(contents.seals === undefined ? "copybook" : "copybookAndSeal"));
    copybook.hidden = contents.copybook === undefined && contents.seals === undefined;
    const next = this.#plays ? "toEnd" : "replay";
    const replay = button("replay", say(next), () => void this.#replay(), next);
    const isFirst = contents.painting !== undefined || this.#plays; // what one may want before all else
    element("acts").replaceChildren(
      ...(isFirst ? [replay] : []),
      button("undo", say("undo"), () => this.#step("undo"), "undo"),
      button("redo", say("redo"), () => this.#step("redo"), "redo"),
      button("whole", say("view"), () => this.#showAll(), "whole"),
      copybook,
      tab("layers", say("layers")),
      tab("save", say("keep")),
      tab("more", say("more")),
    );
    this.#panel.fill("copybook", this.#texts.element, this.#seals.element, this.#texts.source);
    this.#showSeals();
    this.#panel.fill("layers", this.#layers.element);
    this.#panel.fill("save",
      section(say("keep"),
        button("picture", say("picture"), () => this.#savePicture().catch((cause: unknown) => this.fail(cause))),
        button("score", say("score"), () => void this.#saveScore()),
        button("glb", "GLB", () => void this.#saveObject("glb")),
        button("ply", "PLY", () => void this.#saveObject("ply")),
        note(say(this.#keeper === null ? "notKept" : this.#isHosted ? "keptByHost" : "kept")),
        note(say("opens"))),
      section(say("goOn"),
        ...(isFirst ? [] : [replay]),
        button("load", say("load"), () =>
          askForFile(".jsonl", (file) => this.#openFile(file)))),
    ); // prettier-ignore
    this.#panel.fill("more",
      section(say("piece"),
        choice("object", say("object"), objects, this.#object, (k) => this.#change(k)),
        choice("material", say("material"), contents.materials.map(named),
          contents.materials.findIndex((one) => one.name === opened.piece.material),
          (k) => this.#change(this.#object, contents.materials[k].name)),
        ...this.#ownControls(),
        button("fresh", say("fresh"), () => this.#change(this.#object, opened.piece.material)),
        ...(this.#isHosted ? []
          : [button("own", say("ownObject"), () => askForFile(SUFFIXES.join(","), (file) => this.#openFile(file)))])),
      section(say("water"),
        tick("wet", say("spreads"), this.#spreads, (on) => this.#setSpreads(on)),
        button("dry", say("dry"), () => void this.#ask("dry"))),
      section(say("dipped"),
        this.#amount,
        tick("always", say("dipAlways"), this.#dipAlways, (on) => (this.#dipAlways = on))),
      section(say("hand"),
        slider("press", say("press"), this.#press, (value) => this.#setPress(value)),
        ...(navigator.maxTouchPoints === 0 ? []
          : [tick("fingers", say("fingersPaint"), this.#fingersPaint, (on) => this.#setFingersPaint(on))]),
        ...(hidOf() === null ? [] : [button("mouse", this.#mouseText(), () => this.#plug())])),
      section(say("page"), button("language", say("language"), () => this.#speak())),
    ); // prettier-ignore
    this.#showLayers();
    this.#showTexts();
    this.#showAmount();
    this.#showState();
  }

  /** Show how much a dip takes up, in percent of what a whole one does. */
  #showAmount(): void {
    const { amount } = this.#inHand().state;
    const part = (name: keyof DipAmount, range: readonly [number, number, number]): HTMLElement => {
      const change = (percent: number): void => void this.#ask("setAmount", { [name]: percent / 100 });
      return numbered(name, `${say(name)}, %`, Number((100 * amount[name]).toFixed(1)), range, () => {}, change);
    };
    this.#amount.replaceChildren(part("wetted", [0.1, 100, 0.1]), part("fullness", [5, 300, 5]));
  }

  /** How the file of one's own object is read. */
  #ownControls(): HTMLElement[] {
    if (!this.#isOnOwn || this.#own === null) return [];
    const { file } = this.#own;
    const again = (change: (before: OwnFile) => Partial<OwnFile>): void => {
      const before = this.#asked?.data === file.data ? this.#asked : file; // what was chosen just now holds
      void this.#replace(file.name, (contents, signal) => this.#bring(contents, { ...before, ...change(before) }, signal));
    };
    const told = say("asTold");
    const units = Object.keys(UNITS_MM) as Unit[];
    const chosen = <T>(all: readonly T[], one: T | undefined): number => (one === undefined ? 0 : all.indexOf(one) + 1);
    return [
      choice("unit", say("unit"), [told, ...units], chosen(units, file.wanted.unit),
        (k) => again(({ wanted }) => ({ wanted: { ...wanted, unit: k === 0 ? undefined : units[k - 1] } }))),
      choice("up", say("upAxis"), [told, ...UP_AXES], chosen(UP_AXES, file.wanted.up),
        (k) => again(({ wanted }) => ({ wanted: { ...wanted, up: k === 0 ? undefined : UP_AXES[k - 1] } }))),
      choice("fineness", say("fineness"), FINENESS_MM.map((mm) => say("size", { mm })), FINENESS_MM.indexOf(file.resolution),
        (k) => again(() => ({ resolution: FINENESS_MM[k] }))),
    ]; // prettier-ignore
  }

  // -- the copybook ---------------------------------------------------------------------------

  /** Have texts shown and written; what is needed for that is loaded first. */
  async #openCopybook(): Promise<void> {
    const file = this.#contents?.copybook?.file;
    if (file === undefined) return;
    const copybook = this.#copybook ?? this.#hadOf(Copybook.read(this.#fetch, file));
    [this.#copybook] = await Promise.all([copybook, this.#ask("openCopybook", file)]); // what writes has it, too
    this.#showTexts();
  }

  async #openSeals(): Promise<void> {
    const file = this.#contents?.seals?.file;
    if (file === undefined) return;
    this.#sealLines ??= await this.#hadOf(SealLines.read(this.#fetch, file));
    this.#showSeals();
  }

  /** What is loaded; null where it cannot be had, which is said. */
  async #hadOf<T>(loading: Promise<T>): Promise<T | null> {
    try {
      return await loading;
    } catch (cause) {
      if (!(cause instanceof Missing)) throw cause;
      this.#notice(say(cause.key, cause.fields));
      return null;
    }
  }

  #showSeals(): void {
    if (this.#sealLines !== null) this.#seals.show(this.#sealLines, this.#contents?.copybook === undefined);
  }

  /** Do something where the object is tapped next, rather than paint. */
  #whenTapped(notice: string, then: (event: PointerEvent) => void): void {
    this.#tapped = then;
    this.#notice(notice);
    if (element("veil").checkVisibility()) this.#panel.show(null); // which lies over the object
  }

  /** Press a seal where the pointer is, or say why it cannot be. */
  async #pressSeal(event: PointerEvent, seal: CutSeal): Promise<void> {
    const paste = this.#contents?.inks.find((one) => one.name === PASTE)?.name ?? this.#ink;
    const { origin, direction } = this.#inputOf(event);
    const came = await this.#ask("pressSeal", { origin, direction }, seal, paste);
    if (came === "beside") this.#whenTapped(say("tapForSeal"), (next) => void this.#pressSeal(next, seal));
    else if (came === "hidden") this.#notice(say("isHidden"));
    else if (came === "no touch") this.#notice(say("sealNoTouch"));
    else if (typeof came === "object") this.#notice(say("sealNoRoom", { cause: came.noRoom }));
  }

  /** Show what can be done with the texts. */
  #showTexts(): void {
    const { state, about } = this.#inHand();
    const [copybook, contents] = [this.#copybook, this.#contents?.copybook];
    if (copybook === null || contents === undefined) return;
    const laidOut = about.texts ?? contents.texts.map(usualLaidOut);
    this.#texts.show({ copybook, contents, texts: state.texts, laidOut, fits: this.#fits });
  }

  /** The lines that are shown to be written after. */
  guides(): { [lines in keyof Guides]: number[] } {
    const { outlines, grid } = this.#stage.guides;
    return { outlines: [...outlines], grid: [...grid] };
  }

  #changeTexts<N extends "layText" | "changeText" | "moveText" | "removeText">(name: N, ...words: Parameters<EngineCalls[N]>): void {
    this.#tapped = null; // it may have another number now
    void this.#ask(name, ...words);
  }

  /** Lay a new text in the middle of what is seen. */
  #layText(text: Partial<LaidText>): void {
    const camera = this.#camera;
    if (camera === null) return;
    this.#changeTexts("layText", text, camera.eye, camera.ray(...camera.centre, this.#aspect()) as Vector);
  }

  /** Have a planned hand write a text, by its brush. */
  async #write(number: number): Promise<void> {
    if (this.#copybook === null || this.#writes || this.#pointer !== null) return;
    const opened = this.#inHand();
    this.#setWrites(true);
    this.#notice(say("stopNote"));
    await this.#ask("write", number, this.#ink);
    if (this.#opened === opened) this.#setWrites(false);
  }

  /** Let a planned hand alone with the brush, or have it back. */
  #setWrites(on: boolean): void {
    this.#writes = on;
    for (const id of ["tools", "panel"]) element(id).inert = on;
  }

  #restack(edit: LayerEdit): void {
    void this.#ask("restack", edit, this.#inHand().state.layerKeys);
  }

  #showLayers(): void {
    const { layers, active } = this.#inHand().state;
    this.#layers.show(layers, active);
  }

  #showState(): void {
    const { canUndo, canRedo, canDry, isPainted, inkLeft } = this.#inHand().state;
    const isWriting = this.#writes && !this.#plays; // a planned hand, which can be stopped
    element<HTMLButtonElement>("undo").disabled = !canUndo && !isWriting;
    element<HTMLButtonElement>("redo").disabled = !canRedo;
    element<HTMLButtonElement>("dry").disabled = !canDry;
    element("hint").classList.toggle("done", isPainted);
    const share = Math.round(100 * inkLeft);
    element("ink").setAttribute("aria-valuenow", String(share));
    (element("ink").firstElementChild as HTMLElement).style.height = `${share}%`;
  }

  #speak(): void {
    choose(language() === "en" ? "zh" : "en");
    this.showBar();
  }

  #change(place: number, material?: string): void {
    const about = this.#objects[place];
    const own = about === this.#own?.about ? this.#own : null;
    void this.#replace(named(about), (contents, signal) => this.open(contents, about, { signal, material, own }));
  }

  async #takeBrush(name: string): Promise<void> {
    if (!this.#writes) await this.#ask("takeBrush", name);
    this.#showInHand(); // which may be the one before
  }

  #takeInk(name: string): void {
    this.#ink = name;
    this.#setErases(false);
    void this.#ask("dip", name);
  }

  /** 0 to 1: how firm a pen, and how heavy a mouse, presses. */
  #setPress(value: number): void {
    this.#press = value;
    void this.#ask("setHand", this.#handSettings);
  }

  get #handSettings(): HandSettings {
    return { firmness: 2.0 * this.#press, mousePressure: 0.7 * this.#press };
  }

  #setErases(on: boolean): void {
    this.#erases = on;
    element("erase").setAttribute("aria-pressed", String(on));
  }

  #setSpreads(on: boolean): void {
    this.#spreads = on;
    void this.#ask("setSpreads", on);
  }

  #showAll(): void {
    this.#isMoved = false;
    this.#resize();
  }

  #step(which: "undo" | "redo"): void {
    if (this.#writes && !this.#plays && which === "undo") return void this.#ask("stopWriting");
    if (this.#pointer !== null || this.#writes) return; // a stroke goes on
    this.#tapped = null; // the text may be gone
    if (which === "undo") element<HTMLButtonElement>("redo").disabled = false; // before it is told
    void this.#ask(which);
  }

  /** Show the brush and the ink that the painter has. */
  #showInHand(): void {
    const [contents, { state }] = [this.#contents, this.#inHand()];
    if (contents === null) return;
    const { brushes, inks } = contents;
    this.#brush = state.brush;
    this.#ink = inkOf(contents, state.dipped)?.name ?? this.#ink;
    const chosen = { brush: [brushes, this.#brush], inks: [inks, this.#ink] } as const;
    for (const [id, [all, name]] of Object.entries(chosen))
      element<HTMLSelectElement>(id).selectedIndex = all.findIndex((one) => one.name === name);
    this.#showState();
  }

  /** Whether the browser keeps all that was done. */
  get isKept(): boolean {
    return this.#nAsked === 0 && this.#keeper?.isUpToDate === true;
  }

  // -- a 3-D mouse ----------------------------------------------------------------------------

  #mouseText(): string {
    return this.#mouse === null ? say("connect") : say("disconnect", { name: this.#mouse.device.productName });
  }

  /** Connect a 3-D mouse that is chosen, or let go of the one that is. */
  #plug(): void {
    const [hid, mouse] = [hidOf(), this.#mouse];
    if (hid === null) return;
    if (mouse !== null) {
      this.#mouse = null;
      this.showBar();
      void mouse.stop();
      return;
    }
    SpaceMouse.choose(hid).then(
      (device) => (device === null ? undefined : this.#take(device)),
      (cause: unknown) => this.fail(cause),
    );
  }

  async #take(device: HidDevice): Promise<void> {
    try {
      const moved = (): void => {
        if (!this.#isSteered) this.#steeredMs = performance.now();
        this.draw();
      };
      const mouse = new SpaceMouse(device, moved, (buttons) => this.#press3d(buttons));
      await mouse.start();
      this.#mouse = mouse;
    } catch (cause) {
      const said = cause instanceof Error ? cause.message : String(cause);
      this.#notice(say("mouseRefused", { name: device.productName, cause: said }));
    }
    this.showBar();
  }

  /** Take a mouse that was allowed before, and hear of one that goes. */
  async findMouse(): Promise<void> {
    const hid = hidOf();
    if (hid === null) return;
    hid.addEventListener("disconnect", (event) => {
      if ((event as Event & { device: HidDevice }).device !== this.#mouse?.device) return;
      this.#mouse = null;
      this.showBar();
    });
    const isMouse = ({ collections }: HidDevice): boolean =>
      collections.some(({ usagePage, usage }) => usagePage === MULTI_AXIS.usagePage && usage === MULTI_AXIS.usage);
    const known = (await hid.getDevices()).find(isMouse);
    if (known !== undefined) await this.#take(known);
  }

  #press3d(buttons: number): void {
    if (this.#opened === null || this.#writes) return;
    if (buttons & RECENTRE) this.#showAll();
    if (buttons & DIP) void this.#ask("dip", this.#ink);
    if (buttons & UNDO) this.#step("undo");
    if (buttons & REDO) this.#step("redo");
  }

  /** Let the object move and turn as the cap is deflected. */
  #steer(now: number): void {
    const seconds = Math.min(now - this.#steeredMs, 100.0) * 1e-3;
    this.#steeredMs = now;
    const rates = this.#mouse?.deflectionAt(now) ?? null;
    this.#isSteered = rates !== null;
    if (rates === null || this.#camera === null) return;
    this.#isMoved = true;
    const [x, y, z, rx, ry, rz] = rates;
    this.#camera.steer(times([x, y, z], SPEED_MM_S * seconds), times([rx, ry, rz], TURN_RAD_S * seconds));
    this.draw(); // again, until it rests
  }

  // -- files ----------------------------------------------------------------------------------

  /** Save what is seen, as PNG. */
  async #savePicture(): Promise<void> {
    const camera = this.#camera;
    if (camera === null) return;
    await this.#ask("show");
    this.#drawNow(performance.now());
    if (!this.#isMoved) {
      camera.setFree([-1, 1, -1, 1]); // no panel lies over the picture
      camera.showAll(this.#aspect());
    }
    this.#stage.draw(camera, false);
    const seen = document.createElement("canvas");
    Object.assign(seen, { width: this.#canvas.width, height: this.#canvas.height });
    const context = seen.getContext("2d");
    if (context === null) return;
    context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--ground");
    context.fillRect(0, 0, seen.width, seen.height);
    context.drawImage(this.#canvas, 0, 0);
    this.#resize();
    const blob = await new Promise<Blob | null>((done) => seen.toBlob(done, "image/png"));
    if (blob === null) throw new Missing("noMemory");
    save(blob, `${this.#name()}.png`);
  }

  /** Save what was done, for `paint3d replay`. */
  async #saveScore(): Promise<void> {
    const text = await this.#ask("score");
    if (text !== undefined) save(new Blob([text], { type: "application/jsonl" }), `${this.#name()}.score.jsonl`);
  }

  async #saveObject(kind: "glb" | "ply"): Promise<void> {
    const name = this.#name();
    const blob = await (kind === "glb" ? this.#ask("glb", name) : this.#ask("ply"));
    if (blob !== undefined) save(blob, `${name}.${kind}`);
  }

  score(): Promise<string> {
    return this.#inHand().engine.call("score");
  }

  /** Wait until all that was asked is done and shown. */
  async shown(): Promise<void> {
    await this.#inHand().engine.call("show");
    this.#drawNow(performance.now()); // a page that is not looked at gets no frames
  }

  /** The SHA-256 of the colours and of the amounts, as they are shown then. */
  async hashes(): Promise<Record<string, string | number>> {
    await this.shown();
    return this.#inHand().engine.call("hashes");
  }

  #name(): string {
    const when = new Date().toISOString().slice(0, 19).replace(/[:T]/g, "-");
    return `${this.#inHand().about.name.replace(/\.\w+$/, "")}-${when}`;
  }

  // -- the picture ----------------------------------------------------------------------------

  #aspect(): number {
    return this.#canvas.width / Math.max(1, this.#canvas.height);
  }

  #resize(): void {
    const ratio = Math.min(2.0, devicePixelRatio);
    this.#canvas.width = Math.max(1, Math.round(this.#canvas.clientWidth * ratio));
    this.#canvas.height = Math.max(1, Math.round(this.#canvas.clientHeight * ratio));
    this.#camera?.setFree(this.#free());
    if (!this.#isMoved) this.#camera?.showAll(this.#aspect());
    this.draw();
  }

  /** What of the picture nothing lies over: left, right, bottom and top, -1 to 1. */
  #free(): [number, number, number, number] {
    const boxOf = (id: string): DOMRect => element(id).getBoundingClientRect();
    const [all, panel] = [this.#canvas.getBoundingClientRect(), boxOf("panel")];
    let [right, bottom, top] = [all.right, all.bottom, all.top];
    for (const row of [boxOf("tools"), boxOf("acts")])
      if (row.top > 0.5 * all.height) bottom = Math.min(bottom, row.top);
      else top = Math.max(top, row.bottom);
    if (panel.width >= all.width) bottom = Math.min(bottom, panel.top);
    else if (panel.width > 0) right = panel.left;
    const x = (at: number): number => (2.0 * (at - all.left)) / Math.max(1, all.width) - 1.0;
    const y = (at: number): number => 1.0 - (2.0 * (at - all.top)) / Math.max(1, all.height);
    return [x(all.left), x(right), y(bottom), y(top)];
  }

  /** Ask for a frame. */
  draw(): void {
    if (this.#drawn) return;
    this.#drawn = true;
    requestAnimationFrame((now) => {
      this.#drawn = false;
      this.#drawNow(now);
    });
  }

  #drawNow(now: number): void {
    if (this.#camera === null) return;
    try {
      this.#steer(now);
      const changes = this.#changes.splice(0);
      for (const change of changes) this.#stage.follow(change);
      this.#stage.draw(this.#camera);
      if (changes.length > 0) {
        const engine = this.#opened?.engine; // not by `#ask`: nothing is unkept until it has answered
        engine?.call("pictureShown").catch((cause: unknown) => engine === this.#opened?.engine && this.fail(cause));
        this.#ahead.shown(this.#paintedToMs);
      }
      this.#ahead.draw();
    } catch (cause) {
      this.fail(cause);
    }
  }

  // -- the hand -------------------------------------------------------------------------------

  #listen(): void {
    const canvas = this.#canvas;
    const heard = (work: (event: PointerEvent) => void) => (event: PointerEvent) => {
      if (this.#opened === null) return;
      event.preventDefault();
      if (event.type === "pointerdown" && !this.#message.hidden) return; // another piece is being opened
      try {
        work(event);
      } catch (cause) {
        this.fail(cause);
      }
    };
    canvas.addEventListener("pointerdown", heard((event) => this.#down(event)));
    canvas.addEventListener("pointermove", heard((event) => this.#move(event)));
    canvas.addEventListener("pointerup", heard((event) => this.#up(event)));
    canvas.addEventListener("pointercancel", heard((event) => this.#up(event)));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    const wheel = (event: WheelEvent): void => {
      event.preventDefault();
      const [x, y] = this.#placeOf(event);
      this.#isMoved = true;
      this.#camera?.zoom(WHEEL_NOTCH ** -event.deltaY, x, y, this.#aspect());
      this.draw();
    };
    canvas.addEventListener("wheel", wheel, { passive: false });
    element("veil").addEventListener("pointerdown", () => this.#panel.show(null));
    addEventListener("keydown", (event) => {
      const { target } = event;
      const isWritten = target instanceof HTMLTextAreaElement || (target instanceof HTMLInputElement && target.type === "text");
      if (this.#opened === null || event.isComposing) return;
      if (event.key === "Escape") {
        if (this.#pointer !== null) return this.#takeBack();
        if (this.#writes) return this.#step("undo");
        this.#panel.show(null);
      }
      if (isWritten) return;
      if (!event.ctrlKey && !event.metaKey) {
        const isControl = target instanceof HTMLSelectElement || target instanceof HTMLInputElement;
        if (!event.altKey && !isControl && !this.#writes && this.#obey(event)) event.preventDefault();
        return;
      }
      const letter = event.key.toLowerCase(); // also where capitals are locked
      const key = event.shiftKey ? `Shift+${letter}` : letter;
      const step = ({ z: "undo", y: "redo", "Shift+z": "redo" } as const)[key];
      if (step === undefined) return;
      event.preventDefault();
      this.#step(step);
    });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      const file = event.dataTransfer?.files[0];
      if (file === undefined || this.#opened === null || this.#writes) return;
      if (this.#isHosted && !RECORDING.test(file.name)) return; // who shows it has the object
      this.#openFile(file);
    });
    document.addEventListener("visibilitychange", () => {
      if (this.#opened !== null) void this.#ask("setShown", !document.hidden);
    });
    addEventListener("beforeunload", (event) => {
      if (this.#isPainted && !this.isKept) event.preventDefault();
    });
  }

  /** Do what a key stands for, as in the window; whether it stands for anything. */
  #obey({ key, shiftKey }: KeyboardEvent): boolean {
    const [camera, height] = [this.#camera, this.#canvas.clientHeight];
    const seen = (move: (camera: Camera) => void) => (): void => {
      if (camera === null) return;
      this.#isMoved = true;
      move(camera);
      this.draw();
    };
    const along = (x: number, y: number): (() => void) =>
      seen((one) => (shiftKey ? one.pan(STEP_PX * x, STEP_PX * y, height) : one.turn(STEP_PX * x, STEP_PX * y)));
    const zoom = (factor: number): (() => void) =>
      seen((one) => one.zoom(factor, ...one.centre, this.#aspect()));
    const brush = this.#contents?.brushes["1234567890".indexOf(key)];
    const act = {
      d: () => void this.#ask("dip", this.#ink),
      e: () => this.#setErases(!this.#erases),
      W: () => void this.#ask("dry"),
      Home: () => this.#showAll(),
      "+": zoom(KEY_ZOOM), "=": zoom(KEY_ZOOM), "-": zoom(1.0 / KEY_ZOOM),
      ArrowLeft: along(-1, 0), ArrowRight: along(1, 0), ArrowUp: along(0, -1), ArrowDown: along(0, 1),
    }[key] ?? (brush === undefined ? undefined : () => void this.#takeBrush(brush.name)); // prettier-ignore
    act?.();
    return act !== undefined;
  }

  #down(event: PointerEvent): void {
    this.#canvas.setPointerCapture(event.pointerId);
    if (event.pointerType === "pen") this.#meetPen(event);
    if (event.pointerType === "touch") {
      if (event.timeStamp - this.#penAt < PALM_MS || this.#strokeIsAPens()) return; // a palm
      if (this.#touches.size === 0) this.#gesture = { beganMs: event.timeStamp, fingers: 0, way: 0.0 };
      this.#touches.set(event.pointerId, { x: event.clientX, y: event.clientY });
      this.#gesture.fingers = Math.max(this.#gesture.fingers, this.#touches.size);
      if (this.#touches.size > 1) {
        this.#forgetTouch();
        return this.#takeBack();
      }
    }
    const isIdle = event.pointerType === "touch" && !this.#fingersPaint && this.#tapped === null;
    const turns = (event.button !== 0 && event.button !== ERASER_END) || event.altKey || isIdle;
    if (turns) {
      const pans = event.button === 1 || event.shiftKey;
      this.#turning = { pointer: event.pointerId, pans, x: event.clientX, y: event.clientY };
      return;
    }
    if (this.#pointer !== null || this.#writes) return;
    if (this.#tapped !== null) {
      this.#tapping = event; // until it is up: a second finger may come, to turn
      return;
    }
    if (event.pointerType !== "touch") return void this.#begin(event);
    this.#alone = { down: event, moves: [], timer: setTimeout(() => this.#paintAlone(), SLIP_MS) };
  }

  /** A finger that came alone has stayed so, or gone on: it paints. */
  #paintAlone(): void {
    if (this.#alone === null) return;
    const { down, moves, timer } = this.#alone;
    clearTimeout(timer);
    this.#alone = null;
    void this.#begin(down);
    for (const event of moves) this.#move(event);
  }

  /** What a finger has begun is nothing: another one has come, or a pen. */
  #forgetTouch(): void {
    clearTimeout(this.#alone?.timer);
    this.#alone = null;
    if (this.#turning !== null && this.#touches.has(this.#turning.pointer)) this.#turning = null;
  }

  /** A pen is there: what a hand has touched meanwhile is its palm, and fingers do not paint any more. */
  #meetPen(event: PointerEvent): void {
    this.#penAt = event.timeStamp;
    if (this.#pointer !== null && this.#touches.has(this.#pointer)) this.#takeBack();
    this.#forgetTouch();
    this.#touches.clear();
    if (this.#isPenKnown) return;
    this.#isPenKnown = true;
    this.#setFingersPaint(false);
  }

  #setFingersPaint(on: boolean): void {
    this.#fingersPaint = on;
    const shown = document.getElementById("fingers") as HTMLInputElement | null;
    if (shown !== null) shown.checked = on;
  }

  /** Begin a stroke, unless the pointer is beside the object, which it then turns. */
  async #begin(event: PointerEvent): Promise<void> {
    const { pointerId: pointer, clientX: x, clientY: y } = event;
    this.#pointer = pointer;
    const number = ++this.#nBegun;
    this.#ahead.end();
    const erases = this.#erases || event.button === ERASER_END;
    const came = await this.#ask("down", this.#inputOf(event), erases, this.#dipAlways && !erases ? this.#ink : null);
    if (came === "paints" || number !== this.#nBegun || this.#pointer === null) return; // or it is up again
    this.#pointer = null;
    this.#ahead.end();
    this.draw();
    if (came === "hidden") this.#notice(say("isHidden"));
    else if (came === "beside") this.#turning = { pointer, pans: false, x, y };
  }

  #strokeIsAPens(): boolean {
    return this.#pointer !== null && !this.#touches.has(this.#pointer);
  }

  /** A second finger came: what the first has painted was no stroke. */
  #takeBack(): void {
    this.#tapping = null;
    if (this.#pointer === null) return;
    this.#pointer = null;
    void this.#end(this.#ask("takeBack"));
  }

  async #end(ended: Promise<unknown>): Promise<void> {
    const number = this.#nBegun;
    await ended;
    if (number !== this.#nBegun) return; // another stroke is begun
    this.#ahead.end();
    this.draw();
  }

  #move(event: PointerEvent): void {
    if (event.pointerType === "pen") this.#meetPen(event);
    if (this.#alone?.down.pointerId === event.pointerId) {
      const { down, moves } = this.#alone;
      moves.push(event);
      if (Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) > SLIP_PX) this.#paintAlone();
      return;
    }
    if (this.#pointer === event.pointerId) {
      const all = event.getCoalescedEvents?.() ?? []; // Safari before 18, and hosts without TLS, have none
      const heard = all.length > 0 ? all : [event];
      void this.#ask("move", heard.map((one) => this.#inputOf(one)));
      this.#ahead.follow(heard, event.getPredictedEvents?.() ?? []);
      this.draw();
      return;
    }
    const touch = this.#touches.get(event.pointerId);
    if (touch !== undefined && this.#touches.size > 1) {
      this.#pinch(touch, event);
      return;
    }
    const turning = this.#turning;
    if (turning === null || turning.pointer !== event.pointerId) return;
    const [x, y] = [event.clientX - turning.x, event.clientY - turning.y];
    Object.assign(turning, { x: event.clientX, y: event.clientY });
    this.#isMoved = true;
    if (turning.pans) this.#camera?.pan(x, y, this.#canvas.clientHeight);
    else this.#camera?.turn(x, y);
    this.draw();
  }

  /** Two fingers: apart, nearer; both along, turn. A sheet is moved rather than turned; three do the other. */
  #pinch(touch: { x: number; y: number }, event: PointerEvent): void {
    const n = this.#touches.size;
    const [a, b] = [...this.#touches.values()];
    const apart = (): number => Math.max(10, Math.hypot(a.x - b.x, a.y - b.y));
    const before = apart();
    const [x, y] = [(event.clientX - touch.x) / n, (event.clientY - touch.y) / n];
    this.#gesture.way = Math.max(this.#gesture.way, n * Math.hypot(x, y));
    if (this.#gesture.way < TAP_PX && event.timeStamp - this.#gesture.beganMs < TAP_MS) return; // it may be a tap
    Object.assign(touch, { x: event.clientX, y: event.clientY });
    this.#isMoved = true;
    if (n === 2) {
      const at = this.#placeOf({ clientX: 0.5 * (a.x + b.x), clientY: 0.5 * (a.y + b.y) });
      this.#camera?.zoom(apart() / before, at[0], at[1], this.#aspect());
    }
    if ((n === 2) === this.#stage.flat) this.#camera?.pan(x, y, this.#canvas.clientHeight);
    else this.#camera?.turn(x, y);
    this.draw();
  }

  #up(event: PointerEvent): void {
    if (this.#alone?.down.pointerId === event.pointerId) {
      if (event.type === "pointercancel") this.#forgetTouch();
      else this.#paintAlone();
    }
    if (this.#touches.delete(event.pointerId) && this.#touches.size === 0) this.#tapFingers(event);
    if (this.#turning?.pointer === event.pointerId) this.#turning = null;
    if (this.#tapping?.pointerId === event.pointerId) this.#tap(this.#tapping, event);
    if (this.#pointer !== event.pointerId) return;
    this.#pointer = null;
    void this.#end(this.#ask("up", timeOf(event)));
    element<HTMLButtonElement>("undo").disabled = false; // before it is told: who is quick is heard
  }

  /** Fingers that came and went at once: two take back, three do again. */
  #tapFingers({ type, timeStamp }: PointerEvent): void {
    const { beganMs, fingers, way } = this.#gesture;
    if (type === "pointercancel" || way >= TAP_PX || timeStamp - beganMs >= TAP_MS) return;
    if (fingers === 2) this.#step("undo");
    if (fingers === 3) this.#step("redo");
  }

  /** What came down in one place has gone up: do what waits for it, unless it went elsewhere. */
  #tap(down: PointerEvent, up: PointerEvent): void {
    const [then, apart] = [this.#tapped, Math.hypot(up.clientX - down.clientX, up.clientY - down.clientY)];
    this.#tapping = null;
    if (then === null || up.type === "pointercancel" || apart > TAP_PX) return;
    this.#tapped = null;
    then(down);
  }

  #inputOf(event: PointerEvent): PointerInput {
    const camera = this.#camera;
    if (camera === null) throw new Error("nothing is open");
    const [x, y] = this.#placeOf(event);
    const [right, up] = camera.axes;
    return {
      timeNs: timeOf(event),
      origin: camera.eye,
      direction: camera.ray(x, y, this.#aspect()) as Vector,
      right,
      up,
      pressure: event.pointerType === "pen" ? event.pressure : null,
      xTilt: event.tiltX,
      yTilt: event.tiltY,
    };
  }

  /** A place of the picture, -1 to 1, y upwards. */
  #placeOf(event: { clientX: number; clientY: number }): [number, number] {
    const box = this.#canvas.getBoundingClientRect();
    return [
      (2.0 * (event.clientX - box.left)) / box.width - 1.0,
      1.0 - (2.0 * (event.clientY - box.top)) / box.height,
    ];
  }
}

/** The bytes of a file of this host, which may be slow, but not silent. */
async function fetched(name: string): Promise<ArrayBuffer> {
  const silence = new AbortController();
  const end = (): void => silence.abort(new DOMException(`nothing came for ${SILENT_MS / 1000} s`, "TimeoutError"));
  let timer = setTimeout(end, SILENT_MS);
  const transform = (part: Uint8Array, out: TransformStreamDefaultController): void => {
    clearTimeout(timer);
    timer = setTimeout(end, SILENT_MS);
    out.enqueue(part);
  };
  try {
    const answer = await fetch(name, { signal: silence.signal });
    if (!answer.ok) throw new Missing("noFile", { name, status: answer.status });
    return await new Response(answer.body?.pipeThrough(new TransformStream({ transform }))).arrayBuffer();
  } catch (cause) {
    throw cause instanceof Missing ? cause : new Missing("noFile", { name, status: String(cause) });
  } finally {
    clearTimeout(timer);
  }
}

/** When something came, ns. */
function timeOf(event: PointerEvent): bigint {
  return BigInt(Math.round(event.timeStamp * 1e6));
}

/** What a recording of a page says first; null where it is none. */
function headOf(text: string): Record<string, unknown> | null {
  try {
    const head = JSON.parse(text.split("\n", 1)[0]) as Record<string, unknown> | null;
    return head?.format === "paint3d-recording" ? head : null;
  } catch {
    return null;
  }
}

/** The ink of these parts. */
function inkOf(contents: Contents, parts: unknown): Contents["inks"][number] | undefined {
  return contents.inks.find((one) => JSON.stringify(one.parts) === JSON.stringify(parts));
}

/** Say something in place of the picture; what goes on meanwhile may be cancelled. */
function showMessage(text: string, cancel?: () => void): void {
  const message = element("message");
  const words = message.firstElementChild;
  if (words !== null && cancel !== undefined && !message.hidden) {
    words.textContent = text; // the button stays the same, so that a press of it is not lost
    return;
  }
  message.textContent = text;
  if (cancel !== undefined) {
    const said = document.createElement("p");
    said.textContent = text;
    message.replaceChildren(said, button("cancel", say("cancel"), cancel));
  }
  message.classList.add("said");
  message.hidden = false;
}

/** Begin, or say what this browser lacks. */
function start(): void {
  choose(language());
  if (typeof WebAssembly !== "object" || !WebAssembly.validate(SIMD))
    return showMessage(say("noWasm"));
  if (typeof DecompressionStream !== "function") return showMessage(say("noUnpacking"));
  let page: Page;
  try {
    page = new Page();
  } catch (cause) {
    if (cause instanceof StageError) return showMessage(say("noWebGl"));
    throw cause;
  }
  Object.assign(window, { paint3d: page });
  page.begin().catch((cause: unknown) => page.fail(cause));
  page.findMouse().catch((cause: unknown) => console.warn("no 3-D mouse:", cause));
}

start();
