#!/bin/sh
# Runs all benches and makes one page of their figures, report/index.html in the current folder, which opens from disk.
#
# sh examples/report.sh [--quick | --full] [--gltf FILE] [--only WORDS] [--out FOLDER]
#
# --quick, the default, takes small scenes and few frames: for a software renderer. --full is what the figures in the docs
# are made of, and wants a GPU.
set -eu
. "$(dirname "$0")/../tests/environment.sh"
exec cargo run --quiet --manifest-path "$(dirname "$0")/../Cargo.toml" --package bevy_lean_deferred_figures -- run "$@"
