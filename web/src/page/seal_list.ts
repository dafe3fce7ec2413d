/** What a seal says and how it is cut, and where it is pressed next. */

import { MOST_CHARACTERS, STYLES, charactersOf, type SealLines, type Style } from "../seal/stone";
import type { Pair } from "../mesh/spline_chart";
import { button, choice, field, note, numbered, section } from "./controls";
import { say } from "./texts";

/** A seal that is cut, as its panel says it. */
export interface CutSeal {
  rings: Pair[][];
  turn: number; // to the left, degrees
}

export class SealList {
  readonly element = document.createElement("div");
  #text = "";
  #style: Style = "zhuwen";
  #sizeMm = 16;
  #turn = 0;
  #lines: SealLines | null = null;
  #tells = false; // whose the shapes are

  /** `press` is told what is to be pressed where the object is tapped next. */
  constructor(private readonly press: (seal: CutSeal) => void) {}

  /** `tells`: whose the shapes are, if nothing else in the tab does. */
  show(lines: SealLines, tells: boolean): void {
    this.#lines = lines;
    this.#tells = tells;
    const face = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    face.id = "face";
    const [why, press] = [note(""), button("press-seal", say("pressSeal"), () => this.#cut(this.press))];
    const show = (): void => {
      const said = this.#refusal(lines);
      why.textContent = said;
      why.hidden = said === "";
      press.disabled = said !== "" || this.#text === "";
      face.replaceChildren();
      this.#cut(({ rings }) => {
        const half = 0.5 * this.#sizeMm + 0.5;
        face.setAttribute("viewBox", [-half, -half, 2.0 * half, 2.0 * half].join(" "));
        const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
        path.setAttribute("d", rings.map((ring) => `M${ring.map(([x, y]) => `${x} ${-y}`).join("L")}Z`).join(""));
        face.append(path);
      });
    };
    const words = field("seal-text", say("text"), this.#text, (text) => {
      this.#text = text.trim();
      show();
    });
    (words.querySelector("input") as HTMLInputElement).addEventListener("input", (event) => {
      if ((event as InputEvent).isComposing) return;
      this.#text = (event.target as HTMLInputElement).value.trim();
      show();
    });
    this.element.replaceChildren(
      section(say("seal"), words, why, face as unknown as HTMLElement,
        choice("seal-style", say("sealStyle"), STYLES.map((style) => say(style)), STYLES.indexOf(this.#style), (k) => {
          this.#style = STYLES[k];
          show();
        }),
        numbered("seal-size", say("sealSize"), this.#sizeMm, [4, 60, 1], (mm) => {
          this.#sizeMm = mm;
          show();
        }),
        numbered("seal-turn", say("turn"), this.#turn, [-180, 180, 1], (turn) => (this.#turn = turn)),
        press, ...(tells ? [note(lines.licence)] : [])),
    ); // prettier-ignore
    show();
  }

  /** Cut the next ones at a size, mm. */
  setSize(mm: number): void {
    this.#sizeMm = mm;
    if (this.#lines !== null) this.show(this.#lines, this.#tells);
  }

  /** Why the text cannot be cut; "" where it can, or there is none yet. */
  #refusal(lines: SealLines): string {
    const characters = charactersOf(this.#text);
    if (characters.length > MOST_CHARACTERS) return say("sealTooLong", { n: characters.length, most: MOST_CHARACTERS });
    const missing = lines.missing(this.#text);
    return missing.length > 0 ? say("missing", { names: missing.join(" ") }) : "";
  }

  #cut(then: (seal: CutSeal) => void): void {
    const lines = this.#lines;
    if (lines === null || this.#text === "" || this.#refusal(lines) !== "") return;
    then({ rings: lines.cut(this.#text, this.#style, this.#sizeMm), turn: this.#turn });
  }
}
