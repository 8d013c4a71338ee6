// Runs the Khronos glTF validator on the GLBs given, prints every error and warning, and exits with 1 if there is one,
// or if no file is given. Hints and infos are counted only.
//
//     npm ci && node validate.mjs ../../target/tmp/validate/*.glb

import { readFile } from "node:fs/promises";
import { validateBytes, version } from "gltf-validator";

const SEVERITY = ["error", "warning", "info", "hint"];

const paths = process.argv.slice(2);
if (paths.length === 0) {
  console.error("usage: node validate.mjs FILE.glb...");
  process.exit(1);
}

console.log(`glTF validator ${version()}`);
let bad = 0;
for (const path of paths) {
  const bytes = new Uint8Array(await readFile(path));
  const { issues } = await validateBytes(bytes, { uri: path, format: "glb", maxIssues: 1000 });
  for (const issue of issues.messages.filter((message) => message.severity <= 1)) {
    console.log(`${path}: ${SEVERITY[issue.severity]} ${issue.code} at ${issue.pointer ?? issue.offset}: ${issue.message}`);
  }
  const { numErrors, numWarnings, numInfos, numHints } = issues;
  console.log(`${path}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`);
  bad += numErrors + numWarnings + (issues.truncated ? 1 : 0);
}
process.exit(bad === 0 ? 0 : 1);
