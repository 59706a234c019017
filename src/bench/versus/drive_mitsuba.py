"""Mitsuba 3 renders an exported scene: `path`, or `ptracer` (light tracing).

Importing, loading, building the hierarchy and compiling kernels are kept out of the times: the first pictures are
thrown away. Samples are independent, so pictures of a few samples each are averaged until a step is reached.
"""

import driving

# LLVM before this cannot compile what Dr.Jit writes, and ends the process
LEAST_LLVM = 17
# samples of one launch: beyond this memory grows and speed does not
MOST_LANES = 1 << 22
# a launch takes at most this part of the step that it leads to
LAUNCH_SHARE = 0.25


def tell():
    import mitsuba as mi

    note = ""
    try:
        mi.set_variant("llvm_ad_rgb")
        import drjit as dr

        version = dr.detail.llvm_version()
        if version[0] < LEAST_LLVM:
            raise ImportError(f"LLVM {version[0]} is older than {LEAST_LLVM}; DRJIT_LIBLLVM_PATH names another")
        backend = f"llvm_ad_rgb, LLVM {version[0]}"
    except ImportError as e:
        mi.set_variant("scalar_rgb")
        backend = "scalar_rgb"
        note = f"{e}; the slower {backend} is used"
    return f"Mitsuba {mi.__version__} ({backend})", note


def render(job):
    import drjit as dr
    import mitsuba as mi
    import numpy as np

    scene = mi.load_file(job["scene"])
    integrator = mi.load_dict({"type": job["mode"], "max_depth": -1})
    pixels = job["width"] * job["height"]

    def launch(spp, seed):
        clock = driving.Clock()
        image = mi.render(scene, integrator=integrator, spp=spp, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        return np.array(clock.now()), np.array(image, dtype=np.float64)

    sample_cost = warm_up(launch, pixels, job["times"][0])
    for seed in range(job["seeds"]):
        ladder = driving.Ladder(job, seed)
        times, total, samples, launches = np.zeros(2), 0.0, 0, 0
        while not ladder.finished():
            spp = samples_of_launch(ladder.next_time(), sample_cost, pixels)
            took, image = launch(spp, launches * job["seeds"] + seed)
            times += took
            total = total + spp * image
            samples += spp
            launches += 1
            if ladder.reached(times[1]):
                ladder.picture(times, samples, (total / samples).astype("<f4").tobytes())


def samples_of_launch(step, sample_cost, pixels):
    """A power of two, so that one kernel serves all."""
    spp = 1
    while 2 * spp * pixels <= MOST_LANES and 2 * spp * sample_cost <= LAUNCH_SHARE * step:
        spp *= 2
    return spp


def warm_up(launch, pixels, first_step):
    """Compile, and measure what a sample a pixel costs, in processor seconds."""
    launch(1, 0)
    spp = samples_of_launch(first_step, launch(1, 0)[0][1], pixels)
    return launch(spp, 0)[0][1] / spp


driving.drive(tell, render)
