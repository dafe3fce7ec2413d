/**
 * Texts that lie on the object to be written after, as `Copybook` and `LaidText` of
 * `paint3d/app/model` have them: outlines of characters, and how a planned hand writes them.
 */

import { Bundle } from "../core/bundle";
import { fromAxes, type Quaternion, type Vector } from "../core/quaternion";
import { plus, times } from "../core/vectors";
import { Chart, frameAt, type Frame } from "../mesh/chart";
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
const LIFT_MM = 0.08; // above the surface, so that a line is seen
const ROW = 9; // numbers of a planned sample

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

interface Words {
  brush: string;
  em_mm: number;
  licence: string;
  characters: Record<string, { rings: number[]; plan: number[] }>;
}

/** A character's outlines, from the middle of an em of 1, and its planned strokes. */
interface Character {
  rings: Line[];
  plan: Float32Array[]; // `ROW` numbers a sample
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

export class Copybook {
  readonly #characters = new Map<string, Character>();

  private constructor(private readonly words: Words) {}

  static async read(fetch: Fetch, file: string): Promise<Copybook> {
    const bundle = await Bundle.read<Words>(await fetch(file), file);
    const [outlines, samples] = [bundle.numbers("outlines", "i2"), bundle.numbers("samples", "f4")];
    const made = new Copybook(bundle.words);
    let [point, row] = [0, 0];
    for (const [text, { rings, plan }] of Object.entries(bundle.words.characters))
      made.#characters.set(text, {
        rings: rings.map((n) => {
          const ring = Array.from({ length: n + 1 }, (_, k): [number, number] => {
            const at = 2 * (point + (k % n));
            return [outlines[at] / UNITS, outlines[at + 1] / UNITS];
          });
          point += n;
          return ring;
        }),
        plan: plan.map((n) => samples.subarray(ROW * row, ROW * (row += n))),
      });
    return made;
  }

  get brush(): string {
    return this.words.brush;
  }

  get emMm(): number {
    return this.words.em_mm;
  }

  get licence(): string {
    return this.words.licence;
  }

  /** The characters of a text that are not there. */
  missing(text: string): string[] {
    return [...new Set(text.replace(/\s/g, ""))].filter((one) => !this.#characters.has(one));
  }

  /** Whether a hand is planned for all of a text as it lies. */
  isPlanned(laid: LaidText): boolean {
    const isThere = (text: string): boolean => (this.#characters.get(text)?.plan.length ?? 0) > 0;
    return laid.em_mm === this.emMm && cellsOf(laid).every(({ text }) => isThere(text));
  }

  /** The outlines of texts, and their grids. */
  guides(surface: ClosestPoints, texts: readonly LaidText[]): Guides {
    const [outlines, grid]: number[][] = [[], []];
    for (const laid of texts) this.#guide(surface, laid, outlines, grid);
    return { outlines: Float32Array.from(outlines), grid: Float32Array.from(grid) };
  }

  #guide(surface: ClosestPoints, laid: LaidText, outlines: number[], grid: number[]): void {
    const cells = cellsOf(laid);
    const chart = chartOf(surface, laid, cells);
    const between = laid.order === "columns" ? SIDES : ENDS;
    for (const { text, x, y } of cells) {
      const draw = (line: Line, size: number, into: number[]): void => {
        let before: Vector | null = null;
        for (const [u, v] of dense(line, size)) {
          const frame = chart.at(laid.em_mm * (x + size * u), laid.em_mm * (y + size * v));
          const now = frame && plus(frame.point, times(frame.normal, LIFT_MM));
          if (before !== null && now !== null) into.push(...before, ...now);
          before = now;
        }
      };
      for (const ring of this.#characters.get(text)?.rings ?? []) draw(ring, 1.0, outlines);
      for (const line of laid.grid === "columns" ? between : LINES[laid.grid]) draw(line, 0.5, grid);
    }
  }

  /** The strokes of a planned hand on the object, from 0 ns each. */
  *strokes(surface: ClosestPoints, laid: LaidText): Generator<DeviceSample[]> {
    const cells = cellsOf(laid);
    const chart = chartOf(surface, laid, cells);
    for (const { text, x, y } of cells)
      for (const rows of this.#characters.get(text)?.plan ?? []) {
        const stroke: DeviceSample[] = [];
        for (let k = 0; k < rows.length; k += ROW) {
          const frame = chart.at(laid.em_mm * x + rows[k + 1], laid.em_mm * y + rows[k + 2]);
          if (frame !== null) stroke.push(sampleOn(frame, rows.subarray(k, k + ROW)));
        }
        if (stroke.length > 1) yield stroke;
      }
  }
}

/** A sample over flat paper, over a frame in place of it. */
function sampleOn(frame: Frame, row: Float32Array): DeviceSample {
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

function chartOf(surface: ClosestPoints, laid: LaidText, cells: Cell[]): Chart {
  const reach = (of: (cell: Cell) => number): number =>
    laid.em_mm * (Math.max(...cells.map((cell) => Math.abs(of(cell)))) + 0.5 + MARGIN);
  const frame = frameAt(surface.find(laid.point), laid.turn);
  return new Chart(surface, frame, [reach(({ x }) => x), reach(({ y }) => y)], laid.em_mm / NODES);
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
