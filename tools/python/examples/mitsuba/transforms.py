"""Composes transforms: chains, products, inverses, cameras."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

chain = T().translate([1, 2, 3]).rotate([0, 1, 0], 30).scale([1, 2, 1])
product = T().translate([1, 2, 3]) @ T().rotate(axis=[0, 1, 0], angle=30) @ T().scale([1, 2, 1])
camera = T().look_at(origin=[0, 1, 5], target=[0, 0, 0], up=[0, 1, 0])
matrix = T(np.diag([2.0, 2.0, 2.0, 1.0])) @ chain
moved = np.array(chain @ mi.ScalarPoint3f([1, 1, 1]))
back = np.array(chain.inverse() @ mi.ScalarPoint3f(moved))

np.save("transforms.npy", np.array([np.array(t.matrix) for t in (chain, product, camera, matrix, camera.inverse())]))
np.save("points.npy", np.array([moved, back]))
print(chain.matrix)
