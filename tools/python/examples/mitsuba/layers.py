"""Renders depth, normals and albedo beside the image."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "aov", "aovs": "distance:depth,normal:sh_normal", "image": {"type": "path"}},
    "sensor": {"type": "orthographic", "to_world": T().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0]).scale([2, 2, 1]),
               "film": {"type": "hdrfilm", "width": 64, "height": 64, "pixel_format": "rgb", "rfilter": {"type": "box"}}},
    "wall": {"type": "rectangle", "to_world": T().translate([0, 0, -1]).scale(3)},
    "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.4, 0.2]}}},
    "sky": {"type": "constant"},
})
image = np.array(mi.render(scene, spp=32))
print(image.shape)
mi.util.write_bitmap("color.exr", image[..., :3])
np.save("depth.npy", image[..., 3])
np.save("normal.npy", image[..., 4:7])
