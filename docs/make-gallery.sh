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

box=(--width 480 --height 480)
"$umbrage" render "$work/cornell.glb" -o "$pictures/gallery-cornell.png" "${box[@]}"
"$umbrage" render "$work/cornell.glb" -o "$pictures/gallery-cornell-mesh.png" "${box[@]}" --wireframe
"$umbrage" render "$work/cornell.glb" -o "$pictures/gallery-cornell-lux.png" "${box[@]}" --false-color lx

room=(--width 640 --height 480 --eye 4.2,1.75,3.85 --target 2.6,0.85,0.6 --fov 62)
"$umbrage" render "$work/room.glb" -o "$pictures/gallery-room.png" "${room[@]}" --exposure 1.5 --tone filmic
"$umbrage" render "$work/room.glb" -o "$pictures/gallery-room-mesh.png" "${room[@]}" --exposure 1.5 --tone filmic --wireframe
"$umbrage" render "$work/room.glb" -o "$pictures/gallery-room-lux.png" "${room[@]}" --false-color lx
