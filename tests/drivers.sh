#!/bin/sh
# Runs the tests on each Vulkan driver that is available here, and prints a table of drivers and topics.
#
#   sh tests/drivers.sh [DRIVER…] [-- FILTER…]
#
# Drivers: mesa22-4, mesa22-8, mesa22-16 (Mesa 22's llvmpipe with subgroups of 4, 8, 16), mesa25 (it has binding arrays), swiftshader,
# webgpu (Mesa 22 with no more than WebGPU's default limits and features), own (this machine's GPU, if it has one). Without names:
# all of them.
# Filters are names of tests, or parts of them. TOPICS names some of the test binaries, separated by spaces. BINARIES names a folder of
# test binaries, called as the topics are, and the viewer, that were built elsewhere: for a machine with a GPU and without Rust. THREADS
# says how many tests run at a time, 2 if not said: each render thread of a software driver takes all cores anyway. With
# `-- --include-ignored` the nightly tests run too.
#
# Missing drivers are downloaded into a cache folder, never into the system: on Debian 12, from the sources of its packages. Each
# driver's log is kept there too.
set -eu
[ -n "${BINARIES:-}" ] || . "$(dirname "$0")/environment.sh"
cd "$(dirname "$0")/.."
. tests/fetch.sh
export RUST_LIB_BACKTRACE=0
# As in `run.sh`.
export GALLIVM_PERF="${GALLIVM_PERF:-nopt}"
cache="${XDG_CACHE_HOME:-$HOME/.cache}/bevy_lean_deferred/drivers"
logs="$cache/logs"
mkdir -p "$logs"

all="mesa22-4 mesa22-8 mesa22-16 mesa25 swiftshader webgpu own"
topics="${TOPICS:-shaders gbuffer pictures ambient_occlusion auto_exposure screen_space apps soak}"
# One test binary may take so many seconds.
limit="${LIMIT:-3600}"

drivers=""
while [ $# -gt 0 ]; do
    case $1 in
    --) shift && break ;;
    *) drivers="$drivers $1" && shift ;;
    esac
done
[ -n "$drivers" ] || drivers=$all

# Makes the loader use the driver that this file of its folder describes, and rewrites that file with the library's whole path.
use() { # folder, description, library
    description="$cache/$1/driver.json"
    sed "s|\"library_path\": *\"[^\"]*\"|\"library_path\": \"$cache/$1/$3\"|" "$cache/$1/$2" >"$description"
    VK_DRIVER_FILES=$description VK_ICD_FILENAMES=$description
    LD_LIBRARY_PATH="$cache/$1/usr/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
    export VK_DRIVER_FILES VK_ICD_FILENAMES LD_LIBRARY_PATH WGPU_BACKEND=vulkan
}

mesa() { # folder, suite
    fetch "$1" "$2" mesa-vulkan-drivers libllvm15 libz3-4 || return 1
    description=$(cd "$cache/$1" && ls usr/share/vulkan/icd.d/lvp_icd*.json)
    use "$1" "$description" usr/lib/x86_64-linux-gnu/libvulkan_lvp.so
}

# Sets the environment for a driver, or says why it cannot be had.
select_driver() {
    case $1 in
    mesa22-4) mesa mesa22 bookworm && export LP_NATIVE_VECTOR_WIDTH=128 ;;
    mesa22-8) mesa mesa22 bookworm && export LP_NATIVE_VECTOR_WIDTH=256 ;;
    mesa22-16) mesa mesa22 bookworm && export LP_NATIVE_VECTOR_WIDTH=512 ;;
    mesa25) mesa mesa25 bookworm-backports ;;
    webgpu) mesa mesa22 bookworm && export LEAN_TEST_DEVICE=webgpu ;;
    swiftshader)
        # With idle lanes in a subgroup it reads binding arrays at indices that the shader does not use, and crashes.
        fetch swiftshader bookworm chromium-common || return 1
        use swiftshader usr/lib/chromium/vk_swiftshader_icd.json usr/lib/chromium/libvk_swiftshader.so
        export LEAN_TEST_DEVICE=no-binding-arrays
        ;;
    own)
        # Drivers that the loader finds by itself, without software ones.
        ls /dev/dri/render* /dev/nvidia0 2>/dev/null | grep -q . || return 1
        # Nothing is installed there.
        ls /usr/share/vulkan/explicit_layer.d /etc/vulkan/explicit_layer.d ${VK_LAYER_PATH:-} 2>/dev/null |
            grep -q khronos_validation || export LEAN_TEST_LAYER=none
        ;;
    *) echo "drivers.sh: no driver is called $1; there are: $all" >&2 && exit 2 ;;
    esac
}

# As cargo has them: some tests of apps call the viewer.
copies="$cache/binaries/deps"
examples="$cache/binaries/examples"
rm -rf "$cache/binaries"
mkdir -p "$copies" "$examples"
if [ -n "${BINARIES:-}" ]; then
    for topic in $topics; do cp "$BINARIES/$topic" "$copies/"; done
    [ ! -e "$BINARIES/viewer" ] || cp "$BINARIES/viewer" "$examples/"
else
    echo "building the tests"
    flags=$(for topic in $topics; do printf ' --test %s' "$topic"; done)
    # shellcheck disable=SC2086 # a list of flags
    built=$(cargo test --no-run $flags 2>&1 | sed -n -e 'w /dev/stderr' -e 's/.*(\(.*\))$/\1/p')
    # Copies: what is built meanwhile is not run.
    for topic in $topics; do
        cp "$(printf '%s\n' "$built" | grep "/$topic-")" "$copies/$topic"
    done
    case " $topics " in *" apps "*)
        cargo build --example viewer
        cp "$(dirname "$(printf '%s\n' "$built" | head -n 1)")/../examples/viewer" "$examples/"
        ;;
    esac
fi

# Runs the tests of a binary in processes of their own, and says of all of them what one process says of its tests.
each_alone() { # binary, filters…
    binary=$1
    shift
    passed=0 broken=""
    ignored=$("$binary" "$@" --ignored --list 2>/dev/null)
    for test in $("$binary" "$@" --list 2>/dev/null | sed -n 's/: test$//p'); do
        ! printf '%s\n' "$ignored" | grep -q -x -F "$test: test" || continue
        if timeout 600 "$binary" --exact "$test" --show-output --include-ignored; then
            passed=$((passed + 1))
        else
            [ $? -le 101 ] || echo "ended the process: $test"
            broken="$broken $test"
        fi
    done
    printf '\nfailures:\n'
    # shellcheck disable=SC2086 # a list of names
    [ -z "$broken" ] || printf '    %s\n' $broken
    echo "test result: alone. $passed passed; $(echo "$broken" | wc -w) failed;"
}

row() { printf '%-12s %-18s %s\n' "$@"; }
table="$logs/table.txt"
row driver topic "passed, failed, parts skipped" >"$table"
for driver in $drivers; do
    log="$logs/$driver.log"
    : >"$log"
    if ! (select_driver "$driver") >>"$log" 2>&1; then
        row "$driver" "" "cannot be had here" | tee -a "$table"
        continue
    fi
    for topic in $topics; do
        printf '%s, %s …\r' "$driver" "$topic" >&2
        part="$logs/$driver-$topic.log"
        (
            select_driver "$driver"
            export CARGO_MANIFEST_DIR="$PWD"
            timeout "$limit" "$copies/$topic" --test-threads="${THREADS:-2}" --show-output "$@" || {
                code=$?
                # A driver that ends the process takes all of its tests along.
                [ $code -le 101 ] || [ $code -eq 124 ] || each_alone "$copies/$topic" "$@"
            }
        ) >"$part" 2>&1 || true
        result=$(sed -n 's/^test result: [a-zA-Z]*\. \([0-9]*\) passed; \([0-9]*\) failed;.*/\1 passed, \2 failed/p' "$part" | tail -n 1)
        skipped=$(grep -a -o 'skipped: .*' "$part" | sort -u | wc -l)
        row "$driver" "$topic" "${result:-crashed or ran past $limit s}, $skipped skipped" | tee -a "$table"
        {
            sed -n '/^failures:$/,/^test result/s/^    \([a-z_:0-9]*\)$/    failed: \1/p' "$part" | sort -u
            grep -a -E -o '(skipped|ended the process): .*' "$part" | sort -u | sed 's/^/    /'
        } | tee -a "$table"
    done
done
echo
cat "$table"
! grep -q -e ' [1-9][0-9]* failed' -e 'crashed or' "$table"
