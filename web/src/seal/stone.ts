/**
 * The face of a seal, cut from the lines of its characters as `cut_known` of
 * `paint3d/calligraphy/seal/stone.py` does: what takes paste, as rings in mm. Their shapes are found
 * by distances to lines, not by a geometry library, so they are the desktop's but for roundings.
 */

import { Bundle } from "../core/bundle";
import { linspace, type Pair } from "../mesh/spline_chart";
import type { Fetch } from "../studio";

export const STYLES = ["zhuwen", "baiwen"] as const;
export type Style = (typeof STYLES)[number];
export const MOST_CHARACTERS = 4;

const COLUMNS: Record<number, number[]> = { 1: [1], 2: [1, 1], 3: [1, 2], 4: [2, 2] };
const [FRAME, ROUNDING] = [0.045, 0.05]; // of the side: width of the frame, its corners' radius
const MARGIN = { zhuwen: 0.085, baiwen: 0.075 };
const GAP = 0.085;
const LINE = { zhuwen: 0.15, baiwen: 0.165 };
const [WIDEST, FINEST] = [0.105, 0.024];
const DRAWN_OUT = 2.6;
const LEAST_EXTENT = 0.45; // ems
const SIMPLER = 5e-4; // of the side, that a corner may be cut off by
const NODES = 241; // along the side of the grid that shapes are found on

type Line = readonly Pair[];

/** The lines of characters, in ems. */
export class SealLines {
  readonly #lines = new Map<string, Line[]>();

  private constructor(readonly licence: string) {}

  static async read(fetch: Fetch, file: string): Promise<SealLines> {
    const bundle = await Bundle.read<{ licence: string; characters: string; units: number }>(await fetch(file), file);
    const { licence, characters, units } = bundle.words;
    const [strokes, lengths, points] = [bundle.numbers("strokes", "u1"), bundle.numbers("lengths", "u1"), bundle.numbers("points", "i2")];
    const made = new SealLines(licence);
    let [stroke, at] = [0, 0];
    for (const [k, one] of [...characters].entries())
      made.#lines.set(
        one,
        Array.from(lengths.subarray(stroke, (stroke += strokes[k])), (n) =>
          Array.from({ length: n }, (): Pair => [points[at++] / units, points[at++] / units]),
        ),
      );
    return made;
  }

  /** The characters of a text that cannot be cut. */
  missing(text: string): string[] {
    return [...new Set(charactersOf(text))].filter((one) => !this.#lines.has(one));
  }

  /** Rings, mm from the middle of the stone, y upwards; of one to four characters that are there. */
  cut(text: string, style: Style, sizeMm: number): Pair[][] {
    const characters = charactersOf(text);
    const written = cellsOf(characters.length, style).map((cell, k) => wired(this.#lines.get(characters[k]) ?? [], cell, style));
    const ink = (x: number, y: number): number => Math.max(...written.map((shape) => shape(x, y)));
    // above 0 where there is paste
    const face = (x: number, y: number): number => {
      const stone = withinStone(x, y);
      return style === "baiwen" ? Math.min(stone, -ink(x, y)) : Math.max(Math.min(stone, FRAME - stone), ink(x, y));
    };
    const round = (value: number): number => Math.round(1e3 * sizeMm * value) / 1e3;
    return outlinesOf(face).map((ring) => simplified(ring).map(([x, y]): Pair => [round(x), round(y)]))
      .filter((ring) => ring.length >= 3); // prettier-ignore
  }
}

export function charactersOf(text: string): string[] {
  return [...text.replace(/\s/g, "")];
}

type Cell = readonly [number, number, number, number]; // left, lower, right and upper side
type Shape = (x: number, y: number) => number; // how far within, of the side; negative outside

function cellsOf(n: number, style: Style): Cell[] {
  const columns = COLUMNS[n];
  const side = 1.0 - 2.0 * MARGIN[style];
  const width = (side - GAP * (columns.length - 1)) / columns.length;
  return columns.flatMap((count, k) => {
    const right = 0.5 * side - k * (width + GAP);
    const height = (side - GAP * (count - 1)) / count;
    return Array.from({ length: count }, (_, row): Cell => {
      const top = 0.5 * side - row * (height + GAP);
      return [right - width, top - height, right, top];
    });
  });
}

/** A character's lines drawn into a cell, all as wide as their number asks for. */
function wired(lines: Line[], cell: Cell, style: Style): Shape {
  const mean = Math.sqrt((cell[2] - cell[0]) * (cell[3] - cell[1]));
  const wide = Math.min(Math.max((LINE[style] * 2.0) / Math.sqrt(3.0 + lines.length), FINEST), WIDEST) * mean;
  const points = lines.flat();
  const fit = [0, 1].map((axis) => {
    const all = points.map((point) => point[axis]);
    const [low, high] = [Math.min(...all), Math.max(...all)];
    const scale = (cell[axis + 2] - cell[axis] - wide) / Math.max(high - low, LEAST_EXTENT);
    return { scale, middle: 0.5 * (low + high), at: 0.5 * (cell[axis] + cell[axis + 2]) };
  });
  const most = DRAWN_OUT * Math.min(fit[0].scale, fit[1].scale);
  const drawn = lines.map((line) =>
    line.map((point): Pair => {
      const [x, y] = fit.map(({ scale, middle, at }, axis) => (point[axis] - middle) * Math.min(scale, most) + at);
      return [x, y];
    }),
  );
  return (x, y) => {
    let least = Infinity;
    for (const line of drawn)
      for (let k = 1; k < line.length; k++) least = Math.min(least, awayFrom(line[k - 1], line[k], x, y));
    return 0.5 * wide - least;
  };
}

function withinStone(x: number, y: number): number {
  const [u, v] = [Math.abs(x) - 0.5 + ROUNDING, Math.abs(y) - 0.5 + ROUNDING];
  return ROUNDING - Math.hypot(Math.max(u, 0.0), Math.max(v, 0.0)) - Math.min(Math.max(u, v), 0.0);
}

function awayFrom([ax, ay]: Pair, [bx, by]: Pair, x: number, y: number): number {
  const [dx, dy] = [bx - ax, by - ay];
  const along = Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1.0), 0.0), 1.0);
  return Math.hypot(x - ax - along * dx, y - ay - along * dy);
}

/** Where a shape ends, as closed rings: marching squares, with straight lines between nodes. */
function outlinesOf(shape: Shape): Pair[][] {
  const step = 1.04 / (NODES - 1);
  const at = linspace(-0.52, 0.52, NODES);
  const value = Float64Array.from({ length: NODES * NODES }, (_, k) => shape(at[k % NODES], at[Math.floor(k / NODES)]) || 1e-9);
  // An edge of the grid by its node and its axis; from where the outline crosses one to the next.
  const next = new Map<number, number>();
  for (let j = 0; j + 1 < NODES; j++)
    for (let i = 0; i + 1 < NODES; i++) {
      const node = j * NODES + i;
      const corners = [node, node + 1, node + NODES + 1, node + NODES];
      const edges = [2 * node, 2 * (node + 1) + 1, 2 * (node + NODES), 2 * node + 1];
      const ins = corners.map((k) => value[k] > 0.0);
      const mean = corners.reduce((sum, k) => sum + value[k], 0.0);
      const [out, into]: number[][] = [[], []]; // prettier-ignore
      for (let k = 0; k < 4; k++) {
        if (ins[k] && !ins[(k + 1) % 4]) out.push(k);
        if (!ins[k] && ins[(k + 1) % 4]) into.push(k);
      }
      // the outline has what is within on its left; of two ways across, the one that the middle says
      for (const k of out) {
        const others = into.map((m) => (k - m + 4) % 4);
        const chosen = out.length === 1 ? 0 : others.indexOf(mean > 0.0 ? 3 : 1);
        next.set(edges[k], edges[into[chosen]]);
      }
    }
  const place = (edge: number): Pair => {
    const node = Math.floor(edge / 2);
    const other = edge % 2 === 0 ? node + 1 : node + NODES;
    const share = value[node] / (value[node] - value[other]);
    const [x, y] = [at[node % NODES], at[Math.floor(node / NODES)]];
    return edge % 2 === 0 ? [x + share * step, y] : [x, y + share * step];
  };
  const rings: Pair[][] = [];
  while (next.size > 0) {
    const [first] = next.keys();
    const ring: Pair[] = [];
    for (let edge: number | undefined = first; edge !== undefined; ) {
      ring.push(place(edge));
      const following: number | undefined = next.get(edge);
      next.delete(edge);
      edge = following === first ? undefined : following;
    }
    rings.push(ring);
  }
  return rings;
}

/** A ring without corners that hardly count (Douglas, Peucker). */
function simplified(ring: Pair[]): Pair[] {
  const farthest = (first: number, last: number): [number, number] => {
    let [most, where] = [0.0, first];
    for (let k = first + 1; k < last; k++) {
      const away = awayFrom(ring[first], ring[last % ring.length], ...ring[k]);
      if (away > most) [most, where] = [away, k];
    }
    return [most, where];
  };
  const kept: number[] = [];
  const keep = (first: number, last: number): void => {
    const [most, where] = farthest(first, last);
    if (most <= SIMPLER) {
      kept.push(first);
      return;
    }
    keep(first, where);
    keep(where, last);
  };
  const across = ring.reduce((far, point, k) => {
    const away = (other: Pair): number => Math.hypot(other[0] - ring[0][0], other[1] - ring[0][1]);
    return away(point) > away(ring[far]) ? k : far;
  }, 0);
  keep(0, across);
  keep(across, ring.length);
  return kept.map((k) => ring[k]);
}
