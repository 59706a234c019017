"""What the drivers share: the job, the lines that joton reads, the clock, the pictures.

A driver runs as `python3 NAME.py JOB.json`; without a job it only tells what it is. It writes one JSON object a line
to stdout; everything that the renderer prints goes to stderr.
"""

import json
import os
import sys
import time
import traceback

# the renderers' libraries write to file descriptor 1 themselves
_LINES = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(2, 1)


def say(kind, **fields):
    """Write a line for joton."""
    _LINES.write(json.dumps({"kind": kind, **fields}) + "\n")


class Clock:
    """Tells the seconds, and the processor seconds of all threads of this process, since it was made."""

    def __init__(self):
        self.begin = (time.perf_counter(), time.process_time())

    def now(self):
        """Both."""
        return time.perf_counter() - self.begin[0], time.process_time() - self.begin[1]


def added(times, more):
    """Sums of seconds and of processor seconds."""
    return times[0] + more[0], times[1] + more[1]


class Ladder:
    """The steps of a ladder of processor seconds: a picture for each one that is reached."""

    def __init__(self, job, seed):
        self.times = job["times"]
        self.folder = job["folder"]
        self.seed = seed
        self.done = 0

    def finished(self):
        return self.done == len(self.times)

    def next_time(self):
        return self.times[self.done]

    def reached(self, cpu_seconds):
        """Whether a step is reached that has no picture yet."""
        return not self.finished() and cpu_seconds >= self.times[self.done]

    def picture(self, times, samples, image):
        """Hand over a picture: bytes of f32, little-endian, RGB, row 0 at the top. It belongs to the last step that
        was reached; slow renderers may skip some."""
        seconds, cpu_seconds = (float(t) for t in times)
        self.done = sum(t <= cpu_seconds for t in self.times)
        name = f"{self.seed}-{self.done}.raw"
        with open(os.path.join(self.folder, name), "wb") as f:
            f.write(image)
        say(
            "picture",
            seed=self.seed,
            step=self.done - 1,
            seconds=seconds,
            cpu_seconds=cpu_seconds,
            samples=samples,
            file=name,
        )


def drive(tell, render):
    """Tell what the renderer is, then render the job, if there is one. `tell()` gives its name and a note."""
    try:
        name, note = tell()
        say("renderer", name=name, note=note)
        if len(sys.argv) > 1:
            with open(sys.argv[1], encoding="utf-8") as f:
                render(json.load(f))
            say("done")
    except ModuleNotFoundError as e:
        say("missing", module=e.name or str(e))
    except KeyboardInterrupt:
        pass
    except Exception as e:  # whatever it is, joton shows it in one line
        traceback.print_exc()
        say("failed", what=f"{type(e).__name__}: {e}".splitlines()[0])
    _LINES.flush()
    # some libraries crash while they are unloaded
    os._exit(0)
