#!/bin/sh
# Tries crates of others on forward and lean cameras: figures of the table in docs/your_game.md.
#
# sh lab/compat/run.sh [CRATE…]
#
# Without names all crates of Cargo.toml are tried, which builds Bevy again with the features that they ask for. A crate is tried in a scene
# of five solids, at 480x270, without a window. PARITY_PICTURES=FOLDER keeps the pictures.
set -eu
cd "$(dirname "$0")"
sh ../../tests/install-debian.sh
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../../target}"
export WGPU_VALIDATION="${WGPU_VALIDATION:-0}" MESA_VK_IGNORE_CONFORMANCE_WARNING=1

features=default
if [ $# -gt 0 ]; then
    features=$(echo "$@" | tr ' ' ',')
fi
cargo build --no-default-features --features "$features"
tried=$CARGO_TARGET_DIR/debug/bevy_lean_deferred_compat
# One process each: a crate may end it.
for name in $("$tried"); do
    "$tried" "$name" ../../docs/figures/llvmpipe/compat.json || echo "$name ended the app" >&2
done
