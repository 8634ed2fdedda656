#!/bin/sh
# Opens the built page in a headless Chromium, toggles every switch, reads pixels back, and compares lean with forward.
#
#   sh examples/web/build.sh && sh examples/web/test.sh
#
# It needs node, npm and Chromium (`CHROMIUM` names one that is not in the path); playwright-core comes into a cache folder. WebGPU
# runs on SwiftShader, which Chromium has, so no GPU is needed; `CHROMIUM_FLAGS=` asks for the machine's own. `WEB_OUT` is the folder
# of the page, `WEB_PICTURES` one for pictures, `VERBOSE=1` shows the page's console.
set -eu
cd "$(dirname "$0")"
out=${WEB_OUT:-$PWD/www-built}
cache="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/web"

fail() {
    echo "$*" >&2
    exit 1
}

[ -e "$out/app_bg.wasm" ] || fail "There is no page in $out: sh examples/web/build.sh makes it."
command -v npm >/dev/null || fail "There is no npm."
if [ -z "${CHROMIUM:-}" ]; then
    for name in chromium chromium-browser google-chrome; do
        CHROMIUM=$(command -v $name) && break
    done
    [ -n "$CHROMIUM" ] || fail "There is no Chromium. On Debian: apt-get install chromium."
fi
export CHROMIUM
[ -e "$cache/node/node_modules/playwright-core" ] || npm install --silent --prefix "$cache/node" playwright-core@1
NODE_PATH="$cache/node/node_modules" exec node test/test.mjs "$out"
