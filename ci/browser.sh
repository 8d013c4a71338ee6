#!/usr/bin/env bash
# Tests in headless Chromium: the page of `umbrage page` against `umbrage render`, and baked files in other people's
# viewers. Takes the release binary. Installs the browser and the viewers from npm; CHROMIUM=/path takes another browser.
set -euo pipefail
cd "$(dirname "$0")/.."

npm ci --prefix ci/browser --no-audit --no-fund --ignore-scripts
# The bundled browser is unpacked into the folder for temporary files.
mkdir -p target/browser/tmp
cd ci/browser
TMPDIR="$PWD/../../target/browser/tmp" npm test
