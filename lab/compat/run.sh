#!/bin/sh
# Tries crates of others on forward and lean cameras, and prints a table of docs/your_game.md.
#
# sh lab/compat/run.sh [CRATE…]
#
# Without names all of `Cargo.toml` are tried, which builds Bevy with the features that they ask for. A crate is tried in a scene of five
# solids, at 480x270, without a window. PARITY_PICTURES=FOLDER keeps the pictures.
set -eu
cd "$(dirname "$0")"
sh ../../tests/install-debian.sh
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../../target}"
export WGPU_VALIDATION="${WGPU_VALIDATION:-0}" MESA_VK_IGNORE_CONFORMANCE_WARNING=1

features=default
if [ $# -gt 0 ]; then
    features=$(echo "$@" | tr ' ' ',')
fi
# The version of a crate that was built.
version() {
    cargo tree --quiet --no-default-features --features "$features" --depth 1 --prefix none | awk -v name="$1" '$1 == name { print $2 }'
}
tried="cargo run --quiet --no-default-features --features $features --"
names=$($tried)

echo "| crate | version | works | of the picture | PSNR from forward, dB | largest difference | forward afterwards |"
echo "|---|---|---|---|---|---|---|"
# One process each: a crate may end it.
for name in $names; do
    case $name in
    wireframe) version=$(version bevy) ;;
    *) version=$(version "$name") ;;
    esac
    row=$($tried "$name" | grep '^|') || row='| ends the app | – | – | – | – |'
    echo "| \`$name\` | ${version#v} $row"
done
