#!/bin/sh
# Test: everything that must hold before a change is taken; this is what runs in CI, too.
#   sh scripts/test.sh [arguments for cargo test]
# The kernels are tested on a device. Where none is found, software Vulkan (Mesa lavapipe) is installed with the
# system's package manager. JOTON_TEST_NO_GPU=1 leaves out the tests that need a device, and installs nothing.
set -u
cd "$(dirname "$0")/.." || exit 2

say() { printf 'test: %s\n' "$*"; }
have() { command -v "$1" >/dev/null 2>&1; }

if ! have cargo; then
    say "cargo is not installed; see https://rustup.rs" >&2
    exit 2
fi
if ! have cc && ! have gcc && ! have clang && ! have cl; then
    say "no C compiler is found, and Rust needs one for linking; on Debian: apt-get install build-essential" >&2
    exit 2
fi

scratch=$(mktemp -d) || exit 2
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM
# Vulkan loaders and Mesa complain without one.
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    mkdir -m 700 "$scratch/run"
    export XDG_RUNTIME_DIR="$scratch/run"
fi
failed=""

# A driver's file proves no device: ask joton itself, which the tests need anyway.
has_device() {
    cargo run --quiet -- devices 2>/dev/null | grep -Eq ', (Vulkan|Metal|Dx12)\)'
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif have sudo; then
        sudo "$@"
    else
        say "to install it, run as root: $*" >&2
        return 1
    fi
}

install_software_vulkan() {
    case "$(uname -s)" in
    Linux) ;;
    *) return 1 ;; # Metal and DX12 come with the system
    esac
    if have apt-get; then
        as_root apt-get update -q || return 1
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends \
            mesa-vulkan-drivers libvulkan1
    elif have dnf; then
        as_root dnf install -y mesa-vulkan-drivers vulkan-loader
    elif have pacman; then
        as_root pacman -S --needed --noconfirm vulkan-swrast vulkan-icd-loader
    elif have zypper; then
        as_root zypper --non-interactive install libvulkan_lvp libvulkan1
    elif have apk; then
        as_root apk add mesa-vulkan-swrast vulkan-loader
    else
        return 1
    fi
}

say "building"
cargo build --workspace || exit 1

if [ "${JOTON_TEST_NO_GPU:-}" = 1 ]; then
    say "JOTON_TEST_NO_GPU=1: nothing is tested on a device"
elif ! has_device; then
    chosen=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}
    if [ -n "$chosen" ]; then
        # Whoever names drivers wants these and no others: another one would not be loaded, either.
        say "the drivers named by VK_DRIVER_FILES ($chosen) offer no device; unset it, or set JOTON_TEST_NO_GPU=1" >&2
    else
        say "no Vulkan device is found; installing software Vulkan (Mesa lavapipe)"
        install_software_vulkan || say "that failed; install a Vulkan driver, or set JOTON_TEST_NO_GPU=1" >&2
        has_device || say "there is still no device: the tests that need one will fail" >&2
    fi
fi

if cargo fmt --version >/dev/null 2>&1; then
    say "cargo fmt --check"
    cargo fmt --all --check || failed="$failed fmt"
fi
if cargo clippy --version >/dev/null 2>&1; then
    say "cargo clippy"
    cargo clippy --workspace --all-targets -- -D warnings || failed="$failed clippy"
fi

say "cargo doc"
RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --quiet || failed="$failed doc"

# Last, so that the counts are what one sees.
say "cargo test"
{
    cargo test --workspace --no-fail-fast "$@"
    echo $? >"$scratch/code"
} 2>&1 | tee "$scratch/log"
[ "$(cat "$scratch/code")" = 0 ] || failed="$failed test"
awk '/^test result:/ { for (i = 2; i < NF; i++) { if ($(i + 1) ~ /^passed/) p += $i; if ($(i + 1) ~ /^failed/) f += $i
    if ($(i + 1) ~ /^ignored/) g += $i } } END { printf "test: %d passed, %d failed, %d ignored\n", p, f, g }' "$scratch/log"

if [ -n "$failed" ]; then
    say "FAILED:$failed"
    exit 1
fi
say "all is well"
