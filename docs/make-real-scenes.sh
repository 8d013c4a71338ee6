#!/bin/sh
# Makes the table of triangles in docs/real-scenes.md: bakes each scene at the default settings, and checks it by path tracing.
#
#     docs/make-real-scenes.sh UMBRAGE "SCENE [OPTIONS]"...
#
# One row a scene: polygons in, triangles out and their ratio, processor seconds, the estimate, and the error by `verify` with 1,000 points.
# A bake that takes more than LIMIT processor seconds (default 150) is given up, and so is a check of more than 60.
umbrage=$1
shift
limit=${LIMIT:-150}
dir=$(mktemp -d)
number() { grep -o "\"$1\": [0-9.e-]*" "$dir/report.json" | head -n 1 | sed 's/.*: //'; }
echo "| scene | polygons | triangles | times | CPU s | estimate | by \`verify\` |"
echo "|---|---|---|---|---|---|---|"
for scene in "$@"; do
    # The scene's options are words of their own.
    set -- $scene
    name=$(basename "$(dirname "$1")")/$(basename "$1")
    rm -f "$dir/report.json"
    if ! (ulimit -t "$limit" && time -p "$umbrage" -q bake "$@" -o "$dir/out.glb" --report "$dir/report.json") 2>"$dir/time"; then
        echo "| $name | | | | over $limit, or refused | | |"
        continue
    fi
    user=$(sed -n 's/^user //p' "$dir/time")
    error=$( (ulimit -t 60 && "$umbrage" verify "$1" "$dir/out.glb" --paths 512 $(shift; echo "$@") 2>/dev/null) |
        sed -n 's/^error *\([0-9.]* % +- [0-9.]* %\).*/\1/p')
    awk -v name="$name" -v polygons="$(number polygons)" -v triangles="$(number triangles)" -v user="$user" \
        -v estimate="$(number between_vertices)" -v error="$error" 'BEGIN {
            printf "| %s | %d | %d | %.1f | %.1f | %.2f %% | %s |\n",
                name, polygons, triangles, triangles / polygons, user, 100 * estimate, error }'
done
rm -r "$dir"
