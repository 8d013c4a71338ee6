// The scenes of the tests: baked with the release binary of this project, each with a camera inside of it.

import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { PNG } from "pngjs";

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
export const folder = path.join(root, "target/browser");
mkdirSync(folder, { recursive: true });
export const testdata = path.join(root, "testdata");

const binary = process.env.UMBRAGE || path.join(root, "target/release/umbrage");
export const umbrage = (...words) => execFileSync(binary, [...words, "--quiet"], { stdio: ["ignore", "inherit", "inherit"] });
export const file = (name) => path.join(folder, name);

/** Size of the compared pictures, in pixels. */
export const SIZE = [640, 480];

export const SCENES = [
  { name: "cornell", eye: [0.28, 0.3, -0.6], target: [0.28, 0.25, 0.3], fov: 45 },
  { name: "touching", eye: [2.6, 1.6, 2.7], target: [1.2, 0.4, 0.6], fov: 60 },
  { name: "textured", eye: [0.28, 0.3, -0.6], target: [0.28, 0.25, 0.3], fov: 45 },
];

/** Ways to show a scene: name, what the page's address says, and the options of `umbrage render`. */
export const LOOKS = [
  ["plain", "", []],
  ["bright", "&exposure=2.5", ["--brighter", "2.5"]],
  ["filmic", "&exposure=3&tone=filmic", ["--brighter", "3", "--tone", "filmic"]],
  ["light", "&show=light", ["--light-only"]],
  ["false", "&show=irradiance&end=2000&unit=lx", ["--false-color", "lx", "--scale-end", "2000"]],
];

/** Bakes all scenes. */
export function bake() {
  umbrage("demo", "--out-dir", folder);
  umbrage("bake", path.join(testdata, "scenes/touching.glb"), "-o", file("touching.glb"));
  writeFileSync(file("textured-scene.glb"), withTexture(readFileSync(path.join(testdata, "scenes/cornell.glb"))));
  umbrage("bake", file("textured-scene.glb"), "-o", file("textured.glb"));
}

/** Bakes all scenes once more, so dark that no colour but a lamp's is cut off at white. */
export function bakeDim() {
  bake();
  const scenes = {
    cornell: path.join(testdata, "scenes/cornell.glb"),
    touching: path.join(testdata, "scenes/touching.glb"),
    textured: file("textured-scene.glb"),
  };
  for (const [name, scene] of Object.entries(scenes)) {
    const exposure = String(0.25 * json(readFileSync(file(`${name}.glb`))).asset.extras.umbrage.exposure);
    umbrage("bake", scene, "-o", file(`${name}-dim.glb`), "--exposure", exposure);
  }
  return SCENES.map((scene) => ({ ...scene, name: `${scene.name}-dim` }));
}

const json = (bytes) => JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));

/** The options that say from where a scene is seen. */
export const cameraOf = ({ eye, target, fov }) => ["--eye", eye.join(), "--target", target.join(), "--fov", String(fov)];

/** The reference picture of a scene. */
export const reference = (scene, name, ...words) => referenceOf(SIZE, scene, name, ...words);

/** The reference picture of a scene in another size. */
export function referenceOf(pixels, scene, name, ...words) {
  const [width, height] = pixels.map(String);
  const size = ["--width", width, "--height", height];
  umbrage("render", file(`${scene.name}.glb`), "-o", file(name), ...size, ...cameraOf(scene), ...words);
  return file(name);
}

/** A scene with a texture on all surfaces but lamps: smooth waves with round holes, laid out by position. */
function withTexture(bytes) {
  const jsonLength = bytes.readUInt32LE(12);
  const document = json(bytes);
  const parts = [bytes.subarray(28 + jsonLength)];
  let length = parts[0].length;
  const view = (data) => {
    document.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: data.length });
    const padded = Buffer.concat([data, Buffer.alloc(-data.length & 3)]);
    parts.push(padded);
    length += padded.length;
    return document.bufferViews.length - 1;
  };
  for (const { attributes } of document.meshes.flatMap((mesh) => mesh.primitives)) {
    const { bufferView, count, byteOffset = 0 } = document.accessors[attributes.POSITION];
    const { byteOffset: start = 0, byteStride = 12 } = document.bufferViews[bufferView];
    const uvs = Buffer.alloc(8 * count);
    for (let i = 0; i < count; i++) {
      const at = start + byteOffset + i * byteStride;
      const [x, y, z] = [0, 4, 8].map((offset) => parts[0].readFloatLE(at + offset));
      uvs.writeFloatLE(2 * (x + 0.3 * z), 8 * i);
      uvs.writeFloatLE(2 * (y - 0.7 * z), 8 * i + 4);
    }
    document.accessors.push({ bufferView: view(uvs), componentType: 5126, count, type: "VEC2" });
    attributes.TEXCOORD_0 = document.accessors.length - 1;
  }
  const image = new PNG({ width: 64, height: 64 });
  for (let i = 0; i < 64 * 64; i++) {
    const [u, v] = [i % 64, Math.floor(i / 64)].map((texel) => (2 * Math.PI * texel) / 64);
    image.data.set([Math.sin(u), Math.cos(v), Math.sin(u + v)].map((wave) => Math.round(180 + 60 * wave)), 4 * i);
    image.data[4 * i + 3] = Math.round(127.5 * (1 + Math.cos(u) * Math.cos(v)));
  }
  document.images = [{ bufferView: view(PNG.sync.write(image)), mimeType: "image/png" }];
  document.samplers = [{ magFilter: 9729, minFilter: 9987, wrapS: 10497, wrapT: 33648 }];
  document.textures = [{ source: 0, sampler: 0 }];
  const reflecting = document.materials.filter((material) => !material.emissiveFactor?.some((channel) => channel > 0));
  for (const material of reflecting) {
    material.pbrMetallicRoughness.baseColorTexture = { index: 0 };
    Object.assign(material, { alphaMode: "MASK", alphaCutoff: 0.2 });
  }
  document.buffers[0].byteLength = length;
  const text = Buffer.from(JSON.stringify(document));
  const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, " ")]);
  const head = Buffer.alloc(20);
  head.write("glTF");
  [2, 28 + padded.length + length, padded.length, 0x4e4f534a].forEach((word, i) => head.writeUInt32LE(word, 4 + 4 * i));
  const binaryHead = Buffer.alloc(8);
  [length, 0x004e4942].forEach((word, i) => binaryHead.writeUInt32LE(word, 4 * i));
  return Buffer.concat([head, padded, binaryHead, ...parts]);
}
