#!/bin/sh
# Installs what the crate's examples and tests need on Debian or Ubuntu, where it is missing: a C++ compiler (for FLIP),
# a fast linker, Wayland's headers, the Vulkan loader and, where no GPU driver brings one, Mesa's software driver.
# Does nothing elsewhere.
#
# LEAN_INSTALL=yes installs without a question, LEAN_INSTALL=no only names the command. Otherwise root installs at once, and
# others are asked before `sudo`; without a terminal to ask on, the command is only named.
set -eu
command -v apt-get >/dev/null || exit 0

missing=""
need() { # package, test that succeeds if it is there
    sh -c "$2" >/dev/null 2>&1 || missing="$missing $1"
}
need g++ "command -v g++"
need mold "command -v mold"
need pkg-config "command -v pkg-config"
need libwayland-dev "pkg-config --exists wayland-client"
need libxkbcommon-x11-0 "ldconfig -p | grep -q libxkbcommon-x11.so"
need libvulkan1 "ldconfig -p | grep -q libvulkan.so.1"
need vulkan-validationlayers "ls /usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json"
need mesa-vulkan-drivers "ls /usr/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json \${VK_DRIVER_FILES:-} | grep -q ."
# For meson, which builds what figures of other GPUs need.
[ -z "${LEAN_TEST_NIGHTLY:-}" ] || need python3-venv "python3 -c 'import ensurepip, venv'"
[ -n "$missing" ] || exit 0

root=""
[ "$(id -u)" = 0 ] || root=sudo
wanted=${LEAN_INSTALL:-}
if [ -z "$wanted" ] && [ -z "$root" ]; then
    wanted=yes
elif [ -z "$wanted" ] && [ -t 0 ]; then
    printf 'missing packages:%s\ninstall them with sudo apt-get? [y/N] ' "$missing"
    read -r answer || answer=""
    case $answer in [yY]*) wanted=yes ;; esac
fi
if [ "$wanted" != yes ]; then
    echo "not installed:${missing}. The command is: ${root:+$root }apt-get install$missing" >&2
    exit 0
fi
echo "installing:$missing"
$root apt-get update -qq
# `env` because `sudo` keeps no variables.
# shellcheck disable=SC2086 # a list of packages
$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing >/dev/null
