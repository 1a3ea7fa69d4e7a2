"""Helpers of the compare_*.py scripts: rendering and error measurement."""

import json
import re
import resource
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def render(sheaf, scene, output, spp, seed, *options):
    """Renders and returns the statistics report, plus "cpu_seconds": user CPU time of the whole process."""
    stats = Path(output).with_suffix(".json")
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([str(sheaf), "render", str(scene), "-o", str(output), "--spp", str(spp), "--seed", str(seed),
                    "--stats", str(stats), "--quiet", *options], check=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return json.loads(stats.read_text()) | {"cpu_seconds": seconds}


def mean_squared_error(sheaf, image, reference):
    out = subprocess.run([sheaf, "compare", str(image), str(reference)], check=False, text=True,
                         stdout=subprocess.PIPE).stdout
    return float(re.search(r"^MSE +(\S+)", out, re.MULTILINE).group(1))
