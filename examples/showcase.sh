#!/bin/sh
# Renders a street by night to a PNG (default: showcase.png): Bevy forward on the left, this crate on the right. Beside it a picture of
# each effect, off and on; and prints what all of it costs on this machine. Builds first, and on Debian asks before it installs
# what is missing.
#
# sh examples/showcase.sh [OUT.png] [--no-install] [--full] [further arguments of the example]
#
# --no-install installs nothing. Without a GPU the pictures are small and have part of the street; --full renders all of it there too.
# Further arguments go to the example: `--figure fox.glb --size 1920x1080`, or `--model model.glb`.
set -eu
here=$(dirname "$0")

# Takes `--no-install` out of the arguments.
for argument; do
    shift
    case $argument in
    --no-install) export LEAN_INSTALL=no ;;
    *) set -- "$@" "$argument" ;;
    esac
done
out=showcase.png
case ${1:-} in
"" | -*) ;;
*)
    out=$1
    shift
    ;;
esac

. "$here/../tests/environment.sh"

# Keeps messages of others out of the terminal: Mesa says that its software driver is not certified, EGL that there is no screen, the
# validation layer what it thinks of Bevy's shaders, and Wayland that its folder is missing, which a container does not have.
export MESA_VK_IGNORE_CONFORMANCE_WARNING=1
export EGL_LOG_LEVEL="${EGL_LOG_LEVEL:-fatal}"
export WGPU_VALIDATION="${WGPU_VALIDATION:-0}"
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    XDG_RUNTIME_DIR=$(mktemp -d)
    export XDG_RUNTIME_DIR
    trap 'rm -rf "$XDG_RUNTIME_DIR"' EXIT
fi

cargo run --manifest-path "$here/../Cargo.toml" --example showcase -- --headless "$out" "$@"
