import { defineConfig } from "vite";

// Files of fixed names and no inline script: the server's content security policy allows none.
export default defineConfig({
  base: "./",
  build: {
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    rollupOptions: {
      output: { entryFileNames: "page.js", chunkFileNames: "[name].js", assetFileNames: "[name][extname]" },
    },
    chunkSizeWarningLimit: 1000,
  },
});
