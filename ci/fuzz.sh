#!/usr/bin/env bash
# Builds all fuzz targets and runs each for so many seconds (60), as many at a time as there are processors; some may be left out:
# ci/fuzz.sh [SECONDS [but TARGET...]].
# Needs a C++ compiler, for libFuzzer; any Rust compiler will do, since instrumentation is stable and there is no unsafe code of ours
# for a sanitizer to watch. Findings and the grown corpus are left in target/fuzz.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
host=$(rustc -vV | sed -n 's/^host: //p')
out=$PWD/target/fuzz

run() {
    local target=$1 corpus=$out/corpus/$1 log=$out/$1.log seeds=fuzz/seeds/$1
    [ -d "$seeds" ] || seeds=
    # The corpus grows; seeds are read and not written.
    mkdir -p "$corpus"
    # The same beginning every time: what is found here is found again.
    # shellcheck disable=SC2086 # No seeds are no argument.
    if "$out/$host/release/$target" "$corpus" $seeds -max_total_time="$seconds" -rss_limit_mb=4096 -timeout=60 -seed=1 \
        -artifact_prefix="$out/found-$target-" -print_final_stats=1 >"$log" 2>&1; then
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

if ! command -v c++ >/dev/null; then
    echo "fuzz: there is no C++ compiler (c++): nothing was run"
    exit 0
fi
# The flags of cargo-fuzz without those of a sanitizer: coverage by edges and compared values.
sancov=-Cllvm-args=-sanitizer-coverage
export RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module $sancov-level=4 $sancov-inline-8bit-counters $sancov-pc-table \
$sancov-trace-compares -Ccodegen-units=1"
cargo build --release --locked --manifest-path fuzz/Cargo.toml --target "$host" --target-dir "$out"
left_out=" ${*:3} "
for target in fuzz/targets/*.rs; do
    target=$(basename "$target" .rs)
    case $left_out in *" $target "*) ;; *) echo "$target" ;; esac
done |
    xargs -P "$(nproc)" -I TARGET ci/fuzz.sh "$seconds" only TARGET
