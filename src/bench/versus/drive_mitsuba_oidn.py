"""Mitsuba 3 path traces an exported scene, and Open Image Denoise filters the picture: `path` with albedo and normals
of the first surfaces beside it, or `path-colour` without, which is better where those show glass and mirrors only.

Opening Open Image Denoise is kept out of the times, as compiling kernels is: its first pictures are thrown away. A
picture's times are those of its samples, of albedo and normals, and of its filter.
"""

import driving
import driving_mitsuba

# Samples a pixel of albedo and normals. They come by themselves: together with `path` they double the cost of each of
# its samples. On a Cornell box of 256 x 256 and 64 samples: error 2.6e-4 with 1 sample of them, 2.3e-4 with 4, 2.0e-4
# with 16, 1.9e-4 with 64; 16 take 0.05 of 3 processor seconds.
GUIDE_SAMPLES = 16
# Albedo and normals are not filtered beforehand: there that takes 1.2 instead of 0.2 processor seconds, and gives no
# less error at equal samples (4.9e-4 and 5.1e-4 after 16, 1.8e-4 and 2.0e-4 after 64, 9.6e-5 and 9.5e-5 after 256).
# Elsewhere it is better or worse: 0.65 of the error for glass in a floor, 0.89 in a room with poles, 1.3 on grass.


class Denoised(driving_mitsuba.Averaged):
    """Averaged samples, denoised."""

    def __init__(self, job, scene):
        import mitsuba as mi
        import numpy as np
        import pyoidn

        guides = {"path": ["albedo", "normal"], "path-colour": []}[job["mode"]]
        self.launch = None
        if guides:
            aov = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal"})
            self.launch = driving_mitsuba.launcher(scene, aov)
            self.launch(GUIDE_SAMPLES, 0)
        shape = (job["height"], job["width"], 3)
        self.images = {name: np.zeros(shape, dtype=np.float32) for name in ["color", *guides, "output"]}
        # the filter needs its device for as long as it lives
        self.device = pyoidn.Device()
        self.device.commit()
        self.filter = pyoidn.Filter(self.device, pyoidn.OIDN_FILTER_TYPE_RT)
        for name, image in self.images.items():
            self.filter.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
        self.filter.set_bool("hdr", True)
        self.filter.commit()
        self.check()

    def check(self):
        error = self.device.get_error()
        if error is not None:
            raise RuntimeError(f"Open Image Denoise: {error}")

    def begin(self, seed):
        if self.launch is None:
            return super().begin(seed)
        clock = driving.Clock()
        _, guides = self.launch(GUIDE_SAMPLES, seed)
        self.images["albedo"][:] = guides[..., :3]
        self.images["normal"][:] = guides[..., 3:]
        return clock.now()

    def finish(self, image):
        clock = driving.Clock()
        self.images["color"][:] = image
        self.filter.execute()
        took = clock.now()
        self.check()
        return took, self.images["output"]


def tell():
    # asked for first: who has it has Mitsuba, too
    import pyoidn

    name, note = driving_mitsuba.tell()
    return f"{name} and Open Image Denoise {pyoidn.version.oidn_version}", note


def render(job):
    import mitsuba as mi

    scene = mi.load_file(job["scene"])
    integrator = mi.load_dict({"type": "path", "max_depth": -1})
    driving_mitsuba.render(job, scene, integrator, Denoised(job, scene))


driving.drive(tell, render)
