import { defineConfig } from "vite";

// The solver is built by CMake, which says where it is; it becomes a file of its own beside the page, since the
// page's policy allows no data: addresses.
export default defineConfig({
  base: "./",
  publicDir: process.env.INBETWEEN_SOLVER_DIR ?? "public",
  build: { target: "es2022", assetsInlineLimit: 0, chunkSizeWarningLimit: 900, emptyOutDir: true },
});
