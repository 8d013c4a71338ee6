#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md anew, with the release binary. The commands are the same as on that page.
set -euo pipefail
cd "$(dirname "$0")/.."

umbrage=target/release/umbrage
pictures=docs/pictures
work=target/gallery
mkdir -p "$work"

"$umbrage" demo --quiet --out-dir "$work"
"$umbrage" bake --quiet testdata/scenes/room.obj -o "$work/room.glb" --tolerance 0.05
outside=()
for ceiling in 0..Face2 1..Face2 2..Face3 3..Face2 4..Face3 5..Face3 6..Face9; do
    outside+=(--skip "House_Room_$ceiling")
done
for shade in 0 1 2 3 4 5 6 7 8; do outside+=(--skip "Context_Shade_$shade"); done
"$umbrage" bake --quiet testdata/others/single_family_home.obj -o "$work/home.glb" --tolerance 0.05 "${outside[@]}"

box=(--width 480 --height 480)
"$umbrage" render "$work/cornell.glb" -o "$pictures/gallery-cornell.png" "${box[@]}"
"$umbrage" render "$work/cornell.glb" -o "$pictures/gallery-cornell-mesh.png" "${box[@]}" --wireframe
"$umbrage" render "$work/cornell.glb" -o "$pictures/gallery-cornell-lux.png" "${box[@]}" --false-color lx

room=(--width 640 --height 480 --eye 4.2,1.75,3.85 --target 2.6,0.85,0.6 --fov 62)
"$umbrage" render "$work/room.glb" -o "$pictures/gallery-room.png" "${room[@]}" --brighter 1.5 --tone filmic
"$umbrage" render "$work/room.glb" -o "$pictures/gallery-room-mesh.png" "${room[@]}" --brighter 1.5 --tone filmic --wireframe
"$umbrage" render "$work/room.glb" -o "$pictures/gallery-room-lux.png" "${room[@]}" --false-color lx

home=(--width 640 --height 480 --eye 9.5,14.5,12.5 --target 0.3,0,0.5 --fov 44 --brighter 2 --tone filmic)
above=(--width 480 --height 480 --eye 0.01,29,1 --target 0,0,0.8 --fov 45)
"$umbrage" render "$work/home.glb" -o "$pictures/gallery-home.png" "${home[@]}"
"$umbrage" render "$work/home.glb" -o "$pictures/gallery-home-mesh.png" "${home[@]}" --wireframe
"$umbrage" render "$work/home.glb" -o "$pictures/gallery-home-lux.png" "${above[@]}" --false-color lx --scale-end 5000
