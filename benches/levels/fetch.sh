#!/bin/sh
# Fetches levels of free games from Debian's packages, and converts them to glTF for the bench `levels`.
#
#   sh benches/levels/fetch.sh [LEVEL…] [--out FOLDER] [--max-texture N]
#   sh benches/levels/fetch.sh [nexuiz] [stk]
#
# Writes each level into FOLDER/LEVEL (default: target/levels/LEVEL): scene.gltf, scene.bin, textures, lightmaps, level.json.
# --max-texture: larger textures are shrunk to N pixels. Without a level: lists those of both games, or of one. Packages are
# fetched by apt-get and unpacked in a cache folder, never into the system: 0.3 GB to list nexuiz_* and 0.5 GB more to convert,
# 0.6 GB for stk_*.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cache="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/levels"

fail() {
    echo "fetch.sh: $*" >&2
    exit 1
}

out="$here/../../target/levels" size=0 levels="" games=""
while [ $# -gt 0 ]; do
    case $1 in
    --out | --max-texture)
        [ $# -ge 2 ] || fail "$1 needs a value"
        if [ "$1" = --out ]; then out=$2; else size=$2; fi
        shift
        ;;
    stk_* | nexuiz_*) levels="$levels $1" ;;
    stk | nexuiz) games="$games $1" ;;
    -*) fail "unknown option: $1" ;;
    *) fail "no such level: $1 (names begin with stk_ or nexuiz_; \`stk\` and \`nexuiz\` list them)" ;;
    esac
    shift
done
case $size in *[!0-9]* | "") fail "--max-texture needs a number of pixels" ;; esac

apt() {
    apt-get -qq -oAPT::Sandbox::User=root "$@" 2>errors
}

# Downloads into the current folder: by the system's package lists or, if these lack the package, by lists in the cache.
download() {
    apt download "$1" && return
    mkdir -p "$cache/lists/partial" "$cache/apt/archives/partial"
    set -- "$1" -oDir::State::Lists="$cache/lists" -oDir::Cache="$cache/apt"
    apt "$2" "$3" update && apt "$2" "$3" download "$1"
}

# Unpacks a package into a folder of its name, which exists only once it is complete: fetch PACKAGE MEGABYTES
fetch() {
    [ ! -d "$cache/$1" ] || return 0
    for program in apt-get dpkg; do command -v "$program" >/dev/null || fail "$program is needed to fetch $1"; done
    echo "fetching $1, $2 MB" >&2
    part="$cache/$1.$$"
    trap 'rm -rf "$part"' EXIT
    trap 'exit 1' INT TERM
    mkdir -p "$part"
    (cd "$part" && download "$1") || fail "$1 could not be fetched: $(grep -m 1 ^E: "$part/errors" || echo "apt-get failed")"
    dpkg -x "$part"/*.deb "$part" || fail "$1 could not be unpacked"
    basename "$part"/*.deb >"$part/complete"
    rm "$part"/*.deb "$part/errors"
    mv "$part" "$cache/$1"
}

# python3 with NumPy and Pillow, which are installed into the cache if the system has none.
command -v python3 >/dev/null || fail "python3 is needed"
python=python3
if ! python3 -c "import numpy, PIL" 2>/dev/null; then
    python="$cache/venv/bin/python3"
    if ! "$python" -c "import numpy, PIL" 2>/dev/null; then
        echo "installing NumPy and Pillow" >&2
        python3 -m venv "$cache/venv" >/dev/null || fail "python3-venv is needed, or python3-numpy and python3-pil"
        "$python" -m pip -q install numpy pillow || fail "NumPy and Pillow could not be installed"
    fi
fi

# Fetches the packages of a game and runs its converter: convert PREFIX ARGUMENT…
convert() {
    case $1 in
    stk)
        converter=supertuxkart
        fetch supertuxkart-data 628
        ;;
    nexuiz)
        converter=nexuiz
        fetch nexuiz-data 267
        [ $# -eq 1 ] || fetch nexuiz-textures 456 # nexuiz-data has the names of the maps
        ;;
    esac
    shift
    "$python" -B "$here/convert/$converter.py" "$cache" "$@"
}

[ -n "$levels$games" ] || games="nexuiz stk"
for game in $games; do convert "$game"; done
for level in $levels; do
    convert "${level%%_*}" "$level" "$out/$level" --max-texture "$size"
    echo "*" >"$out/$level/.gitignore"
done
