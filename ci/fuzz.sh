#!/bin/sh
# Builds all fuzz targets and runs each for so many seconds (60): ci/fuzz.sh [SECONDS]. Needs a nightly compiler and cargo-fuzz.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
cargo +nightly fuzz build
for target in $(cargo +nightly fuzz list); do
    seeds=fuzz/seeds/$target
    [ -d "$seeds" ] || seeds=
    # The corpus grows in fuzz/corpus; seeds are read and not written.
    mkdir -p "fuzz/corpus/$target"
    cargo +nightly fuzz run "$target" "fuzz/corpus/$target" $seeds -- -max_total_time="$seconds" -rss_limit_mb=4096 -timeout=30
done
