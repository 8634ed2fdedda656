#!/bin/sh
# Checks every shader of the crate as a browser gets it: composed under the definitions that tests/shaders has, validated by naga with
# what WebGPU has and no more, written as WGSL by naga, and read by Tint, the compiler of Chromium.
#
#   sh examples/web/shaders.sh
#
# Tint is part of Dawn, which the npm package `webgpu` has for node; it is fetched into a cache folder. Without npm naga alone validates.
# A Vulkan driver is needed, and a software one will do: VK_DRIVER_FILES names it. `WEB_TARGET` is the target folder.
set -eu
cd "$(dirname "$0")"
cache="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/web"
out=${SHADERS_OUT:-$cache/shaders}
target=${WEB_TARGET:-$PWD/target}

# Bevy's crates hold the modules that ours import.
[ -e Cargo.lock ] || "${CARGO:-cargo}" generate-lockfile
bevy=$("${CARGO:-cargo}" metadata --quiet --format-version 1 --filter-platform wasm32-unknown-unknown | tr ',' '\n' |
    sed -n 's|^"manifest_path":"\(.*/bevy_[a-z_]*-[0-9.]*\)/Cargo.toml".*|\1/src|p' | sort -u)

rm -rf "$out"
# shellcheck disable=SC2086 # a list of folders
"${CARGO:-cargo}" run --quiet --manifest-path shaders/Cargo.toml --target-dir "$target/shaders" -- "$out" $bevy

if ! command -v npm >/dev/null; then
    echo "There is no npm: Tint has not read them."
    exit
fi
[ -e "$cache/node/node_modules/webgpu" ] || npm install --silent --prefix "$cache/node" webgpu@0.6.2
NODE_PATH="$cache/node/node_modules" node test/tint.mjs "$out"
