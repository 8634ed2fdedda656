#!/bin/sh
# Installs what is missing and runs all tests.
set -eu
. "$(dirname "$0")/environment.sh"
cd "$(dirname "$0")/.."
# In debug builds wgpu notes where each of its locks was taken, with a backtrace where those are wanted. Panics have theirs
# all the same.
export RUST_LIB_BACKTRACE=0
# Two apps at a time: each render thread of a software driver takes all cores anyway.
exec cargo test --no-fail-fast "$@" -- --test-threads=2
