"""Makes a mesh from arrays, writes it as a PLY file, and renders it with colors at its vertices."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

# A wavy disk: a center, and rings of vertices
rings, around = 24, 60
radius, angle = np.meshgrid(np.linspace(0, 1, rings + 1)[1:], np.linspace(0, 2 * np.pi, around, endpoint=False), indexing="ij")
wave = 0.2 * np.sin(10 * radius) * (1 - radius)
ring_points = np.stack([radius * np.cos(angle), wave, radius * np.sin(angle)], axis=-1).reshape(-1, 3)
vertices = np.concatenate([[[0, 0, 0]], ring_points])
faces = [(0, 1 + (k + 1) % around, 1 + k) for k in range(around)]
for ring in range(rings - 1):
    for k in range(around):
        a, b = 1 + ring * around + k, 1 + ring * around + (k + 1) % around
        faces += [(a, b, a + around), (b, b + around, a + around)]

props = mi.Properties()
props["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "vertex_color"}})
mesh = mi.Mesh("disk", vertex_count=len(vertices), face_count=len(faces), has_vertex_normals=False, props=props)
params = mi.traverse(mesh)
params["vertex_positions"] = vertices.ravel()
params["faces"] = np.ravel(faces)
params.update()
mesh.add_attribute("vertex_color", 3, (0.5 + 0.5 * np.clip(vertices * [1, 4, 1], -1, 1)).ravel())
mesh.write_ply("disk.ply")
print(mesh.vertex_count(), "vertices,", mesh.face_count(), "triangles")

scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "path"},
    "sensor": {"type": "perspective", "fov": 35, "to_world": T().look_at(origin=[0, 3, 4], target=[0, 0, 0], up=[0, 1, 0]),
               "film": {"type": "hdrfilm", "width": 96, "height": 64, "pixel_format": "rgb"}},
    "colored": mesh,
    "from_file": {"type": "ply", "filename": "disk.ply", "to_world": T().translate([0, -0.5, 0]).scale(1.5),
                  "bsdf": {"type": "twosided", "inner": {"type": "diffuse"}}},
    "lamp": {"type": "constant"},
})
mi.util.write_bitmap("mesh.exr", mi.render(scene, spp=64))
