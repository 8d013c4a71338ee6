// The window of `umbrage view` shows what the page and the reference picture show. Run by ci/view.sh, after the page's tests,
// which leave their pictures.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { compare, differs, read } from "./pictures.mjs";
import { LOOKS, SCENES, SIZE, cameraOf, file } from "./scenes.mjs";

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const binary = process.env.UMBRAGE_VIEW || path.join(root, "target/debug/umbrage-view");

for (const scene of SCENES) {
  for (const [name, , options] of LOOKS) {
    test(`${scene.name}, ${name}: window, page and picture are the same`, async (t) => {
      const to = file(`${scene.name}-${name}-window.png`);
      const [width, height] = SIZE.map(String);
      const words = [file(`${scene.name}.glb`), "--screenshot", to, "--width", width, "--height", height];
      const run = spawnSync(binary, [...words, ...cameraOf(scene), ...options], { encoding: "utf8" });
      if (run.status !== 0 && run.stderr.includes("no graphics driver was found")) return t.skip(run.stderr);
      assert.equal(run.status, 0, run.stderr);
      const seen = await read(to);
      // The page draws its legend elsewhere, and it was hidden.
      const counts = (x, y) => name !== "false" || y < SIZE[1] - 40;
      for (const other of [`${scene.name}-${name}.png`, `${scene.name}-${name}-page.png`]) {
        const result = compare(await read(file(other)), seen, counts);
        assert.ok(!differs(result), `${other}: ${JSON.stringify(result)}`);
        assert.ok(result.compared > 2 * result.edges, `${other}: ${JSON.stringify(result)}`);
      }
    });
  }
}
