/** A file that is no object to paint on, and why: in the texts of the command line, with their fields. */

/** A text with named fields, as `Message` in `paint3d/errors.py`. */
export interface Note {
  text: string;
  fields: Record<string, unknown>;
  plural?: string; // the text for a field `n` other than 1
}

export function noted(text: string, fields: Record<string, unknown> = {}, plural?: string): Note {
  return { text, fields, plural };
}

export class MeshError extends Error {
  override name = "MeshError";
  readonly note: Note;

  constructor(text: string, fields: Record<string, unknown> = {}) {
    super(filled(noted(text, fields)));
    this.note = noted(text, fields);
  }
}

/** That a file's structure is damaged, and how. */
export function damaged(cause: Note): MeshError {
  return new MeshError("its structure is damaged: {cause}", { cause });
}

/** A note in words; `translate` gives a text in the language that is spoken. */
export function filled(
  { text, fields, plural }: Note, translate: (text: string) => string | undefined = () => undefined,
): string {
  const words = translate(text) ?? (plural !== undefined && fields.n !== 1 ? plural : text);
  return words.replace(/\{(\w+)(!r)?(?::([^}]*))?\}/g, (_, name: string, quoted?: string, spec?: string) => {
    const value = fields[name];
    if (typeof value === "object" && value !== null && "text" in value) return filled(value as Note, translate);
    if (typeof value === "number") return ofNumber(value, spec ?? "");
    const most = /^\.(\d+)$/.exec(spec ?? "");
    const words = quoted === undefined ? String(value) : `'${String(value)}'`;
    return most === null ? words : words.slice(0, Number(most[1]));
  });
}

/** A number by Python's specification: nothing, "," or ".Ng". */
function ofNumber(value: number, spec: string): string {
  if (spec === ",") return value.toLocaleString("en-US");
  const digits = /^(?:\.(\d+))?g$/.exec(spec);
  if (digits === null) return String(value);
  const most = Number(digits[1] ?? 6);
  const [mantissa, exponent] = value.toExponential(most - 1).split("e");
  if (Number(exponent) >= -4 && Number(exponent) < most) return String(Number(value.toPrecision(most)));
  return `${Number(mantissa)}e${exponent[0]}${exponent.slice(1).padStart(2, "0")}`;
}
