"""What the drivers of Mitsuba 3 share: the variant, and a ladder of pictures of independent samples.

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


def launcher(scene, integrator):
    """A function that renders so many samples a pixel with a seed; it gives what that took, and the image."""
    import drjit as dr
    import mitsuba as mi
    import numpy as np

    def launch(spp, seed):
        clock = driving.Clock()
        image = mi.render(scene, integrator=integrator, spp=spp, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        return clock.now(), np.array(image, dtype=np.float64)

    return launch


class Averaged:
    """What becomes of averaged samples: nothing more."""

    def begin(self, seed):
        """Before the first sample of a seed; gives what that took."""
        return 0.0, 0.0

    def finish(self, image):
        """The picture of an average; gives what that took, too."""
        return (0.0, 0.0), image


def render(job, scene, integrator, finisher):
    """Hand over pictures of an integrator for all seeds. A picture's times are those of `finisher.begin`, of its
    samples, and of its own `finisher.finish`, not of that of earlier steps."""
    launch = launcher(scene, integrator)
    pixels = job["width"] * job["height"]
    sample_cost, image = warm_up(launch, pixels, job["times"][0])
    finisher.finish(image)
    finish_cost = finisher.finish(image)[0][1]
    for seed in range(job["seeds"]):
        ladder = driving.Ladder(job, seed)
        times, total, samples, launches = finisher.begin(seed), 0.0, 0, 0
        while not ladder.finished():
            spp = samples_of_launch(ladder.next_time(), sample_cost, pixels)
            took, image = launch(spp, launches * job["seeds"] + seed)
            times = driving.added(times, took)
            total = total + spp * image
            samples += spp
            launches += 1
            if not ladder.reached(times[1] + finish_cost):
                continue
            took, image = finisher.finish(total / samples)
            # it may have been faster than the first one
            if ladder.reached(times[1] + took[1]):
                ladder.picture(driving.added(times, took), samples, image.astype("<f4").tobytes())


def samples_of_launch(step, sample_cost, pixels):
    """A power of two, so that one kernel serves all."""
    spp = 1
    while 2 * spp * pixels <= MOST_LANES and 2 * spp * sample_cost <= LAUNCH_SHARE * step:
        spp *= 2
    return spp


def warm_up(launch, pixels, first_step):
    """Compile, and measure what a sample a pixel costs, in processor seconds; and an image."""
    launch(1, 0)
    spp = samples_of_launch(first_step, launch(1, 0)[0][1], pixels)
    took, image = launch(spp, 0)
    return took[1] / spp, image
