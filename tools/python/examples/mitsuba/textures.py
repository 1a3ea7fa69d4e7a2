"""Textures from arrays, which change between renders."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

y, x = np.mgrid[0:32, 0:32]
checks = np.where(((x // 4 + y // 4) % 2)[..., None] == 1, [0.8, 0.7, 0.2], [0.1, 0.2, 0.5]).astype(np.float32)
scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "path"},
    "sensor": {"type": "perspective", "fov": 45, "to_world": T().look_at(origin=[0, -2, 3], target=[0, 0, 0], up=[0, 1, 0]),
               "film": {"type": "hdrfilm", "width": 96, "height": 64, "pixel_format": "rgb"}},
    "wall": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": {
        "type": "bitmap", "bitmap": mi.Bitmap(checks), "filter_type": "nearest", "to_uv": T().scale([2, 1, 1])}}},
    "sky": {"type": "envmap", "bitmap": mi.Bitmap(np.linspace(0.2, 1.0, 8 * 16 * 3).reshape(8, 16, 3).astype(np.float32))},
})
mi.util.write_bitmap("checks.exr", mi.render(scene, spp=64))

params = mi.traverse(scene)
pixels = np.array(params["wall.bsdf.reflectance.data"])
params["wall.bsdf.reflectance.data"] = mi.TensorXf(pixels[:, :, ::-1].copy())
params.update()
mi.util.write_bitmap("swapped.exr", mi.render(scene, spp=64))
