# To be sourced: installs what is missing, and picks the linker. One set of flags for all builds, so that Bevy is built
# once.
sh "$(dirname "${BASH_SOURCE:-$0}")/../tests/install-debian.sh"
if command -v mold >/dev/null; then
    export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-C link-arg=-fuse-ld=mold"
fi
