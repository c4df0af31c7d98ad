// Bundle the studio into one classic script that also runs from file://, with three.js's licence beside it.
import { build } from "esbuild";
import { copyFileSync } from "node:fs";

const static_ = "../src/mien/viewer/static";
await build({
  entryPoints: ["src/main.js"],
  outfile: `${static_}/studio.js`,
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "inline",
});
copyFileSync("node_modules/three/LICENSE", `${static_}/studio.LICENSE`);
