"""LuxCore renders an exported scene: `path`, `photongi` (path with a caustic photon cache, renewed as it runs) or
`bidirvm` (bidirectional with vertex merging).

Importing, loading and building the hierarchy are kept out of the times: starting without a photon cache is timed first
and taken off. Filling the photon cache is rendering and counts.
"""

import array
import math
import os
import sys
import time
import xml.etree.ElementTree

import driving

# no path is cut short: roulette ends it long before
DEPTH = 64
# roulette brightens the bidirectional engine's pictures by some per cent; it goes without, and paths end here
DEPTH_BIDIRECTIONAL = 24
# light paths of a round of the bidirectional engine: with its 16,000 a picture of 256 x 256 has holes for seconds
LIGHT_PATHS = 2048
# photon cache: few photons, radii of this part of the scene's extent that shrink to the second, renewed after every
# sample a pixel. The default of 20 million spends 16 processor seconds before the first sample of a box with two
# spheres; more photons, larger radii and Metropolis sampling of photons all did worse there.
PHOTONS = 50_000
PHOTON_RADIUS = 1 / 50
LEAST_PHOTON_RADIUS = 1 / 200
# seconds between looks at the clock
NAP = 0.01


def tell():
    import pyluxcore

    pyluxcore.Init(lambda message: None)
    return f"LuxCore {pyluxcore.Version()}", ""


def numbers(text):
    return [float(x) for x in text.replace(",", " ").split()]


def child(element, name):
    """The child that is called `name`."""
    return next(c for c in element if c.get("name") == name)


def value(element, name):
    return child(element, name).get("value")


def bands(element, name):
    return numbers(value(element, name))


def look_at(element):
    at = child(element, "to_world").find("lookat")
    return [numbers(at.get(key)) for key in ("origin", "target", "up")]


def material(name, bsdf):
    """Properties of a BSDF of the export, by what follows `scene.materials.`."""
    kind = bsdf.get("type")
    if kind == "twosided":
        return material(name, bsdf.find("bsdf"))
    if bsdf.find("texture") is not None:
        raise ValueError(f"the texture of material {name} is not written for LuxCore")
    if kind == "diffuse":
        return {f"{name}.type": "matte", f"{name}.kd": bands(bsdf, "reflectance")}
    if kind == "conductor":
        if bsdf.find("rgb[@name='eta']") is not None:
            raise ValueError(f"the metal of material {name} is not written for LuxCore")
        return {f"{name}.type": "mirror", f"{name}.kr": bands(bsdf, "specular_reflectance")}
    if kind == "dielectric":
        return {
            f"{name}.type": "glass",
            f"{name}.kr": bands(bsdf, "specular_reflectance"),
            f"{name}.kt": bands(bsdf, "specular_transmittance"),
            f"{name}.interiorior": float(value(bsdf, "int_ior")),
            f"{name}.exteriorior": float(value(bsdf, "ext_ior")),
        }
    raise ValueError(f"BSDF {kind} is not known")


def light(name, emitter):
    """Properties of a light of the export, by what follows `scene.lights.`."""
    kind = emitter.get("type")
    common = {f"{name}.gain": [1.0, 1.0, 1.0]}
    if kind == "point":
        position = child(emitter, "position")
        return {
            **common,
            f"{name}.type": "point",
            f"{name}.position": [float(position.get(axis)) for axis in "xyz"],
            # flux: the intensity in all directions
            f"{name}.color": [4 * math.pi * band for band in bands(emitter, "intensity")],
        }
    if kind == "directional":
        direction = child(emitter, "direction")
        return {
            **common,
            f"{name}.type": "sharpdistant",
            f"{name}.direction": [float(direction.get(axis)) for axis in "xyz"],
            f"{name}.color": bands(emitter, "irradiance"),
        }
    raise ValueError(f"emitter {kind} is not known")


def properties(pyluxcore, prefix, entries):
    result = pyluxcore.Properties()
    for key, entry in entries.items():
        result.Set(pyluxcore.Property(prefix + key, entry))
    return result


def load(pyluxcore, file, width, height):
    root = xml.etree.ElementTree.parse(file).getroot()
    folder = os.path.dirname(file)
    sensor = root.find("sensor")
    origin, target, up = look_at(sensor)
    scene = pyluxcore.Scene()
    camera = {
        "type": "perspective",
        "lookat.orig": origin,
        "lookat.target": target,
        "up": up,
        "fieldofview": float(value(sensor, "fov")),
        # the angle is across the width; the window is one pixel lower, because rays start one pixel too high
        "screenwindow": [-1.0, 1.0, -(height + 2) / width, (height - 2) / width],
        "autofocus.enable": False,
        "cliphither": float(value(sensor, "near_clip")),
        "clipyon": float(value(sensor, "far_clip")),
    }
    scene.Parse(properties(pyluxcore, "scene.camera.", camera))
    bsdfs = {bsdf.get("id"): bsdf for bsdf in root.findall("bsdf")}
    for i, shape in enumerate(root.findall("shape")):
        entries = material(f"m{i}", bsdfs[shape.find("ref").get("id")])
        emitter = shape.find("emitter")
        if emitter is not None:
            entries[f"m{i}.emission"] = bands(emitter, "radiance")
            entries[f"m{i}.emission.gain"] = [1.0, 1.0, 1.0]
        scene.Parse(properties(pyluxcore, "scene.materials.", entries))
        ply = os.path.join(folder, value(shape, "filename"))
        scene.Parse(properties(pyluxcore, "scene.shapes.", {f"s{i}.type": "mesh", f"s{i}.ply": ply}))
        entries = {f"o{i}.shape": f"s{i}", f"o{i}.material": f"m{i}"}
        scene.Parse(properties(pyluxcore, "scene.objects.", entries))
    for i, emitter in enumerate(root.findall("emitter")):
        scene.Parse(properties(pyluxcore, "scene.lights.", light(f"l{i}", emitter)))
    return scene


def configuration(job, mode, seed):
    entries = {
        "film.width": job["width"],
        "film.height": job["height"],
        "film.filter.type": "NONE",
        "film.imagepipelines.0.0.type": "NOP",
        "native.threads.count": os.cpu_count(),
        "renderengine.seed": seed + 1,
        "renderengine.type": "PATHCPU",
        "sampler.type": "SOBOL",
    }
    for kind in ("total", "diffuse", "glossy", "specular"):
        entries[f"path.pathdepth.{kind}"] = DEPTH
    if mode == "photongi":
        entries.update(
            {
                "path.photongi.caustic.enabled": True,
                "path.photongi.caustic.lookup.radius": PHOTON_RADIUS * job["extent"],
                "path.photongi.caustic.updatespp": 1,
                "path.photongi.caustic.updatespp.minradius": LEAST_PHOTON_RADIUS * job["extent"],
                "path.photongi.photon.maxcount": PHOTONS,
                "path.photongi.photon.maxdepth": DEPTH,
                "path.photongi.sampler.type": "RANDOM",
                "path.photongi.visibility.enabled": False,
            }
        )
    if mode == "bidirvm":
        entries.update(
            {
                "renderengine.type": "BIDIRVMCPU",
                "sampler.type": "RANDOM",
                "path.maxdepth": DEPTH_BIDIRECTIONAL,
                "light.maxdepth": DEPTH_BIDIRECTIONAL,
                "path.russianroulette.cap": 1.0,
                "bidirvm.lightpath.count": LIGHT_PATHS,
            }
        )
    return entries


def start(pyluxcore, job, mode, seed):
    """A running session, and the clock since it began to start: hierarchy and, with `photongi`, the first photons."""
    scene = load(pyluxcore, job["scene"], job["width"], job["height"])
    config = pyluxcore.RenderConfig(properties(pyluxcore, "", configuration(job, mode, seed)), scene)
    session = pyluxcore.RenderSession(config)
    clock = driving.Clock()
    session.Start()
    return session, clock


def render(job):
    import pyluxcore

    session, clock = start(pyluxcore, job, "path", 0)
    setup = clock.now()
    session.Stop()
    for seed in range(job["seeds"]):
        ladder = driving.Ladder(job, seed)
        session, clock = start(pyluxcore, job, job["mode"], seed)
        while not ladder.finished():
            time.sleep(NAP)
            times = [max(t - s, 0.0) for t, s in zip(clock.now(), setup)]
            if ladder.reached(times[1]):
                session.UpdateStats()
                samples = session.GetStats().Get("stats.renderengine.pass").GetInt()
                picture = array.array("f", bytes(4 * 3 * job["width"] * job["height"]))
                session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, picture)
                ladder.picture(times, samples, flipped(picture, job["width"]))
        session.Stop()


def flipped(picture, width):
    """Its bytes, little-endian, with row 0 at the top."""
    if sys.byteorder == "big":
        picture.byteswap()
    row = 3 * width
    begins = range(len(picture) - row, -1, -row)
    return b"".join(picture[begin : begin + row].tobytes() for begin in begins)


driving.drive(tell, render)
