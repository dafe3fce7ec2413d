import { defineConfig } from "vite";

const NOBLE = "/*! Holds noble-hashes: MIT License, (c) 2022 Paul Miller (paulmillr.com) */";

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
