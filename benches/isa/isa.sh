#!/bin/sh
# What open compilers make of every shader that a Vulkan app uses, without their GPUs: Mesa's for AMD and, if asked for, for Intel.
#
#   sh isa.sh [--out FOLDER] [--families "FAMILY…"] [--only REGEX] [--text] [--driver mesa25] [-- COMMAND…]
#   sh isa.sh --images [--families "FAMILY…"]
#   sh isa.sh --fetch [--families "FAMILY…"]
#
# Runs the command, on whatever driver it finds or on Mesa 25's llvmpipe (`--driver mesa25`, which has binding arrays), and writes its
# pipelines into FOLDER/pipelines (default: isa/pipelines). Then compiles what is there for each family, into FOLDER/FAMILY.jsonl; with
# --only those whose path matches REGEX, into FOLDER/FAMILY.part.jsonl. Without a command: those that are there already. --text keeps
# SPIR-V, intermediate languages and assembly of each shader in FOLDER/text/FAMILY. --images prints which images a driver compresses.
# --fetch only fetches and builds what is missing, and prints the version of the compilers.
#
# Families: what RADV calls GPUs (navi21, vangogh, navi31, gfx1201 …; default: vangogh navi31), or Intel's platforms (tgl, dg2, mtl …);
# for --images those that Mesa's stand-in for AMD's kernel driver knows (polaris10, raven, navi10, navi21, vangogh, navi31, gfx1150).
#
# What is missing is fetched into a cache folder, never into the system: on Debian 12, Mesa from backports, and the loader's headers. A
# C compiler is needed. For Intel and for --images, Mesa's stand-ins for kernel drivers are built from its source, once, in some
# minutes: that needs python3-venv.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cache="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/drivers"
tools="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/isa"
mkdir -p "$cache" "$tools"
. "$here/../../tests/fetch.sh"

out=isa families="vangogh navi31" only=. part="" text="" driver="" images="" fetch_only=""
while [ $# -gt 0 ]; do
    case $1 in
    --out) out=$2 && shift 2 ;;
    --families) families=$2 && shift 2 ;;
    --only) only=$2 part=.part && shift 2 ;;
    --text) text=1 && shift ;;
    --driver) driver=$2 && shift 2 ;;
    --images) images=1 && shift ;;
    --fetch) fetch_only=1 && shift ;;
    --) shift && break ;;
    *) echo "isa.sh: unknown: $1" >&2 && exit 2 ;;
    esac
done

fetch_all() {
    fetch mesa25 bookworm-backports mesa-vulkan-drivers libllvm15 libz3-4 &&
        fetch libdrm bookworm-backports libdrm2 libdrm-amdgpu1 libdrm-intel1 &&
        fetch vulkan_headers bookworm libvulkan-dev || {
        echo "isa.sh: Mesa cannot be fetched: it comes from Debian 12's backports, by apt-get" >&2
        exit 1
    }
    command -v cc >/dev/null || { echo "isa.sh: no C compiler: install gcc" >&2 && exit 1; }
    libraries="$cache/mesa25/usr/lib/x86_64-linux-gnu"
    for name in radeon intel lvp; do
        sed "s|\"library_path\": *\"[^\"]*\"|\"library_path\": \"$libraries/libvulkan_$name.so\"|" \
            "$cache/mesa25/usr/share/vulkan/icd.d/${name}_icd".*json >"$tools/$name.json"
    done
    LD_LIBRARY_PATH="$libraries:$cache/libdrm/usr/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
}

# Mesa's stand-ins for the kernel drivers of Intel and AMD: no package has them.
build_shims() {
    shims="$cache/shims"
    [ ! -e "$shims/complete" ] || return 0
    echo "building Mesa's stand-ins for kernel drivers" >&2
    source="$cache/shims_source"
    rm -rf "$source"
    apt_in shims_source "deb deb-src" update
    apt_in shims_source "deb deb-src" source --download-only --tar-only mesa/bookworm-backports
    apt_in shims_source "deb deb-src" download bison flex m4 libdrm-dev libdrm2 libdrm-amdgpu1 libdrm-intel1
    for package in "$source"/*.deb; do dpkg -x "$package" "$source/root"; done
    mkdir "$source/mesa"
    tar xf "$source"/mesa_*.orig.tar.xz -C "$source/mesa" --strip-components 1
    sed -i "s|^prefix=.*|prefix=$source/root/usr|" "$source/root/usr/lib/x86_64-linux-gnu/pkgconfig/"*.pc
    # AMD's is built only along with a driver of AMD's.
    printf "inc_amd = include_directories('amd')\nsubdir('amd/drm-shim')\n" >>"$source/mesa/src/meson.build"
    python3 -m venv "$source/venv"
    "$source/venv/bin/pip" -q install meson ninja mako packaging pyyaml setuptools
    off=$(printf -- ' -D%s=disabled' glx egl gbm gles1 gles2 llvm valgrind libunwind gallium-va gallium-vdpau xmlconfig zstd)
    # shellcheck disable=SC2086 # a list of options
    (
        cd "$source/mesa"
        export PATH="$source/venv/bin:$source/root/usr/bin:$PATH" M4="$source/root/usr/bin/m4"
        export BISON_PKGDATADIR="$source/root/usr/share/bison"
        export PKG_CONFIG_PATH="$source/root/usr/lib/x86_64-linux-gnu/pkgconfig"
        meson setup build -Dtools=drm-shim,intel -Dbuildtype=release -Dopengl=false $off \
            -Dgallium-drivers= -Dvulkan-drivers= -Dplatforms= -Dvideo-codecs= >"$source/log"
        ninja -C build src/intel/tools/libintel_noop_drm_shim.so src/amd/drm-shim/libamdgpu_noop_drm_shim.so >>"$source/log"
        mkdir -p "$shims"
        cp build/src/intel/tools/libintel_noop_drm_shim.so build/src/amd/drm-shim/libamdgpu_noop_drm_shim.so "$shims/"
    )
    rm -rf "$source"
    touch "$shims/complete"
}

is_intel() {
    case $1 in bdw | skl | kbl | cfl | icl | tgl | rkl | adl | dg1 | dg2 | mtl | arl) true ;; *) false ;; esac
}

# Runs a program on a family's driver: on FAMILY PROGRAM ARGUMENT…
on() {
    family=$1 program=$2 icd=radeon preload=""
    shift 2
    if is_intel "$family"; then
        build_shims
        icd=intel preload="$shims/libintel_noop_drm_shim.so"
    elif [ "$program" = images ]; then
        # RADV without any device compiles shaders, but lays out no images.
        build_shims
        preload="$shims/libamdgpu_noop_drm_shim.so"
    fi
    set -- "$tools/$program" "$@"
    [ -n "$preload" ] || set -- "RADV_FORCE_FAMILY=$family" "$@"
    env LD_PRELOAD="$preload" INTEL_STUB_GPU_PLATFORM="$family" AMDGPU_GPU_ID="$family" LD_LIBRARY_PATH="$LD_LIBRARY_PATH" \
        VK_DRIVER_FILES="$tools/$icd.json" VK_ICD_FILENAMES="$tools/$icd.json" MESA_SHADER_CACHE_DISABLE=true NODEVICE_SELECT=1 "$@"
}

# Into the cache, if sources are newer; what runs is not written over: compile NAME SOURCE FLAG…
compile() {
    name=$1 source=$here/$2
    shift 2
    [ ! -e "$tools/$name" ] || [ -n "$(find "$source" "$here/recipe.h" -newer "$tools/$name")" ] || return 0
    cc -std=gnu11 -O1 -Wall -I "$cache/vulkan_headers/usr/include" "$source" -o "$tools/$name.$$" "$@"
    mv "$tools/$name.$$" "$tools/$name"
}

fetch_all
compile libisa_layer.so layer.c -fPIC -shared -fvisibility=hidden -lpthread
compile replay replay.c -l:libvulkan.so.1
compile images images.c -l:libvulkan.so.1
cp "$here/isa_layer.json" "$tools/"

if [ -n "$fetch_only" ]; then
    for family in $families; do ! is_intel "$family" || build_shims; done
    sed -n 's/^mesa-vulkan-drivers_/Mesa /p' "$cache/mesa25/complete"
    exit
fi
if [ -n "$images" ]; then
    for family in $families; do on "$family" images; done
    exit
fi

mkdir -p "$out/pipelines"
out=$(cd "$out" && pwd)
if [ $# -gt 0 ]; then
    (
        case $driver in
        "") ;;
        mesa25)
            export VK_DRIVER_FILES="$tools/lvp.json" VK_ICD_FILENAMES="$tools/lvp.json" LD_LIBRARY_PATH
            ;;
        *) echo "isa.sh: no driver is called $driver" >&2 && exit 2 ;;
        esac
        # Debug names are on in wgpu's debug builds; WGPU_DEBUG has them in others.
        export ISA_FOLDER="$out/pipelines" VK_LAYER_PATH="$tools" VK_INSTANCE_LAYERS=VK_LAYER_isa WGPU_DEBUG=1 WGPU_VALIDATION=0
        exec "$@"
    ) || echo "isa.sh: the command failed; what it made until then is looked at" >&2
fi

cd "$out/pipelines"
for family in $families; do
    set --
    if [ -n "$text" ]; then
        mkdir -p "$out/text/$family"
        set -- --text "$out/text/$family"
    fi
    # In the order in which the app made them.
    find . -name '*.pipeline' -printf '%T@ %P\n' | LC_ALL=C sort -n | cut -d' ' -f2- | grep -E -e "$only" >"$out/$family.paths"
    on "$family" replay "$@" <"$out/$family.paths" >"$out/$family$part.jsonl" 2>"$out/$family.log" || {
        echo "isa.sh: not all pipelines compile for $family, see $out/$family.log" >&2
    }
    rm "$out/$family.paths"
done
