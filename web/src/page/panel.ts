/** What there is no room for in the row of tools: sections in tabs, beside the picture or over its foot. */

import { element } from "./controls";

const TABS = ["copybook", "layers", "save", "more"] as const;
export type Tab = (typeof TABS)[number];

export class Panel {
  readonly #panel = element("panel");
  readonly #pages = new Map<Tab, HTMLElement>();

  /** `resized` is told when the picture has more room, or less. */
  constructor(private readonly resized: () => void) {
    for (const tab of TABS) {
      const page = document.createElement("div");
      page.id = `tab-${tab}`;
      page.hidden = true;
      this.#pages.set(tab, page);
    }
    this.#panel.append(...this.#pages.values());
    this.#panel.addEventListener("scroll", () => this.#showRest());
    const sized = new ResizeObserver(() => this.#showRest());
    for (const page of this.#pages.values()) sized.observe(page);
  }

  get shown(): Tab | null {
    if (this.#panel.hidden) return null;
    return TABS.find((tab) => this.#pages.get(tab)?.hidden === false) ?? null;
  }

  fill(tab: Tab, ...sections: HTMLElement[]): void {
    this.#pages.get(tab)?.replaceChildren(...sections);
  }

  /** Have a button say whether its tab is shown. */
  opener(button: HTMLElement): HTMLElement {
    button.classList.add("opener");
    button.setAttribute("aria-expanded", String(button.id === `show-${this.shown}`));
    return button;
  }

  toggle(tab: Tab): void {
    this.show(tab === this.shown ? null : tab);
  }

  /** Show a tab; null: none. */
  show(tab: Tab | null): void {
    this.#panel.hidden = element("veil").hidden = tab === null;
    for (const [name, page] of this.#pages) page.hidden = name !== tab;
    this.#panel.scrollTop = 0;
    for (const button of document.querySelectorAll<HTMLElement>(".opener")) this.opener(button);
    this.#showRest();
    this.resized();
  }

  /** Let what goes on below the foot fade out, rather than be cut. */
  #showRest(): void {
    const { scrollHeight, scrollTop, clientHeight } = this.#panel;
    this.#panel.classList.toggle("goes-on", scrollHeight - scrollTop - clientHeight > 2);
  }
}
