// Headless Chromium with WebGL2 on the processor (SwiftShader), the same wherever it runs.
//
// The browser is the npm package @sparticuz/chromium, so that no system package and no rights are needed, on x64 Linux
// with glibc. CHROMIUM=/path/to/chromium takes another one.

import bundled from "@sparticuz/chromium";
import { chromium } from "playwright-core";

const ARGUMENTS = [
  "--no-sandbox",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--force-color-profile=srgb",
  "--hide-scrollbars",
];

/** Starts the browser. */
export async function start() {
  const executablePath = process.env.CHROMIUM || (await bundled.executablePath());
  return chromium.launch({ executablePath, headless: true, args: ARGUMENTS });
}

/** A tab of a size in pixels that collects what goes wrong in it; network is refused unless `routes` answers. */
export async function tab(browser, [width, height], { routes, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, deviceScaleFactor: 1, ...options });
  const page = await context.newPage();
  const wrong = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) wrong.push(message.text());
  });
  page.on("pageerror", (error) => wrong.push(String(error)));
  await page.route(/^https?:/, async (route) => {
    if (routes && (await routes(route))) return;
    wrong.push(`asks the network for ${route.request().url()}`);
    await route.abort();
  });
  return { page, wrong, close: () => context.close() };
}
