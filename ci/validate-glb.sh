#!/usr/bin/env bash
# Bakes the demo and the test scenes with the release binary, and runs the Khronos glTF validator over every GLB.
# Any error or warning of the validator fails.
set -euo pipefail
cd "$(dirname "$0")/.."

out=target/validate-glb
umbrage=target/release/umbrage
rm -rf "$out"
mkdir -p "$out"

"$umbrage" demo --quiet --out-dir "$out"
for scene in occluder touching furnace; do
    "$umbrage" bake --quiet "testdata/scenes/$scene.glb" --output "$out/$scene.glb"
done
"$umbrage" bake --quiet testdata/scenes/touching.glb --output "$out/touching-uncut.glb" --no-discontinuities
"$umbrage" bake --quiet testdata/scenes/cornell.glb --output "$out/cornell-eq1.glb" --score eq1

npm ci --prefix ci/validate-glb --no-audit --no-fund
node ci/validate-glb/validate.mjs "$out"/*.glb
