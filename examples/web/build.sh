#!/bin/sh
# Builds the page into examples/web/www-built, to be served by anything: `python3 -m http.server --directory examples/web/www-built`.
#
#   sh examples/web/build.sh
#
# It needs the target wasm32-unknown-unknown, which it adds by rustup where there is one, and wasm-bindgen-cli of the version that
# Cargo.lock has, which it builds into a cache folder. `CARGO` names another cargo, `WASM_BINDGEN` another wasm-bindgen; `WEB_TARGET` the
# target folder, `WEB_OUT` where the page goes. `WEB_PROFILE=quick` builds in less time what is larger and slower. wasm-opt (Binaryen) is
# run if it is there; `WASM_OPT` names another.
set -eu
cd "$(dirname "$0")"
cargo=${CARGO:-cargo}
profile=${WEB_PROFILE:-release}
target=${WEB_TARGET:-$PWD/target}
out=${WEB_OUT:-$PWD/www-built}
cache="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/web"

fail() {
    echo "$*" >&2
    exit 1
}

"$cargo" --version >/dev/null 2>&1 || fail "There is no $cargo: install Rust (https://rustup.rs), or name another one by CARGO."

# The target. A compiler from elsewhere than rustup has it, or not.
sysroot=$("${RUSTC:-rustc}" --print sysroot)
if [ -z "${CARGO:-}" ] && [ ! -e "$sysroot/lib/rustlib/wasm32-unknown-unknown/lib" ]; then
    command -v rustup >/dev/null || fail "This Rust has no target wasm32-unknown-unknown, and there is no rustup to add it.
Debian has it as libstd-rust-dev-wasm32; CARGO names another cargo that has it."
    rustup target add wasm32-unknown-unknown || fail "rustup could not add the target wasm32-unknown-unknown."
fi

# In the version that the lock file has: both sides of the glue must agree.
[ -e Cargo.lock ] || "$cargo" generate-lockfile
version=$(sed -n '/^name = "wasm-bindgen"$/{n;s/^version = "\(.*\)"$/\1/p;}' Cargo.lock)
[ -n "$version" ] || fail "Cargo.lock has no wasm-bindgen."
bindgen=${WASM_BINDGEN:-$cache/wasm-bindgen-$version/bin/wasm-bindgen}
if ! "$bindgen" --version >/dev/null 2>&1; then
    set -- install wasm-bindgen-cli --version "$version" --root "$cache/wasm-bindgen-$version"
    # Sources that its lock file names may no longer exist.
    "${HOST_CARGO:-cargo}" "$@" --locked || "${HOST_CARGO:-cargo}" "$@" ||
        fail "wasm-bindgen-cli $version could not be installed."
fi

"$cargo" build --profile "$profile" --target wasm32-unknown-unknown --target-dir "$target"

rm -rf "$out"
mkdir -p "$out"
"$bindgen" --target web --no-typescript --remove-name-section --out-dir "$out" --out-name app \
    "$target/wasm32-unknown-unknown/$profile/bevy_lean_deferred_web.wasm"
cp page/* "$out/"

size() {
    bytes=$(wc -c <"$out/app_bg.wasm")
    zipped=$(gzip -9 -c "$out/app_bg.wasm" | wc -c)
    echo "$out: app_bg.wasm has $bytes bytes, $zipped by gzip, $*"
}

opt=${WASM_OPT:-wasm-opt}
size "without wasm-opt"
if [ "$profile" = release ] && version=$("$opt" --version 2>/dev/null); then
    number=${version#wasm-opt version }
    # Version 108, which Debian 12 has, exchanges tables.
    if [ "${number%% *}" -lt 120 ]; then
        echo "$version is too old, and was not run: 120 is needed." >&2
    else
        "$opt" -Oz "$out/app_bg.wasm" -o "$out/smaller.wasm"
        mv "$out/smaller.wasm" "$out/app_bg.wasm"
        size "by wasm-opt ${number%% *}"
    fi
fi
