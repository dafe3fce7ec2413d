import { defineConfig } from "vite";

/** `npm run build`: the page, where `paint3d page build` takes it from. */
export default defineConfig({
  base: "./", // it works in any folder of any host
  worker: { format: "es" },
  build: {
    outDir: "../paint3d/page/built",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
  },
});
