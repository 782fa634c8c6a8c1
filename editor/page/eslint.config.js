// What is asked of the page and of the tests under node, beyond the form, which Prettier decides. `npm run lint` begins at
// the root of the project, where both are.
import js from "@eslint/js";
import { defineConfig } from "eslint/config";
import typescript from "typescript-eslint";

// The tests run under node, and hand functions to the browser.
const ofNode = ["URL", "WebAssembly", "console", "fetch", "performance", "process", "setTimeout"];
const ofBrowser = [
  "DataTransfer",
  "DragEvent",
  "File",
  "MessageChannel",
  "MutationObserver",
  "Node",
  "document",
  "localStorage",
  "requestAnimationFrame",
  "sessionStorage",
  "window",
];

export default defineConfig(
  { linterOptions: { reportUnusedDisableDirectives: "error" } },
  js.configs.recommended,
  {
    files: ["editor/page/src/**/*.ts"],
    extends: [typescript.configs.recommendedTypeChecked],
    languageOptions: {
      parserOptions: { projectService: true, tsconfigRootDir: new URL(".", import.meta.url).pathname },
    },
  },
  { files: ["editor/page/*.ts"], extends: [typescript.configs.recommended] },
  {
    files: ["editor/page/*.js", "tests/**/*.mjs"],
    languageOptions: { globals: Object.fromEntries([...ofNode, ...ofBrowser].map((name) => [name, "readonly"])) },
  },
);
