"""Traces rays from a program: a map of heights."""

import numpy as np

import sheaf  # Mitsuba:
import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

scene = mi.load_dict({
    "type": "scene",
    "ground": {"type": "rectangle", "to_world": T().rotate([1, 0, 0], -90).scale(5)},
    "ball": {"type": "sphere", "center": [0, 0.5, 0], "radius": 1.0},
    "box": {"type": "cube", "to_world": T().translate([2, 0.5, 1]).rotate([0, 1, 0], 20).scale(0.5)},
})
x, z = np.meshgrid(np.linspace(-3, 3, 48), np.linspace(-2, 2, 32))
origins = np.stack([x, 0 * x + 10, z], axis=-1).reshape(-1, 3)
down = np.array([0.0, -1.0, 0.0])
distance = sheaf.trace(scene, origins, np.broadcast_to(down, origins.shape)).distance  # Mitsuba: distance = np.array([scene.ray_intersect(mi.Ray3f(mi.ScalarPoint3f(o), mi.ScalarVector3f(down))).t for o in origins])
height = 10 - np.array(distance).reshape(x.shape)
np.save("height.npy", height)
print("highest point:", height.max())
