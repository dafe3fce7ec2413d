/** The layers, the uppermost first, and what can be done to them. */

import type { Blend, Layer } from "../surface/layer_stack";
import { button, choice, field, section, slider } from "./controls";
import type { LayerEdit } from "./document";
import { say } from "./texts";

const BLENDS: readonly Blend[] = ["normal", "multiply"];

export class LayerList {
  readonly element = document.createElement("div");

  /** `edit` does what is asked for. */
  constructor(private readonly edit: (words: LayerEdit) => void) {}

  /** The lowest first, and the place of the active one. */
  show(all: readonly Layer[], place: number): void {
    const { edit } = this;
    const rows = all.map((_, k) => this.#row(all, k, k === place)).reverse();
    const { name, opacity, blend } = all[place];
    const faded = slider("opacity", say("opacity"), opacity, () => {}, [0.0, 1.0, 0.05]);
    const input = faded.querySelector("input") as HTMLInputElement;
    input.addEventListener("change", () => edit({ do: "set_opacity", place, opacity: Number(input.value) }));
    const named = field("name", say("name"), name, (text) => {
      if (text.trim() === "") return this.show(all, place);
      edit({ do: "rename_layer", place, name: text });
    });
    this.element.replaceChildren(
      section(say("layers"), ...rows, button("add", say("addLayer"), () => edit({ do: "add_layer" }))),
      section(say("layer", { name }),
        named,
        faded,
        choice("blend", say("blend"), BLENDS.map((one) => say(one)), BLENDS.indexOf(blend),
          (k) => edit({ do: "set_blend", place, blend: BLENDS[k] }))),
    ); // prettier-ignore
  }

  #row(all: readonly Layer[], place: number, isActive: boolean): HTMLElement {
    const { edit } = this;
    const { name, visible } = all[place];
    const row = document.createElement("div");
    row.className = "layer";
    const seen = button(`seen${place}`, say(visible ? "hide" : "show"),
      () => edit({ do: "set_visible", place, visible: !visible }), visible ? "eye" : "shut"); // prettier-ignore
    const text = /^\d+$/.test(name) ? say("layer", { name }) : name;
    const chosen = button(`layer${place}`, text, () => edit({ do: "select_layer", place }));
    chosen.setAttribute("aria-pressed", String(isActive));
    const up = button(`up${place}`, say("up"), () => edit({ do: "move_layer", place, to: place + 1 }), "up");
    up.disabled = place === all.length - 1;
    const gone = button(`gone${place}`, say("remove"), () => edit({ do: "remove_layer", place }), "close");
    gone.disabled = all.length === 1;
    row.append(seen, chosen, up, gone);
    return row;
  }
}
