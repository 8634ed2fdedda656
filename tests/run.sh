#!/bin/sh
# Installs what is missing and runs all tests.
set -eu
. "$(dirname "$0")/environment.sh"
cd "$(dirname "$0")/.."
# Two apps at a time: each render thread of a software driver takes all cores anyway.
exec cargo test --no-fail-fast "$@" -- --test-threads=2
