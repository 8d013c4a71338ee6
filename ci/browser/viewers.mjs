// Other people's viewers, each as a page of a small site that loads a baked file and shows it.

import { readFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { file } from "./scenes.mjs";

const here = path.dirname(fileURLToPath(import.meta.url));
/** The site's address. */
export const ORIGIN = "http://localhost";
/** Behind the scene: linear 0.03, as in our pictures. */
export const BACKGROUND = "#303030";

/** The script of each viewer: its `show` draws a file. */
export const PAGES = {
  "three.js": `
    import { Color, PerspectiveCamera, Scene, WebGLRenderer } from "/node_modules/three/build/three.module.js";
    import { GLTFLoader } from "/node_modules/three/examples/jsm/loaders/GLTFLoader.js";
    window.show = async ({ url, eye, target, fov, background }) => {
      const renderer = new WebGLRenderer({ canvas, antialias: true });
      renderer.setSize(innerWidth, innerHeight, false);
      const scene = new Scene();
      scene.background = new Color(background);
      scene.add((await new GLTFLoader().loadAsync(url)).scene);
      const camera = new PerspectiveCamera(fov, innerWidth / innerHeight, 0.01, 20);
      camera.position.set(...eye);
      camera.lookAt(...target);
      renderer.render(scene, camera);
    };`,
  "Babylon.js": `
    import { FreeCamera } from "/node_modules/@babylonjs/core/Cameras/freeCamera.js";
    import { Engine } from "/node_modules/@babylonjs/core/Engines/engine.js";
    import { Color4 } from "/node_modules/@babylonjs/core/Maths/math.color.js";
    import { Vector3 } from "/node_modules/@babylonjs/core/Maths/math.vector.js";
    import { Scene } from "/node_modules/@babylonjs/core/scene.js";
    import "/node_modules/@babylonjs/core/Loading/loadingScreen.js";
    import { SceneLoaderFlags } from "/node_modules/@babylonjs/core/Loading/sceneLoaderFlags.js";
    import { AppendSceneAsync } from "/node_modules/@babylonjs/core/Loading/sceneLoader.js";
    import "/node_modules/@babylonjs/loaders/glTF/2.0/index.js";
    window.show = async ({ url, eye, target, fov, background }) => {
      SceneLoaderFlags.ShowLoadingScreen = false;
      const engine = new Engine(canvas, true, { useExactSrgbConversions: true });
      const scene = new Scene(engine);
      scene.useRightHandedSystem = true;
      scene.clearColor = Color4.FromHexString(background + "ff");
      await AppendSceneAsync(url, scene);
      const camera = new FreeCamera("camera", new Vector3(...eye), scene);
      camera.setTarget(new Vector3(...target));
      camera.fov = (fov * Math.PI) / 180;
      camera.minZ = 0.01;
      camera.maxZ = 20;
      scene.activeCamera = camera;
      await scene.whenReadyAsync();
      scene.render();
      scene.render();
    };`,
};
const TYPES = { ".js": "text/javascript", ".html": "text/html", ".glb": "model/gltf-binary" };

/** Answers for a small site: the viewer's page, its modules, and the baked files. */
export function site(script) {
  const html = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
    <style>body { margin: 0 } canvas { display: block; width: 100vw; height: 100vh }</style>
    <canvas id="canvas"></canvas>
    <script type="importmap">{"imports": {
      "three": "/node_modules/three/build/three.module.js",
      "@babylonjs/core/": "/node_modules/@babylonjs/core/",
      "@babylonjs/loaders/": "/node_modules/@babylonjs/loaders/"
    }}</script>
    <script type="module">${script}</script>`;
  return async (route) => {
    const { pathname } = new URL(route.request().url());
    const type = TYPES[path.extname(pathname)] ?? "text/html";
    const name = path.normalize(pathname);
    const body = name.endsWith(".glb") ? await readFile(file(path.basename(name)))
      : name.startsWith("/node_modules/") ? await readFile(path.join(here, name))
      : html;
    await route.fulfill({ body, contentType: type });
    return true;
  };
}
