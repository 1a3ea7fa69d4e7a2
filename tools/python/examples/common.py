"""The scene that several examples share, and their command line."""

import argparse

import numpy as np

import sheaf


def parser(description, spp, size):
    """A command line with the options that all examples have."""
    out = argparse.ArgumentParser(description=description.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    out.add_argument("--spp", type=int, default=spp, help="samples per pixel")
    out.add_argument("--size", type=int, nargs=2, default=size, metavar=("WIDTH", "HEIGHT"), help="pixels")
    return out


def look_from(azimuth, elevation, distance=7.0, target=(0, 0.8, 0)):
    """The transform of a camera that looks at `target`. Angles in degrees."""
    a, e = np.radians([azimuth, elevation])
    origin = np.array(target) + distance * np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
    return sheaf.Transform.look_at(origin=tuple(origin), target=target, up=(0, 1, 0))


def still_life():
    """Three balls on a table under a lamp and a dim sky. The materials are named table, clay, metal and glass."""
    def rgb(*values):
        return {"type": "rgb", "value": values}

    def ball(x, z, radius, material):
        return {"type": "sphere", "center": (x, radius, z), "radius": radius, "bsdf": {"type": "ref", "id": material}}

    T = sheaf.Transform
    return sheaf.load_dict({
        "type": "scene",
        "integrator": {"type": "path"},
        "camera": {"type": "perspective", "fov": 35, "to_world": look_from(0, 20),
                   "film": {"type": "hdrfilm", "width": 320, "height": 240}},
        "table": {"type": "diffuse", "reflectance": rgb(0.5, 0.45, 0.4)},
        "clay": {"type": "diffuse", "reflectance": rgb(0.6, 0.25, 0.15)},
        "metal": {"type": "roughconductor", "material": "Au", "alpha": 0.15},
        "glass": {"type": "dielectric", "int_ior": 1.5},
        "ground": {"type": "rectangle", "to_world": T.rotate((1, 0, 0), -90) @ T.scale(6),
                   "bsdf": {"type": "ref", "id": "table"}},
        "left": ball(-1.1, 0, 0.7, "clay"),
        "middle": ball(0.3, -0.7, 0.9, "metal"),
        "right": ball(1.0, 0.6, 0.5, "glass"),
        "lamp": {"type": "rectangle",
                 "to_world": T.look_at(origin=(-4, 8, 4), target=(0, 0, 0), up=(0, 1, 0)) @ T.scale(1.4),
                 "emitter": {"type": "area", "radiance": rgb(20, 18, 15)}},
        "sky": {"type": "constant", "radiance": rgb(0.2, 0.25, 0.3)},
    })
