/**
 * Texts that lie on the object to be written after, as `Copybook` and `LaidText` of
 * `paint3d/app/model` have them: outlines of characters, and how a planned hand writes them.
 */

import { Bundle } from "../core/bundle";
import { fromAxes, type Quaternion, type Vector } from "../core/quaternion";
import { lengthOf, minus, plus, times, turned } from "../core/vectors";
import { Chart, frameAt, frameUp, type Frame } from "../mesh/chart";
import type { ClosestPoints } from "../mesh/closest_points";
import { AT_REST, RecordingError, type DeviceSample } from "../recording/recording";
import type { Fetch } from "../studio";

/** A text, or an empty grid, as a score has it. */
export interface LaidText {
  text: string;
  em_mm: number;
  order: "columns" | "row";
  point: Vector; // where its middle is
  turn: number; // to the left, degrees
  gap: number; // ems between columns or rows
  between: number; // ems between the characters of one
  grid: Grid;
  cells: readonly [number, number]; // of a grid alone: across and down
}
export const ORDERS = ["columns", "row"] as const;
export const GRIDS = ["frame", "mi", "jiu", "tian", "columns", "none"] as const;
export type Grid = (typeof GRIDS)[number];
/** What a score leaves out of a text. */
export const USUAL = {
  text: "", em_mm: 40.0, order: "columns", turn: 0.0, gap: 0.1, between: 0.0, grid: "frame", cells: [4, 5],
} as const; // prettier-ignore
const LONGEST = 2000;
const MOST_CELLS = 40;

const UNITS = 1024.0; // of the em
const NODES = 16.0; // of the chart, per em
const MARGIN = 0.25; // ems around the text that a brush's root may stray
const DENSE = 1.0 / 32.0; // ems between two points of a line
const SMALLEST_MM = 4; // characters
const [WITHIN, NOT_CUT] = [0.875, 0.95]; // parts of a square's half, and of what is between there and its corner
const SIGNED_MM = 14; // a signature, and its seal
const CORNERS = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] as const; // prettier-ignore
const LIFT_MM = 0.08; // above the surface, so that a line is seen

type Line = readonly (readonly [number, number])[]; // em squares' halves from their middle
const FRAME: Line[] = [[[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]]; // prettier-ignore
const CROSS: Line[] = [[[-1, 0], [1, 0]], [[0, -1], [0, 1]]]; // prettier-ignore
const DIAGONALS: Line[] = [[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]]; // prettier-ignore
const THIRDS: Line[] = [-1 / 3, 1 / 3].flatMap((at): Line[] => [[[-1, at], [1, at]], [[at, -1], [at, 1]]]); // prettier-ignore
const SIDES: Line[] = [[[-1, -1], [-1, 1]], [[1, -1], [1, 1]]]; // prettier-ignore
const ENDS: Line[] = [[[-1, -1], [1, -1]], [[-1, 1], [1, 1]]]; // prettier-ignore
const LINES: Record<Exclude<Grid, "columns">, Line[]> = {
  frame: FRAME, tian: [...FRAME, ...CROSS], mi: [...FRAME, ...CROSS, ...DIAGONALS],
  jiu: [...FRAME, ...THIRDS], none: [],
}; // prettier-ignore

/** How a text stands on an object, and its signature beside it. */
export interface LaidOut {
  text: Partial<LaidText> & { text: string; em_mm: number };
  signature: Partial<LaidText> & { em_mm: number };
  seal_mm: number;
}

/** The same on what no text is laid out for. */
export function usualLaidOut(text: string): LaidOut {
  return { text: { text, em_mm: USUAL.em_mm }, signature: { em_mm: SIGNED_MM }, seal_mm: SIGNED_MM };
}

/** A hand that is planned for some characters, at one size. */
export interface PlannedHand {
  file: string;
  brush: string;
  em_mm: number;
  characters: string;
}

/** What `contents.json` says of texts. */
export interface CopybookContents {
  file: string;
  texts: string[];
  scaled: number; // times that a hand writes larger or smaller than planned, at most
  hands: PlannedHand[];
}

/** Lines on the object, to be written after: their points in pairs, mm. */
export interface Guides {
  outlines: Float32Array;
  grid: Float32Array;
}

/** The text that a score's words say, if a page can show it. */
export function readText(words: unknown, where: string): LaidText {
  const said = { font: "", ...USUAL, ...(words as Partial<LaidText> & { font?: string }) };
  const expect = (holds: boolean, name: keyof typeof said, expected: string): void => {
    if (!holds) throw new RecordingError(`${where}: the ${name} of a text is ${JSON.stringify(said[name])}; expected ${expected}`);
  };
  const isWithin = (value: unknown, low: number, high: number): boolean =>
    typeof value === "number" && value >= low && value <= high;
  const { point } = said;
  expect(said.font === "", "font", "none: a page has characters of its own");
  expect(typeof said.text === "string" && said.text.length <= LONGEST, "text", `up to ${LONGEST} characters`);
  expect(ORDERS.includes(said.order), "order", ORDERS.join(" or "));
  expect(GRIDS.includes(said.grid), "grid", GRIDS.join(" or "));
  for (const [name, low, high] of [["em_mm", 2, 1000], ["turn", -180, 180], ["gap", 0, 5], ["between", 0, 5]] as const)
    expect(isWithin(said[name], low, high), name, `${low} to ${high}`);
  expect(isTuple(said.cells, 2, (n) => Number.isInteger(n) && isWithin(n, 1, MOST_CELLS)), "cells", `two counts to ${MOST_CELLS}`);
  if (!isTuple(point, 3, Number.isFinite)) {
    const got = point === undefined ? "missing" : JSON.stringify(point);
    throw new RecordingError(`${where}: the point of a text is ${got}; expected three numbers, mm`);
  }
  const { text, em_mm, order, turn, gap, between, grid, cells } = said;
  return { text, em_mm, order, point: point as Vector, turn, gap, between, grid, cells };
}

function isTuple(value: unknown, n: number, holds: (one: unknown) => boolean): boolean {
  return Array.isArray(value) && value.length === n && value.every(holds);
}

/** A character and where its middle is from that of its text, ems. */
interface Cell {
  text: string;
  x: number;
  y: number;
}

/** The characters of a text, each once. */
function charactersIn(text: string): string[] {
  return [...new Set(text.replace(/\s/g, ""))];
}

/** The planned hand that writes a text as it lies, at the nearest size; null where none does. */
export function handFor({ hands, scaled }: CopybookContents, { text, em_mm }: LaidText): PlannedHand | null {
  const away = (hand: PlannedHand): number => Math.abs(Math.log(em_mm / hand.em_mm));
  const [nearest] = handsOf(hands, charactersIn(text)).sort((a, b) => away(a) - away(b));
  return nearest !== undefined && away(nearest) <= Math.log(scaled) ? nearest : null;
}

/** Hands that are planned for all of some characters. */
function handsOf(hands: readonly PlannedHand[], characters: readonly string[]): PlannedHand[] {
  return hands.filter((hand) => characters.every((one) => hand.characters.includes(one)));
}

/** Why no hand writes a text as it lies: characters that none is planned for, or sizes, mm, that one is planned for. */
export function whyNoHand({ hands, scaled }: CopybookContents, { text }: LaidText): { unplanned: string[]; sizes: string } {
  const characters = charactersIn(text);
  const able = handsOf(hands, characters);
  const sizes = able.map(({ em_mm }) => `${Math.ceil(em_mm / scaled)}–${Math.floor(em_mm * scaled)}`).join(", ");
  const unplanned = characters.filter((one) => handsOf(hands, [one]).length === 0);
  return { unplanned: able.length > 0 || unplanned.length > 0 ? unplanned : characters, sizes };
}

/** How a hand writes characters. */
export class WritingHand {
  readonly #strokes = new Map<string, { first: number; n: number }[]>();

  private constructor(
    private readonly samples: Int16Array,
    private readonly steps: readonly number[],
    private readonly emMm: number,
  ) {}

  static async read(fetch: Fetch, { file, em_mm }: PlannedHand): Promise<WritingHand> {
    const bundle = await Bundle.read<{ steps: number[]; characters: Record<string, number[]> }>(await fetch(file), file);
    const { steps, characters } = bundle.words;
    const made = new WritingHand(bundle.numbers("samples", "i2"), steps, em_mm);
    let first = 0;
    for (const [text, counts] of Object.entries(characters))
      made.#strokes.set(text, counts.map((n) => ({ first: (first += n) - n, n })));
    return made;
  }

  /** Its strokes on the object, from 0 ns each. */
  *strokes(surface: ClosestPoints, laid: LaidText, apex: Apex): Generator<DeviceSample[]> {
    const { samples, steps } = this;
    const rows = samples.length / steps.length;
    const scale = laid.em_mm / this.emMm;
    for (const { text, at } of squaresOf(surface, laid, apex))
      for (const { first, n } of this.#strokes.get(text) ?? []) {
        let stroke: DeviceSample[] = [];
        let from = 0; // s, when it comes down
        for (let k = first; k < first + n; k++) {
          const row = steps.map((step, part) => step * samples[part * rows + k]);
          const frame = at(scale * row[1], scale * row[2]);
          if (frame === null) {
            if (stroke.length > 1) yield stroke; // it goes on where the object does
            stroke = [];
            continue;
          }
          if (stroke.length === 0) from = row[0];
          row[0] -= from;
          stroke.push(sampleOn(frame, row));
        }
        if (stroke.length > 1) yield stroke;
      }
  }
}

export class Copybook {
  readonly #rings = new Map<string, Line[]>(); // from the middle of an em of 1

  private constructor(readonly licence: string) {}

  static async read(fetch: Fetch, file: string): Promise<Copybook> {
    const bundle = await Bundle.read<{ licence: string; characters: Record<string, number[]> }>(await fetch(file), file);
    const outlines = bundle.numbers("outlines", "i2");
    const made = new Copybook(bundle.words.licence);
    let point = 0;
    for (const [text, counts] of Object.entries(bundle.words.characters))
      made.#rings.set(
        text,
        counts.map((n) => {
          const ring = Array.from({ length: n + 1 }, (_, k): [number, number] => {
            const at = 2 * (point + (k % n));
            return [outlines[at] / UNITS, outlines[at + 1] / UNITS];
          });
          point += n;
          return ring;
        }),
      );
    return made;
  }

  /** The characters of a text that are not there. */
  missing(text: string): string[] {
    return charactersIn(text).filter((one) => !this.#rings.has(one));
  }

  /** The outlines of texts, and their grids. */
  guides(surface: ClosestPoints, texts: readonly LaidText[], apex: Apex): Guides {
    const [outlines, grid]: number[][] = [[], []];
    for (const laid of texts) this.#guide(surface, laid, apex, outlines, grid);
    return { outlines: Float32Array.from(outlines), grid: Float32Array.from(grid) };
  }

  #guide(surface: ClosestPoints, laid: LaidText, apex: Apex, outlines: number[], grid: number[]): void {
    const between = laid.order === "columns" ? SIDES : ENDS;
    for (const { text, at } of squaresOf(surface, laid, apex)) {
      const draw = (line: Line, size: number, into: number[]): void => {
        let before: Vector | null = null;
        for (const [u, v] of dense(line, size)) {
          const frame = at(laid.em_mm * size * u, laid.em_mm * size * v);
          const now = frame && plus(frame.point, times(frame.normal, LIFT_MM));
          if (before !== null && now !== null) into.push(...before, ...now);
          before = now;
        }
      };
      for (const ring of this.#rings.get(text) ?? []) draw(ring, 1.0, outlines);
      for (const line of laid.grid === "columns" ? between : LINES[laid.grid]) draw(line, 0.5, grid);
    }
  }
}

/** The largest size, mm, at which a text ends on the object where it lies; null where it does as it is, 0 where none does. */
export function largestThatFits(surface: ClosestPoints, laid: LaidText, apex: Apex): number | null {
  const fits = (em_mm: number): boolean => {
    for (const { at } of squaresOf(surface, { ...laid, em_mm }, apex))
      for (const [u, v] of CORNERS) {
        const [corner, within] = [at(em_mm * u, em_mm * v), at(WITHIN * em_mm * u, WITHIN * em_mm * v)];
        if (corner === null || within === null) return false;
        const apart = (1.0 - WITHIN) * em_mm * Math.hypot(u, v);
        if (lengthOf(minus(corner.point, within.point)) < NOT_CUT * apart) return false; // a chart ends somewhat later
      }
    return true;
  };
  if (fits(laid.em_mm)) return null;
  let [low, high] = [0, Math.ceil(laid.em_mm)];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (middle >= SMALLEST_MM && !fits(middle)) high = middle;
    else low = middle;
  }
  return low < SMALLEST_MM ? 0 : low;
}

/** A sample over flat paper, over a frame in place of it. */
function sampleOn(frame: Frame, row: readonly number[]): DeviceSample {
  const [seconds, , , height, w, x, y, z, pressure] = row;
  const { ahead, up, normal } = frame;
  const onSurface = (v: Vector): Vector =>
    plus(plus(times(ahead, v[0]), times(up, v[1])), times(normal, v[2]));
  const axes = axesOf([w, x, y, z]).map(onSurface);
  return {
    timeNs: BigInt(Math.round(1e9 * seconds)),
    position: plus(frame.point, times(normal, height)),
    orientation: fromAxes(axes[0], axes[1], axes[2]),
    pressure,
    buttons: 0,
    objectPosition: AT_REST.position,
    objectOrientation: AT_REST.orientation,
    contact: null,
  };
}

/** The columns of a rotation's matrix. */
function axesOf([w, x, y, z]: Quaternion): Vector[] {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}

/** Columns from right to left, or rows from top to bottom, around the text's middle; empty of a grid alone. */
function cellsOf({ text, order, gap, between, cells }: LaidText): Cell[] {
  const [n, length] = order === "columns" ? cells : [cells[1], cells[0]];
  const lines =
    text.trim() === ""
      ? Array.from({ length: n }, () => Array.from({ length }, () => ""))
      : text.split("\n").map((line) => [...line.replace(/\s/g, "")]).filter((line) => line.length > 0);
  const longest = Math.max(...lines.map((line) => line.length));
  return lines.flatMap((line, l) =>
    line.map((one, k) => {
      const across = (1.0 + gap) * (0.5 * (lines.length - 1) - l);
      const along = (1.0 + between) * (0.5 * (longest - 1) - k);
      return order === "columns" ? { text: one, x: across, y: along } : { text: one, x: -along, y: across };
    }),
  );
}

/** Where the ribs of a folding fan meet, mm; null on all else. */
export type Apex = Vector | null;

/** A character's square: `at` says the frame so many mm to the right of its middle and up; null where the surface has ended. */
interface Square {
  text: string;
  at(x: number, y: number): Frame | null;
}

/** The squares of a text: on what unrolls as one piece, or each on its rib of a folding fan. */
function* squaresOf(surface: ClosestPoints, laid: LaidText, apex: Apex): Generator<Square> {
  const { em_mm, turn } = laid;
  const cells = cellsOf(laid);
  const chart = (frame: Frame, x: number, y: number): Chart =>
    new Chart(surface, frame, [x, y].map((far) => em_mm * (far + 0.5 + MARGIN)) as [number, number], em_mm / NODES);
  const middle = surface.find(laid.point);
  if (apex === null) {
    const far = (of: (cell: Cell) => number): number => Math.max(...cells.map((cell) => Math.abs(of(cell))));
    const whole = chart(frameAt(middle, turn), far(({ x }) => x), far(({ y }) => y));
    for (const { text, x, y } of cells) yield { text, at: (u, v) => whole.at(em_mm * x + u, em_mm * y + v) };
    return;
  }
  const rib = minus(middle.point, apex);
  const radius = lengthOf(rib);
  for (const { text, x, y } of cells) {
    const up = times(turned(rib, middle.normal, (-em_mm * x) / radius), 1.0 / radius);
    const wanted = plus(apex, times(up, radius + em_mm * y));
    const found = surface.find(wanted);
    const isThere = lengthOf(minus(found.point, wanted)) < em_mm / NODES;
    const square = isThere ? chart(frameUp(found, turned(up, middle.normal, (turn * Math.PI) / 180.0)), 0.0, 0.0) : null;
    yield { text, at: (u, v) => square?.at(u, v) ?? null };
  }
}

/** Points along a line, a step apart at most. */
function* dense(line: Line, size: number): Generator<readonly [number, number]> {
  yield line[0];
  for (let k = 1; k < line.length; k++) {
    const [[a, b], [c, d]] = [line[k - 1], line[k]];
    const n = Math.ceil((size * Math.hypot(c - a, d - b)) / DENSE);
    for (let j = 1; j <= n; j++) yield [a + ((c - a) * j) / n, b + ((d - b) * j) / n];
  }
}
