"""Changes colors, lights, transforms and vertices of a scene by their flat names."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "path", "max_depth": 6},
    "sensor": {"type": "perspective", "fov": 40, "to_world": T().look_at(origin=[0, 2, 6], target=[0, 0.5, 0], up=[0, 1, 0]),
               "film": {"type": "hdrfilm", "width": 96, "height": 64, "pixel_format": "rgb"}},
    "paint": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.2, 0.2]}},
    "floor": {"type": "rectangle", "to_world": T().rotate([1, 0, 0], -90).scale(4), "bsdf": {"type": "ref", "id": "paint"}},
    "box": {"type": "cube", "to_world": T().translate([0.8, 0.5, 0]).scale(0.5)},
    "ball": {"type": "sphere", "to_world": T().translate([-0.9, 0.5, 0]).scale(0.5),
             "bsdf": {"type": "plastic", "diffuse_reflectance": {"type": "rgb", "value": [0.7, 0.5, 0.1]}}},
    "lamp": {"type": "point", "position": [1, 4, 3], "intensity": {"type": "rgb", "value": [20, 20, 20]}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.3, 0.4, 0.5]}},
})
mi.util.write_bitmap("before.exr", mi.render(scene, spp=64))

params = mi.traverse(scene)
print(params)
params["paint.reflectance.value"] = [0.6, 0.3, 0.2]
params["ball.bsdf.diffuse_reflectance.value"] = [0.1, 0.6, 0.2]
params["lamp.intensity.value"] = [10, 20, 40]
params["ball.to_world"] = T().translate([0, 0.5, 0]) @ params["ball.to_world"]
vertices = np.array(params["box.vertex_positions"]).reshape(-1, 3)
vertices[:, 1] *= 2
params["box.vertex_positions"] = vertices.ravel()
params.update()
mi.util.write_bitmap("after.exr", mi.render(scene, spp=64))
