/** The studio as a page. */

import { breathe } from "../core/breathe";
import { KernelError } from "../core/kernels";
import type { Vector } from "../core/quaternion";
import { times } from "../core/vectors";
import { MULTI_AXIS } from "../device/six_dof";
import { hidOf, SpaceMouse, type HidDevice } from "../device/space_mouse";
import { PIECE_S } from "../painter/painter";
import { Studio, UnknownNameError, type Contents, type Fetch } from "../studio";
import { ballAround, Camera } from "./camera";
import { askForFile, button, choice, element, note, save, section, slider, tick } from "./controls";
import { Panel, type Tab } from "./panel";
import { Copybook, USUAL, type Guides, type LaidText } from "./copybook";
import { CopybookList } from "./copybook_list";
import { SealList, type CutSeal } from "./seal_list";
import { frameAt } from "../mesh/chart";
import { PASTE } from "../seal/pressing";
import { NoRoomError, NoTouchError, USUAL_PRESSING } from "../seal/print";
import { SealLines } from "../seal/stone";
import { Document, type LayerEdit } from "./document";
import { LayerList } from "./layer_list";
import { glbOf, plyOf } from "./export";
import { Hand, type PointerInput } from "./hand";
import { Keeper } from "./keeper";
import { MeshError, type Note } from "../files/mesh_error";
import { checkSize, SUFFIXES, UNITS_MM, UP_AXES, type Unit } from "../files/wanted";
import { bringObject, Cancelled, type OwnFile, type OwnObject } from "./own_object";
import { Stage, StageError } from "./stage";
import { choose, language, named, say, sayNotes, type Texts } from "./texts";

// What SIMD is tried by: a function whose body is one instruction of it.
const SIMD = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15,
  253, 98, 11,
]); // prettier-ignore
const WHEEL_NOTCH = 1.0015; // nearer by this a unit of the wheel
const SEEN = 2000; // vertices, at most, that the picture is fitted to
const MOST_BEHIND_MS = 200; // of wet ink's time, that is caught up with
const ERASER_END = 5; // the button that a pen's other end says
const WRITTEN_FASTER = 3.0; // than the planned hand goes
const RECORDING = /\.jsonl$/i;
const SLICE_MS = 40; // that the page works before it looks whether something is asked of it
const OWN_MM = 0.4;
const FINENESS_MM = [0.2, 0.3, 0.4, 0.6, 0.8, 1.6];
const SPEED_MM_S = 150.0; // of a 3-D mouse at full deflection
const TURN_RAD_S = 1.5;
const [RECENTRE, DIP, UNDO, REDO] = [1, 2, 4, 8]; // its buttons, as bits
const TAP_PX = 12; // that a tap may slip
const PALM_MS = 700; // after a pen's last word a touch is a palm

/** How a piece is opened. */
interface Opening {
  signal?: AbortSignal; // it is not wanted any more
  material?: string;
  score?: string; // that is painted again
  own?: OwnObject | null; // that somebody has brought
  isKept?: boolean; // whether the browser keeps it already
  brush?: string;
  ink?: string;
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
    lay: (text, number) => this.#layText(text, number),
    remove: (number) => this.#changeTexts(() => this.#opened().painting.removeText(number)),
    place: (number) => this.#whenTapped(say("place"), (event) => this.#place(event, number)),
    write: (number) => void this.#write(number),
  });
  #copybook: Copybook | null = null;
  readonly #seals = new SealList((seal) => this.#whenTapped(say("tapForSeal"), (event) => this.#pressSeal(event, seal)));
  #sealLines: SealLines | null = null;
  #tapping: PointerEvent | null = null; // that is down there
  #tapped: ((event: PointerEvent) => void) | null = null; // what is done where the object is tapped next
  #writes = false; // a planned hand
  #opening: AbortController | null = null; // what is opened last, or was
  #nMarks = 0; // of the painting in hand, when it was asked whether it may go
  #asked: OwnFile | null = null; // that is being prepared
  readonly #layers = new LayerList((edit) => this.#restack(edit));
  readonly #files = new Map<string, Promise<ArrayBuffer>>();
  readonly #stage: Stage;
  #studio: Studio | null = null;
  #painting: Document | null = null;
  #camera: Camera | null = null;
  #hand: Hand | null = null;
  #object = 0; // of `#objects`
  #own: OwnObject | null = null; // that was brought last
  #brush = "";
  #ink = "";
  #dipAlways = true;
  #erases = false;
  #spreads = false; // whether time passes for wet ink
  #passedMs = 0.0; // of that time
  #press = 0.5;
  #drawn = false; // whether a frame is asked for
  #isMoved = false; // whether the object is seen as somebody has turned it
  #changed: Int32Array[] = [];
  #pointer: number | null = null; // that is down and paints, as far as was heard
  #inStroke = false; // as far as was painted
  #events: PointerEvent[] = [];
  #touches = new Map<number, { x: number; y: number }>();
  #turning: { pointer: number; pans: boolean; x: number; y: number } | null = null;
  #penAt = -Infinity;
  #keeper: Keeper | null = null;
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
    this.#listen();
    this.#panel.show(matchMedia("(min-width: 1081px) and (min-height: 481px)").matches ? "more" : null);
    new ResizeObserver(() => this.#resize()).observe(this.#canvas);
  }

  readonly #fetch: Fetch = (name) => {
    let file = this.#files.get(name);
    if (file === undefined) {
      file = fetch(name).then(
        (answer) => {
          if (!answer.ok) throw new Missing("noFile", { name, status: answer.status });
          return answer.arrayBuffer();
        },
        (cause: unknown) => {
          throw new Missing("noFile", { name, status: String(cause) });
        },
      );
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
    this.#inStroke = false;
    this.#events = [];
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
    return [...(this.#studio?.contents.objects ?? []), ...own];
  }

  /** Whether the piece is on what somebody has brought. */
  get #isOnOwn(): boolean {
    return this.#own !== null && this.#painting?.about === this.#own.about;
  }

  /** Open the piece that is kept, or the folder's first object. */
  async begin(): Promise<void> {
    const contents = JSON.parse(
      new TextDecoder().decode(await this.#fetch("contents.json")),
    ) as Contents;
    this.#brush = contents.brushes[0].name;
    this.#ink = contents.inks[0].name;
    this.#keeper = await Keeper.open();
    const text = (await this.#keeper?.read().catch(() => "")) ?? "";
    if (/begin_stroke|press_seal/.test(text)) {
      const file = await this.#keeper?.readObject().catch(() => undefined);
      try {
        await this.#goOn(contents, text, this.#another(), { file, isKept: true });
        return;
      } catch (cause) {
        console.warn("the piece cannot be opened:", cause);
        save(new Blob([text], { type: "application/jsonl" }), "kept.score.jsonl"); // what is not opened is not lost
      }
    }
    await this.open(contents, contents.objects[0], { signal: this.#another() });
  }

  /** Give up what is being opened, for something else. */
  #another(): AbortSignal {
    this.#opening?.abort();
    this.#opening = new AbortController();
    this.#nMarks = this.#painting?.nMarks ?? 0;
    this.#asked = null;
    return this.#opening.signal;
  }

  /** Open something in place of the piece in hand, which stays where that is not wanted or cannot be. */
  async #replace(name: string, work: (contents: Contents, signal: AbortSignal) => Promise<void>): Promise<void> {
    const { studio, painting } = this.#opened();
    if (painting.isPainted && !confirm(say("leave"))) return this.showBar();
    const signal = this.#another();
    try {
      await work(studio.contents, signal);
    } catch (cause) {
      if (this.#opening?.signal !== signal) return; // something else is being opened
      this.#asked = null;
      if (this.#painting !== painting) return this.fail(cause);
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
        const isOn = headOf(text)?.mesh === own?.bundle.words.mesh;
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
    contents: Contents, text: string, signal: AbortSignal, { file, isKept }: { file?: OwnFile; isKept?: boolean },
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
      signal, score: text, own, isKept, material: head.material as string | undefined, brush: String(head.brush), ink: ink.name,
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
    { signal = this.#another(), material, score = "", own = null, isKept = false, brush = this.#brush, ink = this.#ink }: Opening = {},
  ): Promise<void> {
    const goOn = (): void => {
      if (signal.aborted) throw new Cancelled();
    };
    goOn();
    this.tell("loading", { name: named(about) });
    // its own kernels, whose memory goes with them
    const studio = await Studio.open(this.#fetch);
    goOn();
    const painting = await Document.open(studio, about, brush, ink, material, own?.bundle);
    if (score !== "") {
      const isSame = headOf(score)?.mesh === painting.surface.object.words.mesh;
      if (!isSame) throw new Missing("otherMesh", { object: named(about) });
      let since = performance.now();
      await painting.repeat(studio, score, async (share) => {
        if (performance.now() - since < SLICE_MS) return;
        goOn();
        this.#tellOf(say("repeating", { percent: Math.round(100 * share) }));
        await breathe();
        goOn();
        since = performance.now();
      });
      brush = painting.painter.brush.name;
      ink = inkOf(contents, painting.dipped)?.name ?? ink;
    }
    await breathe();
    goOn();
    // it was painted on while this was made ready
    if (this.#painting !== null && this.#painting.nMarks > this.#nMarks && !confirm(say("leave"))) throw new Cancelled();
    const text = painting.takeNew();
    if (!isKept) {
      this.#keeper?.begin(own?.file ?? null);
      this.#keeper?.append(text);
    }
    this.#pointer = null; // a stroke of the piece before
    this.#inStroke = false;
    this.#events = [];
    [this.#brush, this.#ink] = [brush, ink];
    if (own !== null) this.#own = own;
    this.#asked = null;
    this.#studio = studio;
    this.#object = this.#objects.indexOf(about);
    this.#painting = painting;
    const { arrays, nBaseVertices: n } = painting.surface.paintMesh;
    const [middle, radius] = ballAround(arrays.px.data, arrays.py.data, arrays.pz.data, n);
    const z = arrays.pz.data;
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < n; i++) [low, high] = [Math.min(low, z[i]), Math.max(high, z[i])];
    const flat = high - low < 0.01 * radius;
    const points: Vector[] = [];
    for (let i = 0; i < n; i += Math.ceil(n / SEEN)) points.push([arrays.px.data[i], arrays.py.data[i], z[i]]);
    this.#camera = new Camera(middle, radius, flat, points);
    this.#isMoved = false;
    this.#spreads = painting.surface.material.pores_mm > 0.0;
    this.#hand = new Hand(studio.kernels, studio.sizes, painting.closest, {
      firmness: 1.0, mousePressure: 0.0,
    }); // prettier-ignore
    this.#setPress(this.#press);
    this.#stage.open(painting, flat);
    await breathe();
    this.#tapped = this.#tapping = this.#pointer = this.#turning = null; // whatever went up meanwhile
    this.#touches.clear();
    this.#events = [];
    this.#inStroke = false;
    if (painting.texts.length > 0) await this.#openCopybook();
    else this.#showTexts();
    if (this.#opening?.signal === signal) this.#message.hidden = true; // else something else is being opened
    this.showBar();
    this.#showAll();
    this.draw();
  }

  // -- the bar --------------------------------------------------------------------------------

  /** Show what there is to choose, in the language that is spoken. */
  showBar(): void {
    const studio = this.#studio;
    if (studio === null) return;
    const { contents } = studio;
    document.title = say("title");
    element("hint").textContent = say(matchMedia("(pointer: coarse)").matches ? "hintTouch" : "hint");
    const objects = this.#objects.map((one) => `${named(one)} · ${say("size", { mm: one.resolution })}`);
    const filled = document.createElement("span");
    filled.id = "ink";
    for (const [key, value] of Object.entries({ role: "meter", "aria-valuemin": "0", "aria-valuemax": "100" }))
      filled.setAttribute(key, value);
    filled.setAttribute("aria-label", say("inkLeft"));
    filled.append(document.createElement("div"));
    const dip = button("dip", say("dip"), () => this.#act(() => this.#dip()), "dip");
    dip.append(filled);
    const erase = button("erase", say("erase"), () => this.#setErases(!this.#erases), "erase");
    erase.setAttribute("aria-pressed", String(this.#erases));
    element("tools").replaceChildren(
      choice("brush", say("brush"), contents.brushes.map(named),
        contents.brushes.findIndex((one) => one.name === this.#brush),
        (k) => this.#takeBrush(contents.brushes[k].name)),
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
    element("acts").replaceChildren(
      button("undo", say("undo"), () => this.#step(() => this.#opened().painting.undo()), "undo"),
      button("redo", say("redo"), () => this.#step(() => this.#opened().painting.redo()), "redo"),
      button("whole", say("view"), () => this.#showAll(), "whole"),
      copybook,
      tab("layers", say("layers")),
      tab("save", say("keep")),
      tab("more", say("more")),
    );
    this.#panel.fill("copybook", this.#texts.element, this.#seals.element);
    this.#showSeals();
    this.#panel.fill("layers", this.#layers.element);
    this.#panel.fill("save",
      section(say("keep"),
        button("picture", say("picture"), () => void this.savePicture()),
        button("score", say("score"), () => this.saveScore()),
        button("glb", "GLB", () => save(glbOf(this.#opened().painting.surface, this.#name()), `${this.#name()}.glb`)),
        button("ply", "PLY", () => save(plyOf(this.#opened().painting.surface), `${this.#name()}.ply`)),
        note(say(this.#keeper === null ? "notKept" : "kept"))),
      section(say("goOn"),
        button("load", say("load"), () =>
          askForFile(".jsonl", (file) => this.#openFile(file)))),
    ); // prettier-ignore
    this.#panel.fill("more",
      section(say("piece"),
        choice("object", say("object"), objects, this.#object, (k) => this.#change(k)),
        choice("material", say("material"), contents.materials.map(named),
          contents.materials.findIndex((one) => one.name === this.#painting?.surface.material.name),
          (k) => this.#change(this.#object, contents.materials[k].name)),
        ...this.#ownControls(),
        button("fresh", say("fresh"), () => this.#change(this.#object, this.#painting?.surface.material.name)),
        button("own", say("ownObject"), () => askForFile(SUFFIXES.join(","), (file) => this.#openFile(file)))),
      section(say("water"),
        tick("wet", say("spreads"), this.#spreads, (on) => this.#setSpreads(on)),
        button("dry", say("dry"), () => this.#act(() => this.#opened().painting.dry()))),
      section(say("hand"),
        slider("press", say("press"), this.#press, (value) => this.#setPress(value)),
        tick("always", say("dipAlways"), this.#dipAlways, (on) => (this.#dipAlways = on)),
        ...(hidOf() === null ? [] : [button("mouse", this.#mouseText(), () => this.#plug())])),
      section(say("page"), button("language", say("language"), () => this.#speak())),
    ); // prettier-ignore
    this.#showLayers();
    this.#showTexts();
    this.#showState();
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

  async #openCopybook(): Promise<void> {
    const { contents } = this.#opened().studio;
    if (contents.copybook === undefined) return;
    this.#copybook ??= await Copybook.read(this.#fetch, contents.copybook.file);
    this.#showTexts();
  }

  async #openSeals(): Promise<void> {
    const { contents } = this.#opened().studio;
    if (contents.seals === undefined) return;
    this.#sealLines ??= await SealLines.read(this.#fetch, contents.seals.file);
    this.#showSeals();
  }

  #showSeals(): void {
    const { contents } = this.#opened().studio;
    if (this.#sealLines !== null) this.#seals.show(this.#sealLines, contents.copybook === undefined);
  }

  /** Do something where the object is tapped next, rather than paint. */
  #whenTapped(notice: string, then: (event: PointerEvent) => void): void {
    this.#tapped = then;
    this.#notice(notice);
    if (element("veil").checkVisibility()) this.#panel.show(null); // which lies over the object
  }

  /** Press a seal where the pointer is, or say why it cannot be. */
  #pressSeal(event: PointerEvent, { rings, turn }: CutSeal): void {
    const { painting, studio } = this.#opened();
    const { origin, direction } = this.#inputOf(event);
    const found = painting.closest.cast(origin, direction);
    if (found === null) return this.#whenTapped(say("tapForSeal"), (next) => this.#pressSeal(next, { rings, turn }));
    const { layers } = painting;
    if (!layers.layers[layers.active].visible) return this.#notice(say("isHidden"));
    const paste = studio.contents.inks.find((one) => one.name === PASTE)?.name ?? this.#ink;
    this.#act(() => {
      this.#paint(); // what was heard since the last frame
      const { up } = frameAt(found, turn);
      try {
        painting.pressSeal(studio, { rings, at: found.point, up, ink: studio.partsOf(paste), ...USUAL_PRESSING });
      } catch (cause) {
        if (cause instanceof NoRoomError) this.#notice(say("sealNoRoom", { cause: cause.message }));
        else if (cause instanceof NoTouchError) this.#notice(say("sealNoTouch"));
        else throw cause;
      }
    });
  }

  /** Show the texts, and their lines on the object. */
  #showTexts(): void {
    const { painting, studio } = this.#opened();
    if (this.#copybook !== null)
      this.#texts.show(this.#copybook, painting.texts, studio.contents.copybook?.text ?? "");
    this.#stage.guide(this.guides());
    this.draw();
  }

  /** The lines that are shown to be written after, their points in pairs, mm. */
  guides(): Guides {
    const { closest, texts } = this.#opened().painting;
    const all = texts.flatMap((text) => this.#copybook?.guides(closest, text) ?? []);
    return {
      outlines: all.flatMap(({ outlines }) => outlines),
      grid: all.flatMap(({ grid }) => grid),
    };
  }

  #changeTexts(change: () => void): void {
    this.#tapped = null; // it may have another number now
    this.#act(() => {
      this.#paint(); // what was heard since the last frame
      change();
    });
    this.#showTexts();
  }

  /** Lay a text; a new one in the middle of what is seen. */
  #layText(text: Partial<LaidText>, number?: number): void {
    const { painting, camera } = this.#opened();
    const middle = camera.ray(...camera.centre, this.#aspect()) as Vector;
    const point = painting.closest.cast(camera.eye, middle)?.point ?? painting.closest.find([0, 0, 0]).point;
    this.#changeTexts(() => painting.layText({ ...USUAL, point, grid: "mi", ...text }, number));
  }

  /** The text that waits for it goes where the pointer is. */
  #place(event: PointerEvent, number: number): void {
    const { painting } = this.#opened();
    const { origin, direction } = this.#inputOf(event);
    const found = painting.closest.cast(origin, direction);
    if (found !== null) this.#layText({ ...painting.texts[number], point: found.point }, number);
  }

  /** Have a planned hand write a text, by its brush. */
  async #write(number: number): Promise<void> {
    const { painting, studio } = this.#opened();
    const copybook = this.#copybook;
    if (copybook === null || this.#writes || this.#pointer !== null) return;
    this.#setWrites(true);
    try {
      this.#paint(); // what was heard since the last frame
      const brush = await studio.brush(copybook.brush);
      if (painting.painter.brush !== brush) painting.setBrush(brush);
      for (const stroke of copybook.strokes(painting.closest, painting.texts[number])) {
        painting.dip(studio, this.#ink);
        painting.beginStroke();
        try {
          const startNs = painting.lastNs + 500_000_000n;
          const began = performance.now();
          for (let done = 0; done < stroke.length; ) {
            const now = await new Promise<number>((next) => requestAnimationFrame(next));
            if (this.#painting !== painting) return; // another object was opened
            const due = BigInt(Math.round(1e6 * WRITTEN_FASTER * Math.max(0.0, now - began)));
            const part = stroke.slice(done).filter(({ timeNs }) => timeNs <= due);
            painting.advance(part.map((one) => ({ ...one, timeNs: startNs + one.timeNs })));
            done += part.length;
            this.#refresh();
          }
        } finally {
          painting.endStroke();
        }
        this.#refresh();
      }
    } catch (cause) {
      this.fail(cause);
    } finally {
      this.#setWrites(false);
      this.#keep();
      this.#showInHand();
    }
  }

  /** Let a planned hand alone with the brush, or have it back. */
  #setWrites(on: boolean): void {
    this.#writes = on;
    for (const id of ["tools", "panel"]) element(id).inert = on;
  }

  #restack(edit: LayerEdit): void {
    this.#act(() => {
      this.#paint(); // what was heard since the last frame
      this.#opened().painting.restack(edit);
    });
    this.#showLayers();
  }

  #showLayers(): void {
    this.#layers.show(this.#opened().painting.layers);
  }

  #showState(): void {
    const painting = this.#painting;
    if (painting === null) return;
    element<HTMLButtonElement>("undo").disabled = !painting.canUndo;
    element<HTMLButtonElement>("redo").disabled = !painting.canRedo;
    element<HTMLButtonElement>("dry").disabled = !painting.canDry;
    element("hint").classList.toggle("done", painting.isPainted);
    const share = Math.round(100 * Math.min(1.0, painting.painter.inkLeft()));
    element("ink").setAttribute("aria-valuenow", String(share));
    (element("ink").firstElementChild as HTMLElement).style.height = `${share}%`;
  }

  #speak(): void {
    choose(language() === "en" ? "zh" : "en");
    this.showBar();
  }

  #change(place: number, material?: string): void {
    if (this.#studio === null) return;
    const about = this.#objects[place];
    const own = about === this.#own?.about ? this.#own : null;
    void this.#replace(named(about), (contents, signal) => this.open(contents, about, { signal, material, own }));
  }

  #takeBrush(name: string): void {
    const { studio, painting } = this.#opened();
    studio.brush(name).then(
      (brush) => {
        this.#act(() => painting.setBrush(brush));
        this.#showInHand();
      },
      (cause: unknown) => this.fail(cause),
    );
  }

  #takeInk(name: string): void {
    this.#ink = name;
    this.#setErases(false);
    this.#act(() => this.#dip());
  }

  #dip(): void {
    const { studio, painting } = this.#opened();
    painting.dip(studio, this.#ink);
  }

  /** 0 to 1: how firm a pen, and how heavy a mouse, presses. */
  #setPress(value: number): void {
    this.#press = value;
    if (this.#hand === null) return;
    this.#hand.settings.firmness = 2.0 * value;
    this.#hand.settings.mousePressure = 0.7 * value;
  }

  #setErases(on: boolean): void {
    this.#erases = on;
    element("erase").setAttribute("aria-pressed", String(on));
  }

  #setSpreads(on: boolean): void {
    this.#spreads = on;
    this.draw();
  }

  /** Let time pass for wet ink: as much as a frame has room for, and none where all is dry. */
  #letPass(now: number): void {
    const painting = this.#painting;
    const since = now - this.#passedMs;
    if (painting === null || !this.#spreads || painting.surface.water.isStill) {
      this.#passedMs = now;
      return;
    }
    this.draw(); // again, until it is dry
    if (since < 1000.0 * PIECE_S) return;
    this.#passedMs = Math.max(this.#passedMs + 1000.0 * PIECE_S, now - MOST_BEHIND_MS);
    painting.followTime();
    this.#changed.push(painting.surface.refresh());
    if (painting.surface.water.isStill) this.#showState(); // all is dry
  }

  #showAll(): void {
    this.#isMoved = false;
    this.#resize();
  }

  /** Undo or redo; what is in hand is shown as it is then. */
  #step(take: () => void): void {
    if (this.#pointer !== null || this.#writes) return; // a stroke goes on
    this.#tapped = null; // the text may be gone
    this.#act(() => {
      this.#paint(); // what was heard since the last frame
      take();
    });
    this.#showInHand();
    this.#showLayers();
    this.#showTexts();
  }

  /** Show the brush and the ink that the painter has. */
  #showInHand(): void {
    const { painting, studio } = this.#opened();
    const { brushes, inks } = studio.contents;
    this.#brush = painting.painter.brush.name;
    this.#ink = inkOf(studio.contents, painting.dipped)?.name ?? this.#ink;
    const chosen = { brush: [brushes, this.#brush], inks: [inks, this.#ink] } as const;
    for (const [id, [all, name]] of Object.entries(chosen))
      element<HTMLSelectElement>(id).selectedIndex = all.findIndex((one) => one.name === name);
    this.#showState();
  }

  /** Keep in the browser what was done. */
  #keep(): void {
    if (!this.#inStroke) this.#keeper?.append(this.#painting?.takeNew() ?? "");
  }

  get isKept(): boolean {
    return this.#keeper?.isUpToDate === true;
  }

  /** Do something to the painting, and show it. */
  #act(work: () => void): void {
    try {
      work();
      this.#keep();
      this.#refresh();
    } catch (cause) {
      this.fail(cause);
    }
  }

  #refresh(): void {
    const { painting } = this.#opened();
    this.#changed.push(painting.surface.refresh());
    this.#showState();
    this.draw();
  }

  #opened(): { studio: Studio; painting: Document; camera: Camera; hand: Hand } {
    const [studio, painting, camera, hand] = [this.#studio, this.#painting, this.#camera, this.#hand];
    if (studio === null || painting === null || camera === null || hand === null)
      throw new Error("nothing is open");
    return { studio, painting, camera, hand };
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
    if (this.#painting === null || this.#writes) return;
    if (buttons & RECENTRE) this.#showAll();
    if (buttons & DIP) this.#act(() => this.#dip());
    if (buttons & UNDO) this.#step(() => this.#opened().painting.undo());
    if (buttons & REDO) this.#step(() => this.#opened().painting.redo());
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
  async savePicture(): Promise<void> {
    const { camera } = this.#opened();
    this.#stage.draw(camera, false);
    const seen = document.createElement("canvas");
    Object.assign(seen, { width: this.#canvas.width, height: this.#canvas.height });
    const context = seen.getContext("2d");
    if (context === null) return;
    context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--ground");
    context.fillRect(0, 0, seen.width, seen.height);
    context.drawImage(this.#canvas, 0, 0);
    const blob = await new Promise<Blob | null>((done) => seen.toBlob(done, "image/png"));
    if (blob !== null) save(blob, `${this.#name()}.png`);
  }

  /** Save what was done, for `paint3d replay`. */
  saveScore(): void {
    const text = this.score();
    save(new Blob([text], { type: "application/jsonl" }), `${this.#name()}.score.jsonl`);
  }

  score(): string {
    return this.#opened().painting.score();
  }

  /** The SHA-256 of the colours and of the amounts, as the tests compare them. */
  async hashes(): Promise<Record<string, string | number>> {
    const { surface } = this.#opened().painting;
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

  #name(): string {
    const when = new Date().toISOString().slice(0, 19).replace(/[:T]/g, "-");
    return `${this.#opened().painting.about.name.replace(/\.\w+$/, "")}-${when}`;
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

  /** Ask for a frame: paint what was heard, and draw. */
  draw(): void {
    if (this.#drawn) return;
    this.#drawn = true;
    requestAnimationFrame((now) => {
      this.#drawn = false;
      if (this.#camera === null) return;
      try {
        this.#paint();
        this.#letPass(now);
        this.#steer(now);
        for (const ids of this.#changed.splice(0)) this.#stage.follow(ids);
        this.#stage.draw(this.#camera);
      } catch (cause) {
        this.fail(cause);
      }
    });
  }

  // -- the hand -------------------------------------------------------------------------------

  #listen(): void {
    const canvas = this.#canvas;
    const heard = (work: (event: PointerEvent) => void) => (event: PointerEvent) => {
      if (this.#painting === null) return;
      event.preventDefault();
      if (!this.#message.hidden) return; // another piece is being opened
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
      const painting = this.#painting;
      const { target } = event;
      const isWritten = target instanceof HTMLTextAreaElement || (target instanceof HTMLInputElement && target.type === "text");
      if (painting === null || event.isComposing) return;
      if (event.key === "Escape") this.#panel.show(null);
      if (isWritten || (!event.ctrlKey && !event.metaKey)) return;
      const letter = event.key.toLowerCase(); // also where capitals are locked
      const key = event.shiftKey ? `Shift+${letter}` : letter;
      const take = { z: painting.undo, y: painting.redo, "Shift+z": painting.redo }[key];
      if (take === undefined) return;
      event.preventDefault();
      this.#step(() => take.call(painting));
    });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      const file = event.dataTransfer?.files[0];
      if (file === undefined || this.#painting === null || this.#writes) return;
      this.#openFile(file);
    });
    addEventListener("visibilitychange", () => this.#keep());
    addEventListener("beforeunload", (event) => {
      this.#keep();
      if (this.#painting?.isPainted === true && this.#keeper?.isSound !== true) event.preventDefault();
    });
  }

  #down(event: PointerEvent): void {
    this.#canvas.setPointerCapture(event.pointerId);
    if (event.pointerType === "pen") this.#penAt = event.timeStamp;
    if (event.pointerType === "touch") {
      if (event.timeStamp - this.#penAt < PALM_MS || this.#strokeIsAPens()) return; // a palm
      this.#touches.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (this.#touches.size > 1) return this.#takeBack();
    }
    const turns = (event.button !== 0 && event.button !== ERASER_END) || event.altKey;
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
    this.#pointer = event.pointerId;
    this.#hear(event);
  }

  #strokeIsAPens(): boolean {
    return this.#pointer !== null && !this.#touches.has(this.#pointer);
  }

  /** A second finger came: what the first has painted was no stroke. */
  #takeBack(): void {
    this.#tapping = null;
    if (this.#pointer === null) return;
    const pointer = this.#pointer;
    this.#pointer = null;
    this.#events = this.#events.filter((event) => event.pointerId !== pointer);
    if (!this.#inStroke) return;
    this.#inStroke = false;
    const { painting, hand } = this.#opened();
    painting.advance(hand.end(painting.lastNs, painting.painter.brush));
    painting.endStroke();
    painting.undo();
    this.#refresh();
  }

  #move(event: PointerEvent): void {
    if (event.pointerType === "pen") this.#penAt = event.timeStamp;
    if (this.#pointer === event.pointerId) return this.#hear(event);
    const touch = this.#touches.get(event.pointerId);
    if (touch !== undefined && this.#touches.size === 2) {
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

  /** Two fingers: apart, nearer; both along, turn. */
  #pinch(touch: { x: number; y: number }, event: PointerEvent): void {
    const [a, b] = [...this.#touches.values()];
    const apart = (): number => Math.max(10, Math.hypot(a.x - b.x, a.y - b.y));
    const before = apart();
    const [x, y] = [event.clientX - touch.x, event.clientY - touch.y];
    Object.assign(touch, { x: event.clientX, y: event.clientY });
    const at = this.#placeOf({ clientX: 0.5 * (a.x + b.x), clientY: 0.5 * (a.y + b.y) });
    this.#isMoved = true;
    this.#camera?.zoom(apart() / before, at[0], at[1], this.#aspect());
    this.#camera?.turn(0.5 * x, 0.5 * y);
    this.draw();
  }

  #up(event: PointerEvent): void {
    this.#touches.delete(event.pointerId);
    if (this.#turning?.pointer === event.pointerId) this.#turning = null;
    if (this.#tapping?.pointerId === event.pointerId) this.#tap(this.#tapping, event);
    if (this.#pointer !== event.pointerId) return;
    this.#pointer = null;
    this.#hear(event);
  }

  /** What came down in one place has gone up: do what waits for it, unless it went elsewhere. */
  #tap(down: PointerEvent, up: PointerEvent): void {
    const [then, apart] = [this.#tapped, Math.hypot(up.clientX - down.clientX, up.clientY - down.clientY)];
    this.#tapping = null;
    if (then === null || up.type === "pointercancel" || apart > TAP_PX) return;
    this.#tapped = null;
    then(down);
  }

  #hear(event: PointerEvent): void {
    this.#events.push(event);
    this.draw();
  }

  /** Paint what was heard since the last frame. */
  #paint(): void {
    const events = this.#events.splice(0);
    if (events.length === 0) return;
    const { painting, hand, studio } = this.#opened();
    const { painter } = painting;
    for (const event of events) {
      if (event.type === "pointerdown") {
        const input = this.#inputOf(event);
        const erases = this.#erases || event.button === ERASER_END;
        if (this.#dipAlways && !erases) painting.dip(studio, this.#ink);
        const samples = hand.begin(input, painter.brush);
        const { layers } = painting;
        if (!layers.layers[layers.active].visible) {
          hand.end(painting.lastNs, painter.brush);
          this.#pointer = null;
          this.#notice(say("isHidden"));
          continue;
        }
        if (samples === null) {
          this.#turnBeside(event);
          continue;
        }
        painting.beginStroke(erases);
        this.#inStroke = true;
        painting.advance(samples);
      } else if (!this.#inStroke) continue;
      else if (event.type === "pointermove") {
        const all = event.getCoalescedEvents();
        for (const one of all.length > 0 ? all : [event])
          painting.advance(hand.move(this.#inputOf(one), painter.brush));
      } else {
        painting.advance(hand.end(this.#timeOf(event), painter.brush));
        painting.endStroke();
        this.#inStroke = false;
        this.#keep();
      }
    }
    this.#changed.push(painting.surface.refresh());
    this.#showState();
  }

  /** Who comes down beside the object turns it. */
  #turnBeside(event: PointerEvent): void {
    if (this.#pointer !== event.pointerId) return; // it is up again
    this.#pointer = null;
    const { clientX: x, clientY: y, pointerId: pointer } = event;
    this.#turning = { pointer, pans: false, x, y };
  }

  #timeOf(event: PointerEvent): bigint {
    const time = BigInt(Math.round(event.timeStamp * 1e6));
    const least = (this.#painting?.lastNs ?? 0n) + 2_000_000n;
    return event.type === "pointerdown" && time < least ? least : time;
  }

  #inputOf(event: PointerEvent): PointerInput {
    const { camera } = this.#opened();
    const [x, y] = this.#placeOf(event);
    const [right, up] = camera.axes;
    return {
      timeNs: this.#timeOf(event),
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
