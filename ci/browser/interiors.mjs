// Real interiors, baked coarsely, each with cameras inside it that look along edges: where walls meet floors, at the
// frames of windows, at the feet of furniture, and nearly along a floor.
//
// No view shows where a wall without thickness parts two lit rooms, from the brighter one. The floor of the darker room
// begins right behind the wall, and a renderer with coarse depths shows some of it, which is not black. A bake cannot
// mend that: each of the two sides shows its own light up to the wall.

import path from "node:path";
import { file, testdata, umbrage } from "./scenes.mjs";

/** Name, file below `testdata`, options of `umbrage bake`, and views: eye, target, field of view in degrees; lengths in
 *  metres. */
export const INTERIORS = [
  {
    name: "room",
    scene: "scenes/room.obj",
    // At 0.1 a vertex in the gap behind the shelf shows no light at all, and is a dark dot.
    tolerance: "0.03",
    views: [
      { eye: [0.4, 1.6, 3.6], target: [4.2, 0.5, 1.2], fov: 60 },
      { eye: [4.6, 0.5, 3.7], target: [1.4, 0.4, 1], fov: 60 },
      { eye: [2.2, 0.5, 2.8], target: [1.0, 0.3, 0.6], fov: 60 },
    ],
  },
  {
    name: "touching",
    scene: "scenes/touching.glb",
    views: [
      { eye: [2.6, 1.6, 2.7], target: [1.2, 0.4, 0.6], fov: 60 },
      { eye: [0.3, 0.2, 2.6], target: [2.5, 0.1, 0.4], fov: 60 },
    ],
  },
  {
    name: "cornell",
    scene: "scenes/cornell.obj",
    views: [
      { eye: [0.28, 0.3, -0.6], target: [0.28, 0.25, 0.3], fov: 45 },
      { eye: [0.5, 0.1, 0.05], target: [0.1, 0.05, 0.5], fov: 60 },
    ],
  },
  {
    name: "single_family_home",
    scene: "others/single_family_home.obj",
    views: [
      { eye: [-2.2, 1.5, 5.6], target: [-0.5, 0.8, 8.8], fov: 45 },
      { eye: [-3.3, 1.3, 6.1], target: [-0.9, 0.2, 8.7], fov: 40 },
    ],
  },
  {
    name: "lab_building",
    scene: "others/lab_building.obj",
    views: [
      { eye: [-34, 20.6, -96], target: [-34, 19.2, -84], fov: 60 },
      { eye: [-47, 20.2, -98], target: [-38, 19.2, -92], fov: 60 },
    ],
  },
  {
    name: "patient_room",
    scene: "others/model_complete_patient_room.obj",
    views: [
      { eye: [4.2, 1.6, -8.5], target: [1.0, 0.6, 0], fov: 60 },
      { eye: [0.4, 0.3, -4], target: [3, 0.2, 0], fov: 60 },
    ],
  },
  {
    name: "office_floor",
    scene: "others/model_complete_office_floor.obj",
    views: [
      { eye: [25, 1.6, -1.2], target: [5, 0.5, -8], fov: 60 },
      { eye: [18, 1.4, -18], target: [10, 0.8, -10], fov: 60 },
    ],
  },
  {
    name: "grid_views",
    scene: "others/model_radiance_grid_views.obj",
    views: [
      { eye: [9.6, 0.5, -1], target: [6, 0.2, -10], fov: 60 },
      { eye: [2.5, 1.2, -3], target: [0.3, 0.4, -0.2], fov: 50 },
    ],
  },
  {
    name: "bevy_cornell",
    scene: "others/bevy_cornell.glb",
    options: ["--unit", "cm"],
    views: [
      { eye: [-2.78, 2.2, 3.5], target: [-2.78, 1.2, -3], fov: 45 },
      { eye: [-5, 0.5, -0.5], target: [-1, 0.8, -5], fov: 60 },
    ],
  },
  {
    name: "mcguire_cornell",
    scene: "others/mcguire_cornell.obj",
    views: [
      { eye: [0, 1, 3], target: [0, 1, 0], fov: 45 },
      { eye: [-0.9, 0.1, 0.9], target: [0.8, 0.2, -0.9], fov: 60 },
    ],
  },
  {
    name: "living_room",
    scene: "others/living_room.glb",
    views: [
      { eye: [1.5, 2.2, 1.2], target: [-2, 1.3, -1], fov: 60 },
      { eye: [0, 2.6, -1.5], target: [0.5, 1.5, 2.4], fov: 60 },
      { eye: [-3.5, 1.5, 1.8], target: [0.5, 0.9, -2], fov: 60 },
    ],
  },
];

/** Coarse, unless an interior says otherwise: edges of surfaces are where they are at any tolerance. */
const TOLERANCE = "0.1";

/** Bakes an interior; with what is hidden, if asked. Returns the baked file's name. */
export function bakeInterior({ name, scene, tolerance = TOLERANCE, options = [] }, keepHidden = false) {
  const baked = `${name}${keepHidden ? "-kept" : ""}-interior.glb`;
  const more = keepHidden ? ["--keep-hidden"] : [];
  umbrage("bake", path.join(testdata, scene), "-o", file(baked), "--tolerance", tolerance, ...options, ...more);
  return baked;
}
