// Baked files in other people's viewers: three.js and Babylon.js load the GLB with their own readers and draw it with
// their own renderers, and show what `umbrage render` shows. The bakes are so dark that nothing but lamps is cut off at
// white: where `COLOR_0` is cut off, these viewers interpolate what is left, and ours goes on above.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { start, tab } from "./browser.mjs";
import { compare, decoded, differs, keep, read } from "./pictures.mjs";
import { SIZE, bakeDim, folder, reference } from "./scenes.mjs";
import { BACKGROUND, ORIGIN, PAGES, site } from "./viewers.mjs";

const scenes = bakeDim();
let browser;
before(async () => {
  browser = await start();
});
after(() => browser?.close());

for (const [viewer, script] of Object.entries(PAGES)) {
  for (const scene of scenes) {
    test(`${viewer} shows ${scene.name} as we do`, async () => {
      const expected = await read(reference(scene, `${scene.name}-expected.png`));
      const { page, wrong, close } = await tab(browser, SIZE, { routes: site(script) });
      await page.goto(`${ORIGIN}/`);
      await page.waitForFunction(() => window.show);
      const { name, eye, target, fov } = scene;
      const what = { url: `/${name}.glb`, eye, target, fov, background: BACKGROUND };
      await page.evaluate((what) => window.show(what), what);
      const shot = await page.screenshot();
      await keep(folder, `${name}-${viewer}.png`, shot);
      await close();
      const result = compare(expected, decoded(shot));
      assert.ok(!differs(result), JSON.stringify(result));
      assert.ok(result.compared > 4 * result.edges, JSON.stringify(result));
      assert.deepEqual(wrong, []);
    });
  }
}
