#!/usr/bin/env python3
"""Pictures of docs/MATERIALS.md: one for each block of TOML, docs/images/materials/NAME.png.

usage: scripts/materials.py [JOTON [NAME…]]      JOTON: the program, target/release/joton where none is given; NAME: only these, as their
headings are called
"""

import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# A ball on a table of stripes before a wall, under a large and a small lamp.
SCENE = """
shape = [
  {shapes}
  {{ kind = "rectangle", size = 12, material = {{ kd = [0.5, 0.5, 0.48] }} }},
  {stripes}
  {{ kind = "rectangle", size = [12, 6], center = [0, 3, -4], facing = [0, 0, 1], material = {{ kd = [0.35, 0.42, 0.5] }} }},
  {{ kind = "rectangle", size = 2.5, center = [-3, 5, 2], facing = [3, -4, -2], material = {{ ke = 7 }} }},
  {{ kind = "disc", radius = 0.2, center = [3, 3, 3], facing = [-3, -2, -3], material = {{ ke = [120, 90, 60] }} }},
]
[camera]
position = [0, 2.2, 5.5]
target = [0, 0.9, 0]
fov_y = 27
[film]
width = 240
height = 240
"""
# What the material is on: a ball has no texture coordinates.
BALL = 'kind = "sphere", radius = 1, center = [0, 1, 0], material = { %s }'
CUBE = 'kind = "cube", size = 1.5, rotate = [0, 30, 0], translate = [0, 0.75, 0], material = { %s }'
STRIPE = '{{ kind = "rectangle", size = [0.35, 12], center = [{x}, 0.001, 0], material = {{ kd = [0.12, 0.12, 0.14] }} }},'


def main() -> None:
    joton = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/joton")
    folder = ROOT / "docs/images/materials"
    folder.mkdir(parents=True, exist_ok=True)
    text = (ROOT / "docs/MATERIALS.md").read_text()
    stripes = "\n  ".join(STRIPE.format(x=0.7 * i) for i in range(-8, 9))
    for section in re.split(r"^## ", text, flags=re.M)[1:]:
        name = section.splitlines()[0]
        block = re.search(r"```toml\n(.*?)```", section, re.S)
        if block is None or (sys.argv[2:] and name not in sys.argv[2:]):
            continue
        # a block is the ball's material, or the shapes that stand in its place
        parts = [", ".join(part.strip().splitlines()) for part in block.group(1).split("[[shape]]")]
        if len(parts) == 1:
            parts.append((CUBE if "checkerboard" in parts[0] else BALL) % parts[0])
        shapes = "\n  ".join("{ %s }," % part for part in parts[1:])
        picture = folder / (name.lower().replace(" ", "-") + ".png")
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as scene:
            scene.write(SCENE.format(shapes=shapes, stripes=stripes))
            scene.flush()
            subprocess.run([joton, "render", scene.name, "--device", "cpu", "--passes", "32", "-o", str(picture), "--quiet"], check=True)
        print(picture.relative_to(ROOT), flush=True)


if __name__ == "__main__":
    main()
