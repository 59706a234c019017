#!/usr/bin/env python3
"""joton beside Mitsuba 3: the scenes of tests/mitsuba with both, and what they differ by in standard errors.

    python3 -m venv peers && peers/bin/pip install mitsuba==3.9.1 numpy
    peers/bin/python scripts/beside-mitsuba.py [--joton target/release/joton] [--only gold,leaf] [--store] [--pictures FOLDER]

Each renderer renders each scene several times with different seeds, so that the spread tells its noise. A block of 8 ×
8 pixels in a band has z = (joton - Mitsuba) / standard error of the difference; where both are the same but for noise,
the root of the mean z² is about 1 (1.08 for 8 seeds each). joton's path tracer is compared, which has no bias, and its
photon mapper, whose blur is one; its pixels share no light here (`--resolve off`), or their noise would be no one's
own. `--store` writes tests/mitsuba/NAME.txt for the scenes in STORED, against which `cargo test --test statistics
mitsuba` holds joton without Mitsuba.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ROOT / "tests" / "mitsuba"
SIZE = 64
BLOCK = 8
SEEDS = 8
# what f32 sums and an rgb table of 64³ entries leave, relative
ROUNDING = 1e-4
# pixels of a stored picture, and of its blocks
STORED = {"gold": 32, "saturated-plastic": 32, "leaf": 32, "spectral-tables": 32}
STORED_BLOCK = 4


def flags(name):
    """How joton is to read a scene, and whether Mitsuba writes what is near."""
    if name.startswith("spectral-"):
        return ["--spectral", "on"], []
    return ["--spectral", "off"], ["--near"] if name.startswith("rough-") else []


def run(words):
    ended = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {ended.stderr}")


def mitsuba_images(joton, name, size, spp, seeds, folder):
    import mitsuba as mi

    spectral, near = flags(name)
    mi.set_variant("scalar_spectral" if spectral[-1] == "on" else "scalar_rgb")
    file = folder / f"{name}.xml"
    run([joton, "export", SCENES / f"{name}.toml", *spectral, *near, "--size", f"{size}x{size}", "-o", file])
    scene = mi.load_file(str(file))
    return np.stack([np.array(mi.render(scene, spp=spp, seed=1 + seed), dtype=np.float64) for seed in range(seeds)])


def joton_images(joton, name, size, passes, seeds, folder, *more):
    import mitsuba as mi

    spectral, _ = flags(name)
    images = []
    for seed in range(seeds):
        file = folder / f"{name}.exr"
        size_words = ["--size", f"{size}x{size}", "--passes", passes, "--seed", seed]
        run([joton, "render", SCENES / f"{name}.toml", *spectral, *size_words, "--device", "cpu", *more, "-o", file])
        root = [layer for layer_name, layer in mi.Bitmap(str(file)).split() if layer_name in ("", "<root>")]
        images.append(np.array(root[0], dtype=np.float64)[..., :3])
    return np.stack(images)


def blocks(images, block):
    """Means of blocks: seed, row, column, band."""
    seeds, height, width, bands = images.shape
    return images.reshape(seeds, height // block, block, width // block, block, bands).mean(axis=(2, 4))


def mean_and_error(images):
    return images.mean(axis=0), images.std(axis=0, ddof=1) / np.sqrt(len(images))


def compare(ours, theirs, block):
    """rms z, largest z, ratio of means, its standard error, and the spread of blocks' ratios beyond noise."""
    (a, da), (b, db) = (mean_and_error(blocks(images, block)) for images in (ours, theirs))
    error = np.sqrt(da**2 + db**2 + (ROUNDING * b) ** 2)
    seen = error > 0
    z = (a - b)[seen] / error[seen]
    (wa, dwa), (wb, dwb) = (mean_and_error(images.mean(axis=(1, 2, 3))) for images in (ours, theirs))
    ratio_error = np.hypot(dwa / wa, dwb / wb)
    return np.sqrt(np.mean(z**2)), np.abs(z).max(), wa / wb, ratio_error


def store(joton, name, folder):
    """Blocks of Mitsuba's picture with their standard errors, a line each: row, column, then R G B and their errors."""
    size = STORED[name]
    images = blocks(mitsuba_images(joton, name, size, 2048, 16, folder), STORED_BLOCK)
    mean, error = mean_and_error(images)
    lines = [
        f"# {name}.toml at {size} × {size} by Mitsuba 3.9.1 (path, 16 × 2048 samples a pixel): scripts/beside-mitsuba.py --store",
        f"# blocks of {STORED_BLOCK} × {STORED_BLOCK} pixels, row by row: R G B, then their standard errors",
    ]
    for row in range(mean.shape[0]):
        for column in range(mean.shape[1]):
            numbers = [f"{x:.5g}" for x in mean[row, column]] + [f"{x:.2g}" for x in error[row, column]]
            lines.append(" ".join(numbers))
    (SCENES / f"{name}.txt").write_text("\n".join(lines) + "\n")


# a box that shines inward, and a plate of white metal in it, of which a camera sees a little at an angle
GLOWING_BOX = """v -3 -3 -3
v 3 -3 -3
v 3 3 -3
v -3 3 -3
v -3 -3 3
v 3 -3 3
v 3 3 3
v -3 3 3
usemtl glow
f 1 2 3 4
f 6 5 8 7
f 5 1 4 8
f 2 6 7 3
f 5 6 2 1
f 4 3 7 8
"""
PLATE = """[camera]
position = [{x}, 0, {z}]
target = [0, 0, 0]
fov_x = 1
[film]
width = 8
height = 8
[[mesh]]
file = "box.obj"
[[material]]
name = "glow"
kd = 0
ke = 1
[[shape]]
kind = "rectangle"
facing = [0, 0, 1]
material = {{ type = "metal", eta = [0.01, 0.01, 0.01], k = [100, 100, 100], alpha = {alpha} }}
"""


def single_scattering(alpha, mu, steps=2000):
    """What a white surface of GGX sends on of even light, by the product of Smith's factors of both sides."""
    c, phi = np.meshgrid((np.arange(steps) + 0.5) / steps, (np.arange(steps) + 0.5) * np.pi / steps, indexing="ij")
    s, so = np.sqrt(1 - c**2), np.sqrt(1 - mu**2)
    cos2 = (c + mu) ** 2 / ((s * np.cos(phi) + so) ** 2 + (s * np.sin(phi)) ** 2 + (c + mu) ** 2)
    distribution = alpha**2 / (np.pi * (1 - cos2 + alpha**2 * cos2) ** 2)
    smith = lambda x: 2 / (1 + np.sqrt(alpha**2 + (1 - alpha**2) * x**2) / x)
    return (distribution * smith(c) * smith(mu) / (4 * mu)).mean() * 2 * np.pi


def rough(joton, folder):
    """What rough white metal sends on of even light, in both."""
    import mitsuba as mi

    print("| α | cosine | Mitsuba | its formula | joton | joton/Mitsuba |")
    print("|---|---|---|---|---|---|")
    (folder / "box.obj").write_text(GLOWING_BOX)
    mi.set_variant("scalar_rgb")
    for alpha in (0.1, 0.3, 0.6, 1.0):
        for mu in (1.0, 0.5, 0.2):
            scene, xml, image = (folder / f"plate.{kind}" for kind in ("toml", "xml", "exr"))
            place = {"x": 2 * np.sqrt(1 - mu**2), "z": 2 * mu}
            scene.write_text(PLATE.format(alpha=alpha, **place))
            run([joton, "export", scene, "--near", "-o", xml])
            theirs = np.array(mi.render(mi.load_file(str(xml)), spp=8192)).mean()
            run([joton, "render", scene, "--device", "cpu", "--reference", "--passes", 8192, "-o", image])
            ours = np.array(mi.Bitmap(str(image)).split()[0][1])[..., :3].mean()
            formula = single_scattering(alpha, mu)
            print(f"| {alpha} | {mu} | {theirs:.4f} | {formula:.4f} | {ours:.4f} | {ours / theirs:.3f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--joton", type=pathlib.Path, default=ROOT / "target" / "release" / "joton")
    parser.add_argument("--only", default="")
    parser.add_argument("--spp", type=int, default=512, help="samples a pixel and seed of Mitsuba")
    parser.add_argument("--passes", type=int, default=256, help="passes of joton's path tracer")
    parser.add_argument("--mapped", type=int, default=128, help="passes of joton's photon mapper; 0: none")
    parser.add_argument("--rough", action="store_true", help="compare rough white metal in even light instead")
    parser.add_argument("--store", action="store_true")
    parser.add_argument("--pictures", type=pathlib.Path, help="write both means and their difference as .npy here")
    arguments = parser.parse_args()
    names = sorted(path.stem for path in SCENES.glob("*.toml"))
    if arguments.only:
        names = arguments.only.split(",")
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        if arguments.rough:
            rough(arguments.joton, folder)
            return
        if arguments.store:
            for name in STORED:
                store(arguments.joton, name, folder)
            return
        print("| scene | path tracer: rms z | largest | mean ratio | photon mapper: rms z | largest | mean ratio |")
        print("|---|---|---|---|---|---|---|", flush=True)
        for name in names:
            theirs = mitsuba_images(arguments.joton, name, SIZE, arguments.spp, SEEDS, folder)
            cells = []
            for passes, more in ((arguments.passes, ["--reference"]), (arguments.mapped, ["--resolve", "off"])):
                if passes == 0:
                    continue
                ours = joton_images(arguments.joton, name, SIZE, passes, SEEDS, folder, *more)
                rms, most, ratio, error = compare(ours, theirs, BLOCK)
                cells += [f"{rms:.2f}", f"{most:.1f}", f"{ratio:.4f} ± {error:.4f}"]
                if arguments.pictures:
                    arguments.pictures.mkdir(exist_ok=True)
                    kind = "reference" if "--reference" in more else "mapped"
                    np.save(arguments.pictures / f"{name}-{kind}.npy", np.stack([ours.mean(0), theirs.mean(0)]))
            print(f"| {name} | {' | '.join(cells)} |", flush=True)


main()
