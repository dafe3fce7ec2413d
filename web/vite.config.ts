import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

const LICENCE = readFileSync(new URL("node_modules/@noble/hashes/LICENSE", import.meta.url), "utf-8");
const NOBLE = `/*! Holds noble-hashes:\n${LICENCE}\n*/`;

/** `npm run build`: the page, where `paint3d page build` takes it from. */
export default defineConfig({
  base: "./", // it works in any folder of any host
  worker: { format: "es", rolldownOptions: { output: { banner: NOBLE } } },
  build: {
    outDir: "../paint3d/page/built",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
  },
});
