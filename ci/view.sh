#!/usr/bin/env bash
# Tests of the window (crate umbrage-view), which is not built by default: its own tests, and that window, page and picture of
# the browser's scenes are the same picture; so ci/browser.sh comes before. Needs a graphics driver; where there is none and
# this is a Debian whose packages can be installed, that is Mesa's, which draws without a graphics card.
set -euo pipefail
cd "$(dirname "$0")/.."

has_driver() {
    [[ $(ldconfig -p) == *libEGL_mesa* ]] || compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null
}

if ! has_driver && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq
    apt-get install -qq --no-install-recommends mesa-vulkan-drivers libvulkan1 >/dev/null
fi

cargo test -p umbrage-view
cargo build -p umbrage-view
node --test ci/browser/window.mjs
