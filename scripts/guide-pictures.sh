#!/bin/sh
# Guide pictures: renders every docs/guide/scenes/NAME.toml into docs/guide/images/NAME.png.
#   sh scripts/guide-pictures.sh [joton]
# The size is that of each scene. Seed and passes are fixed, and the pictures are made on the CPU: they are the same
# each time.
set -eu
joton=${1:-joton}
cd "$(dirname "$0")/.."

mkdir -p docs/guide/images
for scene in docs/guide/scenes/*.toml; do
    name=$(basename "$scene" .toml)
    "$joton" render "$scene" --device cpu --seed 1 --passes 128 -o "docs/guide/images/$name.png"
done
