"""Renders a scene from several viewpoints."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "path"},
    "floor": {"type": "rectangle", "to_world": T().rotate([1, 0, 0], -90).scale(3)},
    "cube": {"type": "cube", "to_world": T().translate([0, 0.5, 0]).scale([0.5, 0.5, 0.8]),
             "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.2, 0.1]}}},
    "lamp": {"type": "directional", "direction": [-1, -2, -1], "irradiance": {"type": "rgb", "value": 2.0}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.4}},
})


def load_sensor(azimuth, elevation):
    """A camera that looks at the origin."""
    origin = T().rotate([0, 1, 0], azimuth).rotate([1, 0, 0], -elevation) @ mi.ScalarPoint3f([0, 0, 5])
    return mi.load_dict({
        "type": "perspective",
        "fov": 40,
        "to_world": T().look_at(origin=origin, target=[0, 0.4, 0], up=[0, 1, 0]),
        "sampler": {"type": "independent", "sample_count": 32},
        "film": {"type": "hdrfilm", "width": 64, "height": 48, "pixel_format": "rgb", "rfilter": {"type": "box"}},
    })


for number, azimuth in enumerate(np.linspace(0, 120, 4)):
    view = mi.render(scene, sensor=load_sensor(azimuth, 25), spp=32)
    mi.util.write_bitmap(f"view_{number}.exr", view)
