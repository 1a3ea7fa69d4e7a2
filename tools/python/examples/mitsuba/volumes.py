"""A cloud from an array of densities."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

z, y, x = np.mgrid[0:24, 0:24, 0:24] / 23 - 0.5
density = np.clip(1.4 - 3.2 * np.sqrt(x**2 + y**2 + z**2) + 0.3 * np.sin(20 * x) * np.sin(17 * y), 0, 1)

scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "volpath", "max_depth": 16, "rr_depth": 50},
    "sensor": {"type": "perspective", "fov": 35, "to_world": T().look_at(origin=[0, 0.5, 4], target=[0, 0, 0], up=[0, 1, 0]),
               "film": {"type": "hdrfilm", "width": 48, "height": 48, "pixel_format": "rgb", "rfilter": {"type": "box"}}},
    "cloud": {"type": "cube", "bsdf": {"type": "null"}, "interior": {
        "type": "heterogeneous", "albedo": 0.95, "scale": 6.0,
        "sigma_t": {"type": "gridvolume", "data": mi.TensorXf(density[..., None].astype(np.float32)),
                    "to_world": T().translate([-1, -1, -1]).scale(2)}}},
    "sun": {"type": "directional", "direction": [-1, -1, -1], "irradiance": {"type": "rgb", "value": [3, 2.8, 2.5]}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.15, 0.2, 0.3]}},
})
mi.util.write_bitmap("cloud.exr", mi.render(scene, spp=64))
