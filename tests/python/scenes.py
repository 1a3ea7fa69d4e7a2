"""Scenes of the tests."""

import os
import subprocess
from pathlib import Path

import numpy as np

import sheaf

ROOT = Path(__file__).resolve().parent.parent.parent
CORNELL = str(ROOT / "scenes" / "cornell" / "cornell.xml")
SMALL = {"width": 24, "height": 16}

VERTICES = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float32)
FACES = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32)
UV = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=np.float32)


def cornell():
    return sheaf.load(CORNELL, defines=SMALL)


def wall(shape=None, bsdf=None, **more):
    """A square that fills the image, under light from everywhere: a pixel has the albedo of the square."""
    square = {"type": "mesh", "vertices": VERTICES, "faces": FACES, "uv": UV}
    square.update(shape or {})
    square["bsdf"] = bsdf or {"type": "diffuse", "reflectance": {"type": "rgb", "value": (0.2, 0.4, 0.6)}}
    look_at = sheaf.Transform.look_at(origin=(0, 0, 1), target=(0, 0, 0), up=(0, 1, 0))
    return {"type": "scene", "integrator": {"type": "path", "max_depth": 2},
            "camera": {"type": "perspective", "fov": 40, "to_world": look_at,
                       "film": {"type": "hdrfilm", "width": 8, "height": 6, "rfilter": {"type": "box"}}},
            "square": square, "sky": {"type": "constant"}, **more}


def program(*words):
    """Runs the program `sheaf`."""
    subprocess.run([os.environ["SHEAF_PROGRAM"], *map(str, words), "-q"], check=True, cwd=ROOT)
