#!/bin/sh
# Wheel: what pip installs must render without a toolchain.
#   sh scripts/test-wheel.sh
# Builds the wheel with maturin, installs it into an empty virtual environment, and renders a small picture with it from
# an empty folder. Needs cargo, python3 with venv, and a package index for maturin. Leaves nothing but cargo's target.
set -u
cd "$(dirname "$0")/.." || exit 2
here=$(pwd)

say() { printf 'wheel: %s\n' "$*"; }
fail() {
    say "FAILED: $*" >&2
    exit 1
}

for tool in cargo python3; do
    command -v "$tool" >/dev/null 2>&1 || fail "$tool is not installed"
done

scratch=$(mktemp -d) || exit 2
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

say "building"
python3 -m venv "$scratch/builder" || fail "python3 makes no virtual environment; on Debian: apt-get install python3-venv"
"$scratch/builder/bin/pip" install --quiet 'maturin>=1.8,<2' || fail "pip does not install maturin"
"$scratch/builder/bin/maturin" build --release --out "$scratch/wheels" || fail "maturin builds no wheel"
wheel=$(ls "$scratch"/wheels/joton-*.whl) || fail "there is no wheel"
say "built $(basename "$wheel"), $(wc -c <"$wheel") bytes"

# Neither cargo nor a package index is within reach of the user.
say "installing"
python3 -m venv "$scratch/user" || fail "python3 makes no second virtual environment"
env -i HOME="$scratch" PATH="$scratch/user/bin" "$scratch/user/bin/pip" install --quiet --no-index "$wheel" ||
    fail "pip does not install the wheel"

say "rendering"
mkdir "$scratch/empty"
cd "$scratch/empty" || exit 2
env -i HOME="$scratch" PATH="$scratch/user/bin" joton render "$here/scenes/cornell.toml" --size 32x32 --passes 1 \
    --device cpu -o cornell.png || fail "joton does not render"
[ -s cornell.png ] || fail "there is no picture"
say "all is well: $(wc -c <cornell.png) bytes of picture"
