// Run Khronos's glTF validator: node validate_gltf.mjs NODE_MODULES FILE.glb ... ; one JSON report a line.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const [modules, ...files] = process.argv.slice(2);
const validator = createRequire(resolve(modules, "x.js"))("gltf-validator");
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), { maxIssues: 20 });
  console.log(JSON.stringify({ file, ...report.issues }));
}
