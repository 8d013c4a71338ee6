// The web page of `umbrage page`: it shows what `umbrage render` shows, and does what its controls say.

import assert from "node:assert/strict";
import { statSync } from "node:fs";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { start, tab } from "./browser.mjs";
import { compare, decoded, differs, keep, read } from "./pictures.mjs";
import { LOOKS, SCENES, SIZE, bake, file, folder, reference, umbrage } from "./scenes.mjs";

/** A window in which the panel is open from the beginning. */
const WIDE = [1000, 700];
/** The page without its scene may be no larger, in bytes. */
const MOST_BYTES = 150_000;

let browser;
before(async () => {
  bake();
  for (const { name } of SCENES) umbrage("page", file(`${name}.glb`), "-o", file(`${name}.html`));
  browser = await start();
});
after(() => browser?.close());

const address = (scene, words = "") => {
  const view = `#eye=${scene.eye}&target=${scene.target}&fov=${scene.fov}${words}`;
  return pathToFileURL(file(`${scene.name}.html`)).href + view;
};

async function open(url, size = SIZE, options = {}) {
  const opened = await tab(browser, size, options);
  await opened.page.goto(url);
  await opened.page.waitForSelector("html[data-drawn=yes]", { state: "attached" });
  return opened;
}

/** A screenshot of the scene alone. */
async function bare(page) {
  await page.addStyleTag({ content: "#panel, #legend { visibility: hidden }" });
  // Textures are decoded, and the frame after it is drawn.
  await page.waitForTimeout(300);
  return page.screenshot();
}

for (const scene of SCENES) {
  for (const [name, words, options] of LOOKS) {
    test(`${scene.name}, ${name}: the page shows the reference picture`, async () => {
      const expected = await read(reference(scene, `${scene.name}-${name}.png`, ...options));
      const { page, wrong, close } = await open(address(scene, words));
      const shot = await bare(page);
      await keep(folder, `${scene.name}-${name}-page.png`, shot);
      await close();
      // The legend of the reference picture lies in its lower left corner.
      const counts = (x, y) => name !== "false" || y < SIZE[1] - 40;
      const result = compare(expected, decoded(shot), counts);
      assert.deepEqual(wrong, []);
      assert.ok(!differs(result), JSON.stringify(result));
      assert.ok(result.compared > 2 * result.edges, JSON.stringify(result));
    });
  }
}

test("triangles are drawn, and the panel's controls change the picture", async () => {
  const { page, wrong, close } = await open(address(SCENES[0]), WIDE);
  const seen = async () => {
    await page.waitForTimeout(100);
    return (await page.screenshot({ clip: { x: 400, y: 100, width: 300, height: 300 } })).toString("base64");
  };
  const views = [await seen()];
  await page.getByLabel("Triangles").check();
  views.push(await seen());
  await page.getByLabel("Film curve").check();
  views.push(await seen());
  await page.getByLabel("Exposure").focus();
  await page.keyboard.press("ArrowRight");
  views.push(await seen());
  await page.getByLabel("Show").selectOption("light");
  views.push(await seen());
  await page.getByLabel("Show").selectOption("irradiance");
  views.push(await seen());
  assert.equal(new Set(views).size, views.length);
  assert.ok(await page.getByRole("figure", { name: "Scale of the false colours" }).isVisible());
  assert.deepEqual(wrong, []);
  await close();
});

test("dragging, wheel, keys and buttons move the view, and a reset takes it back", async () => {
  const { page, wrong, close } = await open(pathToFileURL(file("cornell.html")).href, WIDE);
  const view = () => page.evaluate(() => location.hash);
  const begin = (await page.screenshot()).toString("base64");
  const views = [];
  await page.mouse.move(450, 300);
  await page.mouse.down();
  await page.mouse.move(520, 320, { steps: 4 });
  await page.mouse.up();
  views.push(await view());
  await page.mouse.wheel(0, -240);
  await page.waitForTimeout(100);
  views.push(await view());
  await page.locator("#view").focus();
  await page.keyboard.press("ArrowLeft");
  views.push(await view());
  await page.keyboard.down("w");
  // Drawn on the processor, a frame takes long.
  await page.waitForTimeout(2000);
  await page.keyboard.up("w");
  views.push(await view());
  await page.getByRole("button", { name: "Nearer" }).click();
  views.push(await view());
  await page.getByLabel("Through the scene").check();
  await page.mouse.move(450, 300);
  await page.mouse.down({ button: "right" });
  await page.mouse.move(400, 280, { steps: 3 });
  await page.mouse.up({ button: "right" });
  views.push(await view());
  assert.equal(new Set(views).size, views.length, views.join("\n"));
  await page.getByRole("button", { name: "Reset view" }).click();
  await page.getByLabel("Around the scene").check();
  await page.locator("#view").blur();
  await page.mouse.move(0, 0);
  await page.waitForTimeout(200);
  const again = decoded(await page.screenshot());
  const result = compare(decoded(Buffer.from(begin, "base64")), again, (x) => x > 320);
  assert.ok(!differs(result), JSON.stringify(result));
  assert.deepEqual(wrong, []);
  await close();
});

test("a click tells the irradiance, a double click goes on from there", async () => {
  const { page, wrong, close } = await open(address(SCENES[0]));
  await page.mouse.click(450, 400);
  assert.match(await page.getByRole("status").textContent(), /Irradiance here: [0-9.e-]+ W/);
  const view = () => page.evaluate(() => location.hash);
  const before = await view();
  await page.mouse.dblclick(450, 400);
  assert.notEqual(await view(), before);
  assert.deepEqual(wrong, []);
  await close();
});

test("two fingers bring the scene nearer", async () => {
  const { page, wrong, close } = await open(address(SCENES[0]), [390, 844], { hasTouch: true, isMobile: true });
  const session = await page.context().newCDPSession(page);
  const touch = (type, points) => session.send("Input.dispatchTouchEvent", {
    type, touchPoints: points.map(([x, y], id) => ({ x, y, id })),
  });
  const distance = async () => {
    const words = new URLSearchParams((await page.evaluate(() => location.hash)).slice(1));
    const [eye, target] = ["eye", "target"].map((name) => words.get(name).split(",").map(Number));
    return Math.hypot(...eye.map((x, i) => x - target[i]));
  };
  const before = await distance();
  await touch("touchStart", [[180, 500], [220, 500]]);
  await touch("touchMove", [[140, 500], [260, 500]]);
  await touch("touchEnd", []);
  const nearer = await distance();
  assert.ok(Math.abs(nearer - before / 3) < 0.05 * before, `${before} ${nearer}`);
  assert.deepEqual(wrong, []);
  await close();
});

test("every control has a name and the focus goes through all of them", async () => {
  const { page, close } = await open(address(SCENES[0], "&show=irradiance"), [1280, 800]);
  const nameless = await page.locator("button, input, select").evaluateAll((controls) => controls
    .filter((c) => !(c.labels?.length || c.ariaLabel || c.textContent.trim())).map((c) => c.outerHTML));
  assert.deepEqual(nameless, []);
  const met = new Set();
  await page.locator("#view").focus();
  for (let i = 0; i < 40; i++) {
    met.add(await page.evaluate(() => document.activeElement.id || document.activeElement.outerHTML.slice(0, 60)));
    const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
    if (i > 0 && (await page.evaluate(() => document.activeElement !== document.body))) assert.notEqual(outline, "none");
    await page.keyboard.press("Tab");
  }
  for (const id of ["view", "show", "wire", "scale-end", "unit"]) assert.ok(met.has(id), [...met].join("\n"));
  await close();
});

test("the page fits windows of three sizes", async () => {
  for (const [name, size, options] of [
    ["wide", [1440, 900], {}],
    ["tablet", [820, 1180], { deviceScaleFactor: 2 }],
    ["phone", [390, 844], { deviceScaleFactor: 3, isMobile: true, hasTouch: true }],
  ]) {
    const { page, wrong, close } = await open(pathToFileURL(file("cornell.html")).href, size, options);
    await keep(folder, `window-${name}.png`, await page.screenshot());
    if (name === "phone") {
      await page.locator("#controls > summary").tap();
      await page.getByLabel("Show").selectOption("irradiance");
      await page.waitForTimeout(200);
      await keep(folder, `window-${name}-open.png`, await page.screenshot());
    }
    const overflow = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
    assert.ok(overflow[0] <= overflow[1], `${name}: ${overflow}`);
    assert.deepEqual(wrong, []);
    await close();
  }
});

test("without WebGL 2 the page says so", async () => {
  const { page, close } = await tab(browser, SIZE);
  await page.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
  await page.goto(address(SCENES[0]));
  assert.match(await page.getByRole("alert").textContent(), /WebGL 2/);
  await close();
});

test("the page without its scene is small", async () => {
  const { page, close } = await open(address(SCENES[0]));
  const scene = await page.evaluate(() => about.textContent.length);
  await close();
  const tables = 4 * Math.ceil((await tablesOf("cornell")) / 3);
  assert.ok(statSync(file("cornell.html")).size - tables - scene < MOST_BYTES);
});

/** Bytes of a page's tables. */
async function tablesOf(name) {
  const { page, close } = await tab(browser, SIZE, { javaScriptEnabled: false });
  await page.goto(pathToFileURL(file(`${name}.html`)).href);
  const length = (await page.locator("#data").textContent()).length;
  await close();
  return (3 * length) / 4;
}
