#!/bin/sh
# Installs what is missing, builds, and renders a street by night to a PNG (default: showcase.png): Bevy forward on the left, this crate
# on the right. Beside it a picture of each effect, off and on; and prints what all of it costs on this machine.
# Further arguments go to the example: `sh examples/showcase.sh out.png --figure fox.glb --size 1920x1080`, or `--model model.glb`.
set -eu
. "$(dirname "$0")/../tests/environment.sh"
out="${1:-showcase.png}"
[ $# -eq 0 ] || shift
exec cargo run --manifest-path "$(dirname "$0")/../Cargo.toml" --example showcase -- --headless "$out" "$@"
