"""The command line of the workers of Cycles and LuxCore."""

import json
import os
import sys
import time
from pathlib import Path

import numpy as np

from twins.scenes import SCENES


class Clock:
    """Times since it was made: wall time, and CPU time of all threads."""

    def __init__(self):
        self.start, self.cpu_start = time.perf_counter(), time.process_time()

    def times(self):
        return time.perf_counter() - self.start, time.process_time() - self.cpu_start


def main(name, version, load, render):
    """Runs `WORKER version`, which prints {name: version}, or `WORKER render JOB.json`, which renders once per seed and
    writes images and times to the job's .npz.

    load(scene, job): builds the scene. render(loaded, job, seed): returns an image, its wall time and CPU time, and the
    time of the clock at its end."""
    command, *files = sys.argv[1:]
    if command == "version":
        print(json.dumps({name: version}), flush=True)
    elif command == "render":
        job = json.loads(Path(files[0]).read_text(encoding="utf-8"))
        loaded = load(SCENES[job["twin"]](), job)
        columns = zip(*(render(loaded, job, seed) for seed in job["seeds"]))
        np.savez(job["output"], **dict(zip(("images", "seconds", "cpu_seconds", "finished"), columns)))
    else:
        sys.exit(__doc__)
    os._exit(0)  # both modules can crash when the interpreter ends
