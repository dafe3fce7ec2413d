/** Buttons, choices and sliders of the page, and the elements that it begins with. */

/** An element of the page by its id. */
export function element<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found as T;
}

// Strokes of a pen 24 wide: what a button shows where there is no room for its name.
const ICONS = {
  dip: "M12 3c3.5 4.5 6 7.6 6 11a6 6 0 0 1-12 0c0-3.400 2.500-6.500 6-11z",
  erase: "M8 20 3.500 15.500a2 2 0 0 1 0-2.800L12.700 3.500a2 2 0 0 1 2.800 0l5 5a2 2 0 0 1 0 2.800L11.800 20zM8 8.200l7.800 7.800M8 20h12",
  undo: "M9 6 4 11l5 5M4.500 11H14a5.500 5.500 0 0 1 0 11h-3",
  redo: "M15 6l5 5-5 5M19.500 11H10a5.500 5.500 0 0 0 0 11h3",
  copybook: "M4 4h16v16H4zM12 4v16M4 12h16",
  layers: "M12 3.500 21 8.500 12 13.500 3 8.500zM3.500 12.500 12 17.300l8.500-4.800M3.500 16.500 12 21.300l8.500-4.800",
  save: "M12 3.500v11M7.500 10l4.500 4.500 4.500-4.500M4 16v3a1.500 1.500 0 0 0 1.500 1.500h13A1.500 1.500 0 0 0 20 19v-3",
  whole: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  more: "M5 11a1 1 0 1 1 0 2 1 1 0 0 1 0-2zM12 11a1 1 0 1 1 0 2 1 1 0 0 1 0-2zM19 11a1 1 0 1 1 0 2 1 1 0 0 1 0-2z",
  eye: "M2.500 12S6 5.500 12 5.500 21.500 12 21.500 12 18 18.500 12 18.500 2.500 12 2.500 12zM12 9a3 3 0 1 1 0 6 3 3 0 0 1 0-6z",
  shut: "M3 10c2 3 5 5 9 5s7-2 9-5M6 13.500 4 16M18 13.500l2 2.500M12 15v3.500",
  up: "M12 19V5M6 11l6-6 6 6",
  replay: "M7 4.500v15l12-7.500z",
  toEnd: "M5 4.500v15l10-7.500zM18.500 5v14",
  close: "M6 6l12 12M18 6 6 18",
};

function icon(name: keyof typeof ICONS): SVGElement {
  const space = "http://www.w3.org/2000/svg";
  const drawn = document.createElementNS(space, "svg");
  drawn.setAttribute("viewBox", "0 0 24 24");
  drawn.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", ICONS[name]);
  drawn.append(path);
  return drawn;
}

function captioned(text: string, ...parts: HTMLElement[]): HTMLElement {
  const label = document.createElement("label");
  const caption = document.createElement("span");
  caption.textContent = text;
  label.append(caption, ...parts);
  return label;
}

/** One of several names. */
export function choice(
  id: string, text: string, names: string[], chosen: number, then: (place: number) => void,
): HTMLElement {
  const select = document.createElement("select");
  select.id = id;
  select.setAttribute("aria-label", text);
  select.append(...names.map((name, k) => new Option(name, String(k), k === chosen, k === chosen)));
  select.addEventListener("change", () => then(select.selectedIndex));
  return captioned(text, select);
}

/** A name that can be changed. */
export function field(id: string, text: string, value: string, then: (value: string) => void): HTMLElement {
  const input = document.createElement("input");
  Object.assign(input, { id, type: "text", value, maxLength: 200, autocomplete: "off", spellcheck: false });
  input.addEventListener("change", () => then(input.value));
  return captioned(text, input);
}

/** A text of several lines. */
export function lines(id: string, text: string, value: string, then: (value: string) => void): HTMLElement {
  const input = document.createElement("textarea");
  Object.assign(input, { id, value, rows: 4, maxLength: 200, spellcheck: false });
  input.addEventListener("change", () => then(input.value));
  return captioned(text, input);
}

/** A number between two others. */
export function slider(
  id: string, text: string, value: number, then: (value: number) => void,
  [min, max, step]: readonly [number, number, number] = [0.1, 1.0, 0.05],
): HTMLElement {
  const input = document.createElement("input");
  Object.assign(input, { id, type: "range", min, max, step });
  input.value = String(value);
  input.addEventListener("input", () => then(Number(input.value)));
  return captioned(text, input);
}

/** The same with its number in its caption; `then` is told it at once, `settled` when it stays. */
export function numbered(
  id: string, text: string, value: number, range: readonly [number, number, number], then: (value: number) => void,
  settled: (value: number) => void = () => {},
): HTMLElement {
  const made = slider(id, `${text}: ${value}`, value, (now) => {
    (made.querySelector("span") as HTMLElement).textContent = `${text}: ${now}`;
    then(now);
  }, range); // prettier-ignore
  const input = made.querySelector("input") as HTMLInputElement;
  input.addEventListener("change", () => settled(Number(input.value)));
  return made;
}

export function tick(id: string, text: string, on: boolean, then: (on: boolean) => void): HTMLElement {
  const input = document.createElement("input");
  Object.assign(input, { id, type: "checkbox", checked: on });
  input.addEventListener("change", () => then(input.checked));
  const label = captioned(text, input);
  label.className = "tick";
  return label;
}

export function button(
  id: string, text: string, then: () => void, drawn?: keyof typeof ICONS,
): HTMLButtonElement {
  const made = document.createElement("button");
  Object.assign(made, { id, type: "button", title: text });
  const name = document.createElement("span");
  name.textContent = text;
  if (drawn !== undefined) made.append(icon(drawn));
  made.append(name);
  made.addEventListener("click", then);
  return made;
}

export function note(text: string): HTMLElement {
  const made = document.createElement("p");
  Object.assign(made, { className: "note", textContent: text });
  return made;
}

/** Controls that belong together, below a heading. */
export function section(heading: string, ...parts: HTMLElement[]): HTMLElement {
  const made = document.createElement("section");
  const title = document.createElement("h2");
  title.textContent = heading;
  const buttons = document.createElement("div");
  buttons.className = "buttons";
  buttons.append(...parts.filter((part) => part instanceof HTMLButtonElement));
  made.append(title, ...parts.filter((part) => !(part instanceof HTMLButtonElement)), buttons);
  return made;
}

/** Ask for a file. */
export function askForFile(kinds: string, then: (file: File) => void): void {
  const input = document.createElement("input");
  Object.assign(input, { type: "file", accept: kinds });
  input.addEventListener("change", () => {
    const file = input.files?.[0];
    if (file !== undefined) then(file);
  });
  input.click();
}

/** Hand a file to the browser, to be saved. */
export function save(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
