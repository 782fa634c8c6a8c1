import { readFileSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";

const solver = process.env.INBETWEEN_SOLVER_DIR ?? "public";

/** Everything in one page, which a browser opens from a folder: there a script may load no other file. */
const inOneFile: Plugin = {
  name: "in-one-file",
  enforce: "post",
  generateBundle: {
    order: "post",
    handler(_, bundle) {
      const page = bundle["index.html"];
      if (page.type !== "asset") return;
      let text = String(page.source);
      const put = (what: RegExp, by: string): void => void (text = text.replace(what, () => by));
      for (const [name, part] of Object.entries(bundle)) {
        if (part === page) continue;
        // What ends a script or a style must not stand in it.
        if (part.type === "chunk") {
          put(/<script type="module"[^>]*><\/script>/, "");
          put(/<\/body>/, `<script type="module">${part.code.replaceAll("</script", "<\\/script")}</script></body>`);
        } else if (name.endsWith(".css")) {
          put(/<link rel="stylesheet"[^>]*>/, `<style>${String(part.source)}</style>`);
        }
        delete bundle[name];
      }
      const bytes = readFileSync(`${solver}/solver.wasm`).toString("base64");
      put(/<dialog/, `<script type="application/wasm" id="solver">${bytes}</script><dialog`);
      page.source = text;
      page.fileName = "inbetween.html";
    },
  },
};

// The solver is built by CMake, which says where it is; beside the page it is a file of its own, since the page's policy
// allows no data: addresses.
export default defineConfig(({ mode }) => {
  const alone = mode === "alone";
  return {
    base: "./",
    publicDir: alone ? false : solver,
    plugins: alone ? [inOneFile] : [],
    build: {
      target: "es2022",
      assetsInlineLimit: 0,
      chunkSizeWarningLimit: 2000,
      emptyOutDir: true,
      rollupOptions: { output: { inlineDynamicImports: alone } },
    },
  };
});
