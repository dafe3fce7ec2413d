import { defineConfig } from "vite";

/** `npm run build-replay`: the painter alone, for Node, as the tests call it. */
export default defineConfig({
  publicDir: false,
  ssr: { noExternal: true }, // the script runs where nothing is installed
  build: {
    ssr: "src/replay.ts",
    outDir: "build",
    target: "node20",
    minify: false,
    rollupOptions: { output: { entryFileNames: "replay.mjs" } },
  },
});
