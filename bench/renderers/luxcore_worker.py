"""Renders twin scenes with LuxCore; run by programs.py with a Python that has pyluxcore (see twin_worker.py)."""

import sys
import time
from pathlib import Path

import numpy as np
import pyluxcore

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from renderers.twin_worker import Clock, main  # noqa: E402
from twins.meshes import box, quad  # noqa: E402
from twins.scene import MAX_DEPTH, Diffuse, Glass, Metal, PointLight  # noqa: E402

# LuxCore's maps begin at +x and turn to +y; those of the scenes have +x in their middle and +y in their left half.
SKY_TO_WORLD = np.diag([-1.0, 1, 1, 1])


def properties(prefix, values):
    """Properties whose names begin with a prefix."""
    result = pyluxcore.Properties()
    for name, value in values.items():
        if isinstance(value, (tuple, list, np.ndarray)):
            value = [float(x) for x in np.ravel(value)]
        result.Set(pyluxcore.Property(f"{prefix}{name}", value))
    return result


def column_major(matrix):
    return np.asarray(matrix).T


def add_material(target, name, material):
    prefix = f"scene.materials.{name}."
    if isinstance(material, Diffuse):
        target.Parse(properties(prefix, {"type": "matte", "kd": material.color}))
    elif isinstance(material, Metal):
        target.Parse(properties(f"scene.textures.{name}-fresnel.", {"type": "fresnelconst", "n": material.eta,
                                                                     "k": material.k}))
        target.Parse(properties(prefix, {"type": "metal2", "fresnel": f"{name}-fresnel", "uroughness": material.alpha,
                                         "vroughness": material.alpha}))
    else:
        assert isinstance(material, Glass)
        target.Parse(properties(prefix, {"type": "glass", "kr": (1, 1, 1), "kt": (1, 1, 1),
                                         "interiorior": material.ior, "exteriorior": 1.0}))


def define_mesh(target, name, mesh):
    """Adds a mesh by lists, for small ones."""
    vertices, triangles = mesh
    target.DefineMesh(name, [tuple(map(float, v)) for v in vertices], [tuple(map(int, t)) for t in triangles],
                      None, None, None, None)


def add_light(target, name, lamp, is_hidden):
    if isinstance(lamp, PointLight):
        color = [4 * np.pi * c for c in lamp.intensity]
        target.Parse(properties(f"scene.lights.{name}.", {"type": "point", "position": lamp.position, "color": color,
                                                           "power": 0.0, "efficency": 0.0}))
        return
    define_mesh(target, name, quad(lamp.center, lamp.u, lamp.v))
    target.Parse(properties(f"scene.materials.{name}.", {
        "type": "matte", "kd": (0, 0, 0), "emission": lamp.radiance, "emission.power": 0.0, "emission.efficency": 0.0}))
    target.Parse(properties(f"scene.objects.{name}.", {"shape": name, "material": name, "camerainvisible": is_hidden}))


def add_environment(target, scene, folder):
    if scene.has_sky:
        values = {"type": "infinite", "file": f"{folder}/sky.hdr", "gamma": 1.0,
                  "transformation": column_major(SKY_TO_WORLD)}
    elif scene.environment:
        values = {"type": "constantinfinite", "color": scene.environment}
    else:
        return
    target.Parse(properties("scene.lights.environment.", values))


def add_fog(target, fog):
    target.Parse(properties("scene.volumes.fog.", {
        "type": "homogeneous", "absorption": [fog.absorption] * 3, "scattering": [fog.scattering] * 3,
        "asymmetry": (0, 0, 0), "multiscattering": True}))
    target.Parse(properties("scene.materials.fog-boundary.", {"type": "null", "volume.interior": "fog"}))
    define_mesh(target, "fog", box(fog.low, fog.high))
    target.Parse(properties("scene.objects.fog.", {"shape": "fog", "material": "fog-boundary"}))


def load(scene, job):
    target = pyluxcore.Scene()
    # LuxCore's image lies one row lower than those of other renderers
    aspect, row = job["height"] / job["width"], 2 / job["width"]
    target.Parse(properties("scene.camera.", {
        "type": "perspective", "lookat.orig": scene.eye, "lookat.target": scene.target, "up": (0, 0, 1),
        "fieldofview": scene.fov, "screenwindow": (-1, 1, -aspect - row, aspect - row), "cliphither": 0.001,
        "clipyon": 10000.0, "autofocus.enable": False, "lensradius": 0.0}))
    for name, material in scene.materials.items():
        add_material(target, name, material)
    for name in scene.meshes:
        target.Parse(properties(f"scene.shapes.{name}.", {"type": "mesh", "ply": f"{job['folder']}/{name}.ply"}))
    objects = pyluxcore.Properties()
    for index, (name, matrix) in enumerate(scene.objects):
        values = {"shape": name, "material": scene.meshes[name][1]}
        if scene.count(name) > 1:
            values["transformation"] = column_major(matrix)  # makes it an instance
        objects.Set(properties(f"scene.objects.{name}{index}.", values))
    target.Parse(objects)
    for index, lamp in enumerate(scene.lights):
        add_light(target, f"light{index}", lamp, scene.hides_lights)
    add_environment(target, scene, job["folder"])
    if scene.fog:
        add_fog(target, scene.fog)
    return target


def settings(job, seed):
    """Sobol samples without adaption and without clamping; otherwise LuxCore's defaults."""
    return {
        "renderengine.type": "PATHCPU", "renderengine.seed": seed + 1, "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0, "film.width": job["width"], "film.height": job["height"],
        "film.filter.type": "NONE", "path.pathdepth.total": MAX_DEPTH, "path.pathdepth.diffuse": MAX_DEPTH,
        "path.pathdepth.glossy": MAX_DEPTH, "path.pathdepth.specular": MAX_DEPTH,
        "path.clamping.variance.maxvalue": 0.0, "native.threads.count": job["threads"], "batch.haltspp": job["spp"],
        "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr"}


def render(scene, job, seed):
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties("", settings(job, seed)), scene))
    session.Start()
    clock = Clock()
    while not session.HasDone():
        time.sleep(0.005)
        session.UpdateStats()
    times = clock.times()
    count = session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat()
    print("samples per pixel", count / (job["width"] * job["height"]), file=sys.stderr)
    session.Stop()
    image = np.zeros((job["height"], job["width"], 3), np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, image, 0)
    return image[::-1], *times, time.time()


if __name__ == "__main__":
    pyluxcore.Init(lambda *_: None)
    main("LuxCore", pyluxcore.Version(), load, render)
