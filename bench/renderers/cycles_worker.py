"""Renders twin scenes with Cycles; run by programs.py with a Python that has the package bpy (see twin_worker.py)."""

import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "bench"), str(ROOT / "tools/validation")]
from exr import read_rgb  # noqa: E402
from renderers.twin_worker import Clock, main  # noqa: E402
from twins.meshes import box  # noqa: E402
from twins.scene import MAX_DEPTH, Diffuse, Glass, Metal, PointLight  # noqa: E402


def rgba(color):
    return (*color, 1)


def empty_material(name):
    """A material without nodes except for its output."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree, material.node_tree.nodes.new("ShaderNodeOutputMaterial")


def set_inputs(node, **inputs):
    for name, value in inputs.items():
        node.inputs[name].default_value = value


def add_node(tree, kind, **inputs):
    node = tree.nodes.new(kind)
    set_inputs(node, **inputs)
    return node


def surface(name, description):
    """The material of a surface."""
    material, tree, output = empty_material(name)
    if isinstance(description, Diffuse):
        node = add_node(tree, "ShaderNodeBsdfDiffuse", Color=rgba(description.color), Roughness=0)
    elif isinstance(description, Metal):
        node = tree.nodes.new("ShaderNodeBsdfMetallic")
        node.fresnel_type, node.distribution = "PHYSICAL_CONDUCTOR", "GGX"
        set_inputs(node, IOR=description.eta, Extinction=description.k, Roughness=description.alpha ** 0.5)
    else:
        assert isinstance(description, Glass)
        node = add_node(tree, "ShaderNodeBsdfGlass", Color=rgba((1, 1, 1)), Roughness=0, IOR=description.ior)
        node.distribution = "GGX"
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def make_mesh(name, mesh, material):
    vertices, triangles = mesh
    result = bpy.data.meshes.new(name)
    result.vertices.add(len(vertices))
    result.vertices.foreach_set("co", np.asarray(vertices, np.float32).ravel())
    result.loops.add(triangles.size)
    result.loops.foreach_set("vertex_index", np.asarray(triangles, np.int32).ravel())
    result.polygons.add(len(triangles))
    result.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    result.update(calc_edges=True)
    result.polygons.foreach_set("use_smooth", np.zeros(len(triangles), bool))
    result.materials.append(material)
    return result


def place(name, data, matrix):
    """Adds an object. The offsets hide artifacts of shading normals, which these scenes do not have."""
    result = bpy.data.objects.new(name, data)
    result.matrix_world = Matrix(np.asarray(matrix).tolist())
    result.shadow_terminator_geometry_offset = result.shadow_terminator_shading_offset = 0
    bpy.context.scene.collection.objects.link(result)
    return result


def frame(x, y, z, origin):
    """The matrix with these columns."""
    return np.vstack([np.column_stack([x, y, z, origin]), [0, 0, 0, 1]])


def add_light(index, lamp, is_hidden):
    if isinstance(lamp, PointLight):
        data = bpy.data.lights.new(f"light{index}", "POINT")
        data.shadow_soft_size = 0
        radiance, power = lamp.intensity, 4 * np.pi
        matrix = frame(*np.eye(3), lamp.position)
    else:
        data = bpy.data.lights.new(f"light{index}", "AREA")
        u, v = np.asarray(lamp.u), np.asarray(lamp.v)
        data.shape, data.size, data.size_y = "RECTANGLE", 2 * np.linalg.norm(u), 2 * np.linalg.norm(v)
        # An area light shines along its -z
        x, y = 2 * u / data.size, -2 * v / data.size_y
        radiance, power = lamp.radiance, np.pi * data.size * data.size_y
        matrix = frame(x, y, np.cross(x, y), lamp.center)
    data.energy, data.color = power * max(radiance), [c / max(radiance) for c in radiance]
    place(f"light{index}", data, matrix).visible_camera = not is_hidden


def add_world(scene, folder):
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = rgba((0, 0, 0) if scene.has_sky else scene.environment or (0, 0, 0))
    if scene.has_sky:
        image = tree.nodes.new("ShaderNodeTexEnvironment")
        image.image = bpy.data.images.load(f"{folder}/sky.hdr")
        tree.links.new(image.outputs["Color"], background.inputs["Color"])


def add_fog(fog):
    material, tree, output = empty_material("fog")
    scattering = add_node(tree, "ShaderNodeVolumeScatter", Color=rgba((1, 1, 1)), Density=fog.scattering, Anisotropy=0)
    absorption = add_node(tree, "ShaderNodeVolumeAbsorption", Color=rgba((0, 0, 0)), Density=fog.absorption)
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(scattering.outputs[0], both.inputs[0])
    tree.links.new(absorption.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Volume"])
    place("fog", make_mesh("fog", box(fog.low, fog.high), material), np.eye(4))


def add_camera(scene):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle, data.clip_start, data.clip_end = "HORIZONTAL", np.radians(scene.fov), 0.001, 10000
    right, up, forward = scene.camera_axes()
    bpy.context.scene.camera = place("camera", data, frame(right, up, -forward, scene.eye))


def set_up(job):
    """No clamping, denoising, adaptive sampling or blurred caustics; otherwise Cycles' defaults."""
    render, cycles = bpy.context.scene.render, bpy.context.scene.cycles
    render.engine, render.resolution_percentage = "CYCLES", 100
    render.resolution_x, render.resolution_y = job["width"], job["height"]
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.exr_codec = "ZIP"
    render.threads_mode, render.threads = "FIXED", job["threads"]
    render.use_persistent_data, render.dither_intensity = True, 0
    render.use_compositing = render.use_sequencer = False
    render.filepath = job["output"] + ".exr"
    cycles.device, cycles.pixel_filter_type = "CPU", "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0
    bounces = MAX_DEPTH - 2  # between the first and the last segment
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.volume_bounces = cycles.transparent_max_bounces = bounces


def load(scene, job):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = {name: surface(name, description) for name, description in scene.materials.items()}
    meshes = {name: make_mesh(name, mesh, materials[material]) for name, (mesh, material) in scene.meshes.items()}
    for index, (name, matrix) in enumerate(scene.objects):
        place(f"{name}{index}", meshes[name], matrix)
    for index, lamp in enumerate(scene.lights):
        add_light(index, lamp, scene.hides_lights)
    add_world(scene, job["folder"])
    if scene.fog:
        add_fog(scene.fog)
    add_camera(scene)
    set_up(job)


def timed_call(spp, seed):
    """Returns the wall and CPU time of a call that renders."""
    bpy.context.scene.cycles.samples, bpy.context.scene.cycles.seed = spp, seed
    bpy.context.scene.update_tag()  # otherwise the next call renders with the old settings
    clock = Clock()
    bpy.ops.render.render(write_still=True)
    return clock.times()


def render(_, job, seed):
    """Each call synchronizes the scene, so the times are those of all samples less those of one."""
    times = timed_call(job["spp"], seed)
    finished = time.time()
    pixels = read_rgb(Path(job["output"] + ".exr"))
    if job["spp"] > 1:
        factor = job["spp"] / (job["spp"] - 1)
        times = [max(factor * (all_samples - one), 1e-3) for all_samples, one in zip(times, timed_call(1, seed))]
    return pixels, *times, finished


if __name__ == "__main__":
    main("Cycles", bpy.app.version_string, load, render)
