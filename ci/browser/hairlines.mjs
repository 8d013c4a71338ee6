// Hairlines: dark pixels where a renderer confuses two surfaces that touch, or meets the dark side of an edge in place of
// the lit one. A pixel is one if it is clearly darker than what lies on both of its sides, and clearly darker than
// anything that the reference picture shows about there. The reference is finer and sampled many times, so that thin
// things, gaps and shadows, which are dark in earnest, are in it.

/** Darker than both sides: less than this share of the darker side's light. One black sample of four makes a pixel about
 *  half as bright, where a browser averages codes. */
const OF_SIDES = 0.6;
/** Darker than the reference: less than this share of the least light around. */
const OF_REFERENCE = 0.6;
/** Less light than this, linear, is too near to black for shares of it: code 8 of 255. */
const MIN_LIGHT = 0.0025;
/** Sides are this many pixels away at most: hairlines are one or two wide. */
const REACH = 2;
/** Steps to the one side; the other is opposite. */
const WAYS = [[1, 0], [0, 1], [1, 1], [1, -1]];

/** Linear light of each code. */
const LINEAR = Float32Array.from({ length: 256 }, (_, code) => {
  const s = code / 255;
  return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
});

/** The luminance of a picture: linear, by rows. */
export function luminance({ width, height, data }) {
  const light = new Float32Array(width * height);
  for (let i = 0; i < light.length; i++) {
    light[i] = 0.2126 * LINEAR[data[4 * i]] + 0.7152 * LINEAR[data[4 * i + 1]] + 0.0722 * LINEAR[data[4 * i + 2]];
  }
  return { width, height, light };
}

/** The least light in and around each pixel of a picture `times` smaller: of 3 x 3 of its pixels. */
export function least({ width, height, light }, times) {
  const rowsOf = (source, columns, rows, along, across) => {
    const size = Math.floor(columns / times), out = new Float32Array(size * rows);
    for (let row = 0; row < rows; row++) {
      for (let x = 0; x < size; x++) {
        let low = Infinity;
        const [from, to] = [Math.max(0, (x - 1) * times), Math.min(columns, (x + 2) * times)];
        for (let at = from; at < to; at++) low = Math.min(low, source[at * along + row * across]);
        out[row * size + x] = low;
      }
    }
    return out;
  };
  // First along x, then along y; each pass turns the picture over.
  const narrow = rowsOf(light, width, height, 1, width);
  const [w, h] = [Math.floor(width / times), Math.floor(height / times)];
  const turned = rowsOf(narrow, height, w, w, 1);
  const out = new Float32Array(w * h);
  for (let x = 0; x < w; x++) for (let y = 0; y < h; y++) out[y * w + x] = turned[x * h + y];
  return { width: w, height: h, light: out };
}

/** The pixels of hairlines in a picture, as [x, y], given the least light that may be around each pixel. */
export function hairlines({ width, height, light }, around) {
  if (around.width !== width || around.height !== height) {
    throw new Error(`sizes differ: ${width} x ${height} and ${around.width} x ${around.height}`);
  }
  const found = [];
  for (let y = REACH; y < height - REACH; y++) {
    for (let x = REACH; x < width - REACH; x++) {
      const at = y * width + x, here = light[at];
      if (here >= OF_REFERENCE * around.light[at]) continue;
      const isBetween = ([dx, dy]) => {
        let [one, other] = [0, 0];
        for (let d = 1; d <= REACH; d++) {
          one = Math.max(one, light[at + d * (dx + dy * width)]);
          other = Math.max(other, light[at - d * (dx + dy * width)]);
        }
        const side = Math.min(one, other);
        return side > MIN_LIGHT && here < OF_SIDES * side;
      };
      if (WAYS.some(isBetween)) found.push([x, y]);
    }
  }
  return found;
}
