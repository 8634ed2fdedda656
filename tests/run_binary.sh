#!/bin/sh
# Called by `run.sh`: runs a test binary, unless it has passed as it is. Its results come in one piece; how long slow tests took, at once.
set -eu
binary=$1
name=$(basename "$binary")
# Its own sources, as rustc names them.
own_sources() {
    sed -n 's/^\([^ /][^ ]*\):$/\1/p' "$binary.d" | LC_ALL=C sort | xargs sha256sum
}
key=$({ own_sources && echo "${name%-*} $common"; } | sha256sum | cut -c1-64)
if [ -e "$LEAN_PASSED/$key" ]; then
    echo "$name: unchanged, has passed"
    exit
fi
started=$(date +%s)
# Each of the soak's tests is one process on a small picture, which leaves most of a core to others.
case $name in soak-*) threads=4 ;; *) threads=2 ;; esac
# These three have every pass, and changes between frames. The layer costs the others 7 % of their time.
case $name in apps-* | gbuffer-* | soak-*) layer=all ;; *) layer=${LEAN_TEST_LAYER:-none} ;; esac
[ "$layer" = all ] || export WGPU_VALIDATION=0
printed=$(mktemp)
result=passed
# shellcheck disable=SC2086 # none, or one argument
"$binary" "--test-threads=$threads" $nightly >"$printed" || result=failed
cat "$printed"
rm "$printed"
echo "$name: $result in $(($(date +%s) - started)) s"
[ $result = passed ]
touch "$LEAN_PASSED/$key"
