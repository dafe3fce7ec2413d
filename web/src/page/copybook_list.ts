/** The texts that lie on the object, and what can be done to them. */

import {
  GRIDS, handFor, ORDERS, whyNoHand, type Copybook, type CopybookContents, type LaidOut, type LaidText,
} from "./copybook"; // prettier-ignore
import { button, choice, lines, note, numbered, section } from "./controls";
import { say } from "./texts";

/** What a panel of texts asks for. */
export interface CopybookActs {
  lay(text: Partial<LaidText>): void;
  sealSize(mm: number): void; // that suits what is signed
  change(number: number, words: Partial<LaidText>): void;
  remove(number: number): void;
  place(number: number): void; // where the object is tapped next
  write(number: number): void;
}

const SIGNED = 0.35; // of the text's size
const [SMALLEST_MM, LARGEST_MM] = [4, 300]; // characters
const LONGEST_NAME = 5; // characters of a text that it is called by
const STEMS = "甲乙丙丁戊己庚辛壬癸";
const BRANCHES = "子丑寅卯辰巳午未申酉戌亥";

/** A year of the sixty, by the calendar that most screens show. */
function yearOf(day: Date): string {
  const year = day.getFullYear() - 4;
  return STEMS[year % 10] + BRANCHES[year % 12];
}

function nameOf(text: string): string {
  const letters = [...text.trim().replace(/\s+/g, " ")];
  return letters.length > LONGEST_NAME ? `${letters.slice(0, LONGEST_NAME).join("")}…` : letters.join("");
}

/** What the panel shows. */
export interface Shown {
  copybook: Copybook;
  contents: CopybookContents;
  texts: readonly LaidText[];
  laidOut: readonly LaidOut[]; // what can be laid, as it suits the object
  fits: readonly (number | null)[]; // of each text the largest size, where it is too large
}

export class CopybookList {
  readonly element = document.createElement("div");
  readonly source = document.createElement("div"); // whose the shapes are
  #chosen = 0;
  #next = 0; // of what can be laid

  constructor(private readonly acts: CopybookActs) {}

  show(shown: Shown): void {
    const { copybook, texts, laidOut } = shown;
    const { acts } = this;
    const number = Math.max(0, Math.min(this.#chosen, texts.length - 1)); // the one chosen may not be there yet
    const add = (text: Partial<LaidText>): void => {
      this.#chosen = texts.length;
      acts.lay(text);
    };
    const laid = texts.at(number);
    const parts: HTMLElement[] = [];
    if (texts.length > 1)
      parts.push(
        choice("texts", say("whichText"), texts.map(({ text }, k) => `${k + 1} · ${nameOf(text)}`),
          number, (k) => { this.#chosen = k; this.show(shown); }),
      ); // prettier-ignore
    if (laid !== undefined) parts.push(...this.#controls(shown, laid, number));
    const next = Math.min(this.#next, laidOut.length - 1);
    const sign = (): void => {
      const whole = laidOut.find(({ text }) => laid !== undefined && isLaidAs(laid, text));
      const em_mm = Math.max(SMALLEST_MM, Math.round(SIGNED * (laid?.em_mm ?? laidOut[next].text.em_mm)));
      const signature = whole?.signature ?? { em_mm };
      acts.sealSize(whole?.seal_mm ?? em_mm);
      add({ ...signature, text: `${yearOf(new Date())}年書`, grid: "none" });
    };
    this.element.replaceChildren(
      ...(laid === undefined ? [] : [section(say("copybook"), ...parts)]),
      section(say(laid === undefined ? "copybook" : "newText"),
        choice("new-text", say("newText"), laidOut.map(({ text }) => nameOf(text.text)),
          next, (k) => { this.#next = k; }),
        ...(laid === undefined ? [note(say("guideNote"))] : []),
        button("addText", say("addText"), () => add(laidOut[Math.min(this.#next, laidOut.length - 1)].text)),
        button("sign", say("signature"), sign)),
    ); // prettier-ignore
    this.source.replaceChildren(section(say("source"), note(copybook.licence)));
  }

  #controls({ copybook, contents, fits }: Shown, laid: LaidText, number: number): HTMLElement[] {
    const { acts } = this;
    const change = (words: Partial<LaidText>): void => acts.change(number, words);
    const missing = copybook.missing(laid.text);
    const write = button("write", say("write"), () => acts.write(number));
    write.disabled = handFor(contents, laid) === null;
    const { unplanned, sizes } = whyNoHand(contents, laid);
    const why = unplanned.length > 0 ? say("noHand", { names: unplanned.join(" ") }) : say("otherSize", { sizes });
    const fitting = fits.at(number) ?? null;
    const tooLarge = fitting === 0 ? say("nowhere") : say("tooLarge", { mm: fitting ?? 0 });
    return [
      lines("text", say("text"), laid.text, (text) => text.trim() !== "" && change({ text })),
      ...(missing.length > 0 ? [note(say("missing", { names: missing.join(" ") }))] : []),
      numbered("em", say("size_mm"), laid.em_mm, [SMALLEST_MM, LARGEST_MM, 1], () => {}, (em_mm) => change({ em_mm })),
      ...(fitting === null ? [] : [note(tooLarge)]),
      numbered("turn", say("turn"), laid.turn, [-180, 180, 1], () => {}, (turn) => change({ turn })),
      choice("order", say("order"), ORDERS.map((one) => say(one)), ORDERS.indexOf(laid.order),
        (k) => change({ order: ORDERS[k] })),
      choice("grid", say("grid"), GRIDS.map((one) => say(one === "columns" ? "ruled" : one)), GRIDS.indexOf(laid.grid),
        (k) => change({ grid: GRIDS[k] })),
      ...(write.disabled && missing.length === 0 ? [note(why)] : []),
      ...(fitting === null || fitting === 0 ? [] : [button("fit", say("fit"), () => change({ em_mm: fitting }))]),
      write,
      button("place", say("move"), () => acts.place(number)),
      button("takeOff", say("remove"), () => acts.remove(number)),
    ]; // prettier-ignore
  }
}

/** Whether a text lies as it was laid out. */
function isLaidAs(laid: LaidText, words: Partial<LaidText>): boolean {
  return Object.entries(words).every(([name, value]) => JSON.stringify(laid[name as keyof LaidText]) === JSON.stringify(value));
}
