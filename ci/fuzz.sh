#!/bin/sh
# Builds all fuzz targets and runs each for so many seconds (60), as many at a time as there are processors: ci/fuzz.sh [SECONDS].
# Needs a nightly compiler; without one it says so and does nothing. cargo-fuzz is installed below target/ if it is not there.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
cargo_fuzz_version=0.13.2
tools=$PWD/target/ci-tools
PATH=$tools/bin:$PATH
export PATH

run() {
    target=$1
    seeds=fuzz/seeds/$target
    [ -d "$seeds" ] || seeds=
    # The corpus grows in fuzz/corpus; seeds are read and not written.
    mkdir -p "fuzz/corpus/$target"
    log=fuzz/corpus/$target.log
    # The same beginning every time: what is found here is found again.
    if cargo +nightly fuzz run "$target" "fuzz/corpus/$target" $seeds -- -max_total_time="$seconds" -rss_limit_mb=4096 \
        -timeout=60 -seed=1 -print_final_stats=1 >"$log" 2>&1; then
        echo "$target: $(grep -o 'number_of_executed_units: [0-9]*' "$log" | grep -o '[0-9]*$') inputs in $seconds s"
    else
        tail -n 40 "$log"
        echo "$target: failed"
        return 1
    fi
}
if [ "${2:-}" = "only" ]; then
    run "$3"
    exit
fi

if ! rustup toolchain list 2>/dev/null | grep -q '^nightly'; then
    echo "fuzz: there is no nightly compiler: nothing was run"
    exit 0
fi
if ! "$tools/bin/cargo-fuzz" fuzz --version 2>/dev/null | grep -qF "$cargo_fuzz_version"; then
    cargo install --locked --debug --root "$tools" --target-dir "$tools/build" "cargo-fuzz@$cargo_fuzz_version"
    rm -rf "$tools/build"
fi
cargo +nightly fuzz build
cargo +nightly fuzz list | xargs -P "$(nproc)" -I TARGET ci/fuzz.sh "$seconds" only TARGET
