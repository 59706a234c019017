"""Mitsuba 3 renders an exported scene: `path`, or `ptracer` (light tracing)."""

import driving
import driving_mitsuba


def render(job):
    import mitsuba as mi

    scene = mi.load_file(job["scene"])
    integrator = mi.load_dict({"type": job["mode"], "max_depth": -1})
    driving_mitsuba.render(job, scene, integrator, driving_mitsuba.Averaged())


driving.drive(driving_mitsuba.tell, render)
