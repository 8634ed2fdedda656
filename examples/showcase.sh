#!/bin/sh
# Installs what is missing and renders the viewer's built-in scene to a PNG (default: showcase.png).
# Further arguments go to the viewer: `sh examples/showcase.sh out.png model.glb --size 1920x1080`.
set -eu
. "$(dirname "$0")/../tests/environment.sh"
out="${1:-showcase.png}"
[ $# -eq 0 ] || shift
exec cargo run --quiet --example viewer -- --headless "$out" "$@"
