#!/bin/sh
# Runs benches and makes one page of their figures, report/index.html in the current folder, which opens from disk, and one file of
# them, report/figures.json.
#
# sh examples/report.sh [--quick | --gpu | --full] [--gltf FILE] [--only WORDS] [--out FOLDER]
#
# --quick, the default, takes small scenes and few frames: for a software renderer. --gpu takes five minutes on any GPU, once built:
# docs/your_gpu.md. --full is what the figures in the docs are made of, and wants a GPU.
set -eu
. "$(dirname "$0")/../tests/environment.sh"
exec cargo run --quiet --manifest-path "$(dirname "$0")/../Cargo.toml" --package bevy_lean_deferred_figures -- run "$@"
