/** The texts that lie on the object, and what can be done to them. */

import { GRIDS, ORDERS, type Copybook, type LaidText } from "./copybook";
import { button, choice, lines, note, numbered, section } from "./controls";
import { say } from "./texts";

/** What a panel of texts asks for. */
export interface CopybookActs {
  lay(text: Partial<LaidText>): void;
  change(number: number, words: Partial<LaidText>): void;
  remove(number: number): void;
  place(number: number): void; // where the object is tapped next
  write(number: number): void;
}

const SIGNED_EM_MM = 10.0;
const STEMS = "甲乙丙丁戊己庚辛壬癸";
const BRANCHES = "子丑寅卯辰巳午未申酉戌亥";

/** A year of the sixty, by the calendar that most screens show. */
function yearOf(day: Date): string {
  const year = day.getFullYear() - 4;
  return STEMS[year % 10] + BRANCHES[year % 12];
}

export class CopybookList {
  readonly element = document.createElement("div");
  #chosen = 0;

  constructor(private readonly acts: CopybookActs) {}

  /** `planned`: the text that was asked for when the page was built. */
  show(copybook: Copybook, texts: readonly LaidText[], planned: string): void {
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
        choice("texts", say("copybook"), texts.map(({ text }, k) => `${say("texts", { number: k + 1 })} · ${text.replace(/\n/g, " ")}`),
          number, (k) => { this.#chosen = k; this.show(copybook, texts, planned); }),
      ); // prettier-ignore
    const asPlanned = note(say("asPlanned", { text: planned, mm: copybook.emMm }));
    if (laid !== undefined) parts.push(...this.#controls(copybook, laid, number, asPlanned));
    else parts.push(note(say("guideNote")));
    this.element.replaceChildren(
      section(say("copybook"), ...parts,
        button("addText", say("addText"), () => add({ text: planned, em_mm: copybook.emMm })),
        button("sign", say("signature"), () => add({ text: `${yearOf(new Date())}年書`, em_mm: SIGNED_EM_MM, grid: "none" }))),
      section(say("source"), note(copybook.licence)),
    ); // prettier-ignore
  }

  /** `asPlanned`: what the hand that shows how is planned for. */
  #controls(copybook: Copybook, laid: LaidText, number: number, asPlanned: HTMLElement): HTMLElement[] {
    const { acts } = this;
    const change = (words: Partial<LaidText>): void => acts.change(number, words);
    const missing = copybook.missing(laid.text);
    const write = button("write", say("write"), () => acts.write(number));
    write.disabled = !copybook.isPlanned(laid);
    return [
      lines("text", say("text"), laid.text, (text) => text.trim() !== "" && change({ text })),
      ...(missing.length > 0 ? [note(say("missing", { names: missing.join(" ") }))] : []),
      numbered("em", say("size_mm"), laid.em_mm, [4, 120, 1], () => {}, (em_mm) => change({ em_mm })),
      numbered("turn", say("turn"), laid.turn, [-180, 180, 1], () => {}, (turn) => change({ turn })),
      choice("order", say("order"), ORDERS.map((one) => say(one)), ORDERS.indexOf(laid.order),
        (k) => change({ order: ORDERS[k] })),
      choice("grid", say("grid"), GRIDS.map((one) => say(one === "columns" ? "ruled" : one)), GRIDS.indexOf(laid.grid),
        (k) => change({ grid: GRIDS[k] })),
      ...(write.disabled ? [asPlanned] : []),
      write,
      button("place", say("move"), () => acts.place(number)),
      button("takeOff", say("remove"), () => acts.remove(number)),
    ]; // prettier-ignore
  }
}
