#!/bin/sh
# Installs what is missing and runs all tests. Arguments are those of `cargo test`.
#
# Where LEAN_PASSED names a folder, and there are no arguments, a test binary that has passed, with the same assets and drivers, is not
# run again while it stays the same to the byte. Nothing else goes into what they show: shaders are in the binaries (if LEAN_SHADERS
# does not name others), and random numbers have seeds.
set -eu
. "$(dirname "$0")/environment.sh"
cd "$(dirname "$0")/.."
# In debug builds wgpu notes where each of its locks was taken, with a backtrace where those are wanted. Panics have theirs
# all the same.
export RUST_LIB_BACKTRACE=0
# Few apps at a time: each render thread of a software driver takes all cores, but no app keeps it busy all the time.
threads=--test-threads=3
if [ -z "${LEAN_PASSED:-}" ] || [ -n "${LEAN_SHADERS:-}" ] || [ $# -gt 0 ]; then
    exec cargo test --no-fail-fast "$@" -- $threads
fi

mkdir -p "$LEAN_PASSED"
# `sed` writes to its own standard error: `tee /dev/stderr` would open it anew, and empty it where it is a file.
built=$(cargo test --no-run 2>&1 | sed -n -e 'w /dev/stderr' -e 's/^  *Executable .*(\(.*\))$/\1/p')
# What is not in a binary.
around=$({
    find assets -type f -exec sha256sum {} + | sort
    env | grep -E '^(VK_|WGPU_|LP_|LEAN_TEST_|SOAK_|PARITY_)' | sort
    cat /usr/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json 2>/dev/null
    ls -l --time-style=+%s /usr/lib/*/libvulkan*.so* 2>/dev/null
} | sha256sum)
failed=""
CARGO_MANIFEST_DIR=$PWD
export CARGO_MANIFEST_DIR
for binary in $built; do
    name=$(basename "$binary")
    key=$({ sha256sum <"$binary" && echo "$around"; } | sha256sum | cut -c1-64)
    if [ -e "$LEAN_PASSED/$key" ]; then
        echo "$name: unchanged, has passed"
        continue
    fi
    started=$(date +%s)
    # Each of the soak's tests is one process on a small picture, which leaves most of a core to others.
    case $name in soak-*) own_threads=--test-threads=4 ;; *) own_threads=$threads ;; esac
    if "$binary" "$own_threads"; then
        touch "$LEAN_PASSED/$key"
        echo "$name: passed in $(($(date +%s) - started)) s"
    else
        failed="$failed $name"
    fi
done
cargo test --doc || failed="$failed documentation"
[ -z "$failed" ] || {
    echo "failed:$failed"
    exit 1
}
