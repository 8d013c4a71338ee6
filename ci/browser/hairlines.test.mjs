// No black hairlines: three.js shows the edges of real interiors without dark dots along them, at three sizes, with
// multisampling and without. The same pictures of bakes that keep what is hidden have hundreds, so the test can fail.
//
// Colours are interpolated inside of triangles (`centroid`). By default, multisampling takes them at the middle of a pixel
// that a triangle covers in part, beyond its edge, where light that changes along a floor seen at a grazing angle goes on
// to black: such dots are of the renderer, and every model with colours at its vertices has them.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { start, tab } from "./browser.mjs";
import { hairlines, least, luminance } from "./hairlines.mjs";
import { INTERIORS, bakeInterior } from "./interiors.mjs";
import { decoded, keep, read } from "./pictures.mjs";
import { folder, referenceOf } from "./scenes.mjs";
import { BACKGROUND, ORIGIN, site } from "./viewers.mjs";

const SIZES = [[320, 240], [480, 360], [640, 480]];
/** Size of the reference: a multiple of each. */
const FINE = [1920, 1440];
/** Near and far planes in metres: the nearest and farthest that are usual where one walks through rooms. */
const PLANES = { near: 0.01, far: 200 };

/** These show the dark inside or underside of things along their edges, if it is kept. */
const SHOW_HIDDEN = ["touching", "living_room"];
/** Fewer hairlines in all pictures of such a bake together, and the test would not find them. */
const MIN_KEPT = 100;

const SCRIPT = `
  import { Color, PerspectiveCamera, Scene, WebGLRenderer } from "/node_modules/three/build/three.module.js";
  import { GLTFLoader } from "/node_modules/three/examples/jsm/loaders/GLTFLoader.js";
  const inside = (shader) => {
    for (const stage of ["vertex", "fragment"]) {
      const name = stage + "Shader", colors = "#include <color_pars_" + stage + ">";
      if (!shader[name].includes(colors)) throw new Error("three.js declares colours in another way");
      shader[name] = shader[name].replace(colors, "centroid varying vec4 vColor;");
    }
  };
  window.show = async ({ url, views, sizes, near, far, background, antialias }) => {
    const renderer = new WebGLRenderer({ antialias });
    const scene = new Scene();
    scene.background = new Color(background);
    scene.add((await new GLTFLoader().loadAsync(url)).scene);
    scene.traverse(({ material }) => { if (material) material.onBeforeCompile = inside; });
    const pictures = [];
    for (const { eye, target, fov } of views) {
      for (const [width, height] of sizes) {
        renderer.setSize(width, height, false);
        const camera = new PerspectiveCamera(fov, width / height, near, far);
        camera.position.set(...eye);
        camera.lookAt(...target);
        renderer.render(scene, camera);
        pictures.push(renderer.domElement.toDataURL("image/png"));
      }
    }
    renderer.forceContextLoss();
    return pictures;
  };`;

let browser, page, wrong;
before(async () => {
  browser = await start();
  ({ page, wrong } = await tab(browser, SIZES[0], { routes: site(SCRIPT) }));
  await page.goto(`${ORIGIN}/`);
  await page.waitForFunction(() => window.show);
});
after(() => browser?.close());

/** The least light around the pixels of each picture, from references of the bake without what is hidden. */
async function around({ name, views }, baked) {
  const all = [];
  for (const [number, view] of views.entries()) {
    const scene = { ...view, name: baked.replace(".glb", "") };
    const fine = luminance(await read(referenceOf(FINE, scene, `${name}-${number}-fine.png`)));
    all.push(...SIZES.map(([width]) => least(fine, FINE[0] / width)));
  }
  return all;
}

/** How many pixels of each picture are in hairlines. */
async function count(baked, views, expected, antialias) {
  const what = { url: `/${baked}`, views, sizes: SIZES, ...PLANES, background: BACKGROUND, antialias };
  const pictures = await page.evaluate((what) => window.show(what), what);
  const counts = [];
  for (const [number, picture] of pictures.entries()) {
    const bytes = Buffer.from(picture.split(",")[1], "base64");
    counts.push(hairlines(luminance(decoded(bytes)), expected[number]).length);
    if (counts.at(-1) > 0) {
      await keep(folder, `${baked}-${number}-${antialias ? "multisampled" : "plain"}.png`, bytes);
    }
  }
  return counts;
}

const sum = (counts) => counts.reduce((total, each) => total + each, 0);

for (const interior of INTERIORS) {
  test(`three.js shows ${interior.name} without hairlines`, async () => {
    const baked = bakeInterior(interior);
    const expected = await around(interior, baked);
    for (const antialias of [false, true]) {
      const counts = await count(baked, interior.views, expected, antialias);
      assert.ok(sum(counts) <= (interior.known ?? 0), `multisampling ${antialias}: ${counts}`);
    }
    if (SHOW_HIDDEN.includes(interior.name)) {
      const counts = await count(bakeInterior(interior, true), interior.views, expected, true);
      assert.ok(sum(counts) >= MIN_KEPT, `what is hidden shows in ${counts} pixels`);
    }
    assert.deepEqual(wrong, []);
  });
}

test("a hairline is darker than both of its sides and than the reference", () => {
  const picture = (rows) => ({ width: rows[0].length, height: rows.length, light: Float32Array.from(rows.flat()) });
  const lit = Array.from({ length: 7 }, () => Array(7).fill(0.5));
  const withLine = (value) => lit.map((row) => row.map((light, x) => (x === 3 ? value : light)));
  const found = (seen, fine) => hairlines(picture(seen), least(picture(fine), 1)).length;
  assert.equal(found(withLine(0), lit), 3);
  assert.equal(found(withLine(0.25), lit), 3);
  assert.equal(found(withLine(0.45), lit), 0);
  // A thing that is dark in earnest is in the reference.
  assert.equal(found(withLine(0), withLine(0)), 0);
  // An edge of an area that is dark has one lit side.
  assert.equal(found(lit.map((row) => row.map((light, x) => (x < 3 ? light : 0))), lit), 0);
});
