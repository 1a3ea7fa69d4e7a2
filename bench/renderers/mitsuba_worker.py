"""Renders with Mitsuba 3; run by programs.py with the Python that has Mitsuba.

  mitsuba_worker.py render JOB.json     renders once per seed; writes images and times to the job's .npz
  mitsuba_worker.py version             prints the versions of Mitsuba, Dr.Jit and LLVM
"""

import json
import os
import re
import sys
import time
from pathlib import Path

import drjit
import mitsuba as mi
import numpy as np


def load(job):
    """Returns the scene and the names of the properties that Mitsuba does not know and ignores."""
    try:
        return parse(job, mi.LogLevel.Error), []
    except RuntimeError as error:
        unknown = re.findall(r'^ *- \w+ "(\w+)"', str(error), re.MULTILINE)
        if "unreferenced propert" not in str(error):
            raise
    return parse(job, mi.LogLevel.Debug), unknown


def parse(job, unused):
    config = mi.parser.ParserConfig(job["variant"])
    config.unused_properties = unused
    state = mi.parser.parse_file(config, job["scene"], **job["defines"])
    mi.parser.transform_all(config, state)
    scene = mi.parser.instantiate(config, state)
    return scene[0] if isinstance(scene, list) else scene


def render(job):
    mi.set_variant(job["variant"])
    mi.set_log_level(mi.LogLevel.Error)
    drjit.set_thread_count(job["threads"])
    os.chdir(Path(job["scene"]).parent)  # meshes and textures are looked up here
    scene, ignored = load(job)
    integrator = scene.integrator() or mi.load_dict({"type": "path"})
    images, seconds, cpu_seconds, finished = [], [], [], []
    for seed in job["seeds"]:
        start, cpu_start = time.perf_counter(), time.process_time()
        images.append(np.array(mi.render(scene, spp=job["spp"], seed=seed, integrator=integrator))[..., :3])
        seconds.append(time.perf_counter() - start)
        cpu_seconds.append(time.process_time() - cpu_start)
        finished.append(time.time())
    np.savez(job["output"], images=images, seconds=seconds, cpu_seconds=cpu_seconds, finished=finished,
             ignored=np.array(ignored, dtype=str))


def versions():
    mi.set_variant("scalar_rgb")
    llvm = ".".join(str(part) for part in drjit.detail.llvm_version()) if hasattr(drjit.detail, "llvm_version") else "?"
    print(json.dumps({"Mitsuba": mi.__version__, "Dr.Jit": drjit.__version__, "LLVM": llvm}))


def main():
    command, *files = sys.argv[1:]
    if command == "version":
        versions()
    elif command == "render":
        render(json.loads(Path(files[0]).read_text(encoding="utf-8")))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
