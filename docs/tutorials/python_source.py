# %% [markdown]
# # Sheaf from Python
#
# This tutorial makes a scene, renders and changes it, and looks at the light transport behind the image. It takes ten
# minutes. It needs the [package](../python.md) and Matplotlib. The page is also a notebook, `docs/tutorials/python.ipynb`.

# %%
import matplotlib.pyplot as plt
import numpy as np

import sheaf

# %% [markdown]
# ## A scene
#
# A scene is a dictionary. `type` names a plugin of the [scene format](../scene-format/index.md); the key of an object is
# its id, to which others refer. Arrays become meshes: this pyramid has five vertices and four triangles.

# %%
T = sheaf.Transform
scene = sheaf.load_dict({
    "type": "scene",
    "integrator": {"type": "path"},
    "camera": {"type": "perspective", "fov": 35,
               "to_world": T.look_at(origin=(0, 2, 7.5), target=(0, 0.7, 0), up=(0, 1, 0)),
               "film": {"type": "hdrfilm", "width": 320, "height": 240}},
    "grey": {"type": "diffuse", "reflectance": {"type": "rgb", "value": (0.5, 0.5, 0.5)}},
    "clay": {"type": "diffuse", "reflectance": {"type": "rgb", "value": (0.6, 0.25, 0.15)}},
    "gold": {"type": "roughconductor", "material": "Au", "alpha": 0.2},
    "ground": {"type": "rectangle", "to_world": T.rotate((1, 0, 0), -90) @ T.scale(6),
               "bsdf": {"type": "ref", "id": "grey"}},
    "pyramid": {"type": "mesh", "face_normals": True, "bsdf": {"type": "ref", "id": "clay"},
                "vertices": np.array([(-2, 0, -0.7), (-0.6, 0, -0.7), (-0.6, 0, 0.7), (-2, 0, 0.7), (-1.3, 1.5, 0)],
                                     dtype=np.float32),
                "faces": np.array([(1, 0, 4), (2, 1, 4), (3, 2, 4), (0, 3, 4)], dtype=np.uint32)},
    "ball": {"type": "sphere", "center": (0.8, 0.9, 0), "radius": 0.9, "bsdf": {"type": "ref", "id": "gold"}},
    "lamp": {"type": "rectangle", "to_world": T.look_at(origin=(-2, 4, 3), target=(0, 0, 0), up=(0, 1, 0)) @ T.scale(0.7),
             "emitter": {"type": "area", "radiance": {"type": "rgb", "value": (20, 18, 15)}}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": (0.3, 0.35, 0.4)}},
})
scene

# %% [markdown]
# ## An image
#
# `render()` takes the options of the command line. In a notebook, the result shows itself. Its pixels are a NumPy array
# of linear radiance.

# %%
result = sheaf.render(scene, spp=64, aovs=["depth", "normal"])
print(result.image.shape, result.image.dtype, "mean", result.image[:, :, :3].mean())
result

# %% [markdown]
# Other layers come with it: here the depth, and the normals as colors.

# %%
figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
axes[0].imshow(np.where(result["depth"] > 0, result["depth"], np.nan), cmap="viridis_r")
axes[1].imshow(0.5 + 0.5 * result["normal"])
for axis, title in zip(axes, ("depth", "normal")):
    axis.set_title(title)
    axis.axis("off")

# %% [markdown]
# ## Changes
#
# Parameters are attributes. Only what has changed is computed again: a new color or camera keeps the acceleration
# structure.

# %%
scene.materials["clay"].reflectance = (0.1, 0.3, 0.5)
scene.materials["gold"].alpha = 0.05
changed = sheaf.render(scene, spp=64)
print("seconds for the acceleration structure:", changed.stats["loading"]["accel_seconds"])
changed

# %% [markdown]
# `traverse()` lists all parameters under flat names, as in Mitsuba. New values take effect with `update()`: here the
# vertices of the pyramid.

# %%
params = sheaf.traverse(scene)
vertices = params["pyramid.vertex_positions"].reshape(-1, 3)
vertices[4] = (-0.9, 2.1, 0)
params["pyramid.vertex_positions"] = vertices
print(params.update())
sheaf.render(scene, spp=64)

# %% [markdown]
# ## Noise
#
# The variance of each pixel is estimated from independent sets of samples. The error of the image falls with the square
# root of the number of samples.

# %%
counts = [4, 16, 64]
errors = [float(np.sqrt(np.mean(sheaf.render(scene, spp=n, replicates=4).variance))) for n in counts]
plt.figure(figsize=(4.5, 3.4))
plt.loglog(counts, errors, "o-", label="estimated error")
plt.loglog(counts, errors[0] * np.sqrt(counts[0] / np.array(counts)), "k:", label="1 / sqrt(N)")
plt.xlabel("samples per pixel")
plt.legend()

# %% [markdown]
# Denoising turns a quick render into a smooth one.

# %%
sheaf.denoise(sheaf.render(scene, spp=16, replicates=4, aovs=["albedo", "normal"]))

# %% [markdown]
# ## Rays
#
# `trace()` returns the nearest hits of any rays. These start above the scene and look down: a height map.

# %%
x, z = np.meshgrid(np.linspace(-3, 3, 120), np.linspace(-2, 2, 80))
origins = np.stack([x, np.full_like(x, 3), z], axis=-1).reshape(-1, 3)
hits = sheaf.trace(scene, origins, np.broadcast_to((0, -1, 0), origins.shape))
plt.figure(figsize=(6, 3.4))
plt.imshow(hits.position[:, 1].reshape(x.shape), extent=(-3, 3, 2, -2))
plt.colorbar(label="height, m")
print({name: int((hits.object == k).sum()) for k, name in enumerate(hits.object_names)})

# %% [markdown]
# ## BSDFs
#
# `bsdf()` evaluates and samples the BSDF of a material. Directions are in the shading frame, whose z axis is the normal.
# The samples follow the pdf: their histogram has the shape of the curve.

# %%
scene.materials["gold"].alpha = 0.2
gold = sheaf.bsdf(scene, "gold")
wo = (-0.5, 0, np.sqrt(0.75))
sample = gold.sample(wo, count=100000)
angles = np.radians(np.linspace(-90, 90, 361))
wi = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)

figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
axes[0].plot(np.degrees(angles), gold.evaluate(wo, wi))
axes[0].set(title="f cos in the plane of incidence", xlabel="angle, degrees")
axes[1].hist2d(sample.wi[sample.valid, 0], sample.wi[sample.valid, 1], bins=80, range=[(-1, 1), (-1, 1)])
axes[1].set(title="sampled directions, from above", aspect="equal")
print("albedo at 30 degrees:", sample.weight.mean(axis=0))

# %% [markdown]
# ## Next
#
# The folder `tools/python/examples` has scripts for a turntable, lobes of BSDFs, convergence, light tracing beside path
# tracing, a data set for computer vision, and a slider for roughness. [The reference](../python.md) describes the
# package.
