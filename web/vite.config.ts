import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

/** A comment that carries the licence of a library. */
function holds(name: string, path: string): string {
  return `/*! Holds ${name}:\n${readFileSync(new URL(`node_modules/${path}`, import.meta.url), "utf-8")}\n*/\n`;
}

const LICENCES = holds("noble-hashes", "@noble/hashes/LICENSE") + holds("meshoptimizer", "meshoptimizer/LICENSE.md");

/** `npm run build`: the page, where `paint3d page build` takes it from. */
export default defineConfig({
  base: "./", // it works in any folder of any host
  worker: { rolldownOptions: { output: { banner: ({ name }) => (name.startsWith("object_worker") ? LICENCES : "") } } },
  build: {
    outDir: "../paint3d/page/built",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
  },
});
