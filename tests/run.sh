#!/bin/sh
# Installs missing packages and runs all tests but the nightly ones. Arguments are those of `cargo test`.
#
# LEAN_TEST_NIGHTLY=1 runs the nightly tests too. LEAN_TEST_LAYER=all loads Vulkan's validation layer in all test binaries.
#
# If LEAN_PASSED names a folder, and there are no arguments, a test binary that has passed is not run again while its sources, the
# toolchain, drivers and settings are the same. (Not while the binary is: rustc writes another one each time.)
set -eu
. "$(dirname "$0")/environment.sh"
cd "$(dirname "$0")/.."
# In debug builds wgpu notes where each of its locks was taken, with a backtrace where those are wanted. Panics have theirs
# all the same.
export RUST_LIB_BACKTRACE=0
# llvmpipe runs most shaders for a few small pictures: compiling them well takes longer than it saves.
export GALLIVM_PERF="${GALLIVM_PERF:-nopt}"
# Few apps at a time: each render thread of a software driver takes all cores, but no app keeps it busy all the time.
threads=--test-threads=3
nightly=${LEAN_TEST_NIGHTLY:+--include-ignored}
if [ -z "${LEAN_PASSED:-}" ] || [ -n "${LEAN_SHADERS:-}" ] || [ $# -gt 0 ]; then
    exec cargo test --no-fail-fast "$@" -- $threads $nightly
fi

mkdir -p "$LEAN_PASSED"
# `sed` writes to its own standard error: `tee /dev/stderr` would open it again, and truncate it if it is a file.
built=$(cargo test --no-run 2>&1 | sed -n -e 'w /dev/stderr' -e 's/^  *Executable .*(\(.*\))$/\1/p')
# Inputs that all of them depend on: libraries, the examples that tests run, the toolchain, drivers and settings.
common=$({
    find Cargo.toml Cargo.lock assets examples lab src tests/*.sh -type f -print0 | LC_ALL=C sort -z | xargs -0 sha256sum
    rustc -vV
    env | grep -E '^(VK_|WGPU_|LP_|GALLIVM_|LEAN_TEST_|SOAK_|PARITY_|PROPTEST_)' | LC_ALL=C sort
    cat /usr/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json 2>/dev/null || true
    cat /usr/lib/*/libvulkan.so* /usr/lib/*/libvulkan_lvp.so 2>/dev/null || true
} | sha256sum)
CARGO_MANIFEST_DIR=$PWD
export CARGO_MANIFEST_DIR LEAN_PASSED common nightly
# Two at a time: the last test of a binary leaves a core to those of the next one.
failed=""
printf '%s\n' $built | xargs -P 2 -n 1 sh tests/run_binary.sh || failed=" tests, named above"
cargo test --doc || failed="$failed documentation"
[ -z "$failed" ] || {
    echo "failed:$failed"
    exit 1
}
