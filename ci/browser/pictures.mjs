// Pictures: from files and screenshots to bytes, and how two of them differ.

import { mkdir, readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { PNG } from "pngjs";

/** Codes that may differ between renderers of one picture. */
export const TOLERANCE = 2;
/** A pixel is on an edge if, in either picture, the codes of it and its neighbours spread further than this: there,
 *  renderers average samples in their own ways, and a sample more or less is a quarter of the spread. */
const EDGE = 6;
/** Share of the pixels that may differ all the same: on edges between colours that are nearly the same, which a sample
 *  more or less changes by more than the tolerance and which do not show as edges. */
const SHARE = 1e-4;

/** Whether so many pixels differ that the pictures are not the same. */
export const differs = ({ compared, different }) => different > SHARE * compared;

export const decoded = (bytes) => PNG.sync.read(Buffer.from(bytes));
export const read = async (file) => decoded(await readFile(file));

/** Keeps a picture to be looked at. */
export async function keep(folder, name, bytes) {
  await mkdir(folder, { recursive: true });
  await writeFile(path.join(folder, name), bytes);
}

/** Compares all but edge pixels: how many there are, how many differ by more than the tolerance, and the worst.
 *  `counts(x, y)` tells which pixels count. */
export function compare(expected, seen, counts = () => true) {
  const { width, height } = expected;
  if (seen.width !== width || seen.height !== height) {
    throw new Error(`sizes differ: ${width} x ${height} and ${seen.width} x ${seen.height}`);
  }
  let compared = 0, edges = 0, different = 0, worst = { by: 0 };
  for (let y = 1; y < height - 1; y++) {
    for (let x = 1; x < width - 1; x++) {
      if (!counts(x, y)) continue;
      if (Math.max(spread(expected, x, y), spread(seen, x, y)) > EDGE) {
        edges++;
        continue;
      }
      compared++;
      const at = 4 * (y * width + x);
      const by = Math.max(...[0, 1, 2].map((c) => Math.abs(expected.data[at + c] - seen.data[at + c])));
      if (by > TOLERANCE) different++;
      if (by > worst.by) worst = { by, x, y };
    }
  }
  return { compared, edges, different, worst };
}

function spread(picture, x, y) {
  let most = 0;
  for (let c = 0; c < 3; c++) {
    let low = 255, high = 0;
    for (let dy = -1; dy <= 1; dy++) {
      for (let dx = -1; dx <= 1; dx++) {
        const code = picture.data[4 * ((y + dy) * picture.width + x + dx) + c];
        low = Math.min(low, code);
        high = Math.max(high, code);
      }
    }
    most = Math.max(most, high - low);
  }
  return most;
}
