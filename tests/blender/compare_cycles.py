#!/usr/bin/env python3
"""Renders scenes in Blender with the add-on and with Cycles and compares the mean colors. Needs `pip install bpy` (4.2 or
newer) in a virtual environment, hence it is not part of the other tests. Takes a minute.

  venv/bin/python tests/blender/compare_cycles.py --sheaf build/release/sheaf [--output FOLDER]

Exit status: 0 if all scenes agree.
"""

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path

FOLDER = tempfile.mkdtemp()
os.environ["BLENDER_USER_RESOURCES"] = FOLDER

import bpy  # noqa: E402
import numpy as np  # noqa: E402

ADDON = Path(__file__).resolve().parent.parent.parent / "tools/blender/sheaf_render.py"


def material(name, **inputs):
    out = bpy.data.materials.new(name)
    out.use_nodes = True
    node = next(node for node in out.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    return out


def add(kind, surface=None, **values):
    """A mesh of Blender's operator `kind`, with a material."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(**values)
    if surface:
        bpy.context.object.data.materials.append(surface)
    return bpy.context.object


def lamp(kind, energy, location, rotation=(0, 0, 0), **values):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    for name, value in values.items():
        setattr(data, name, value)
    return place(data, location, rotation)


def place(data, location, rotation):
    thing = bpy.data.objects.new(type(data).__name__, data)
    thing.location, thing.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(thing)
    return thing


def camera(location, rotation, **values):
    data = bpy.data.cameras.new("camera")
    for name, value in values.items():
        setattr(data, name, value)
    bpy.context.scene.camera = place(data, location, rotation)
    return data


def world(color=(0.4, 0.4, 0.4, 1), strength=1.0):
    bpy.context.scene.world = bpy.data.worlds.new("world")
    bpy.context.scene.world.use_nodes = True
    tree = bpy.context.scene.world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs[0].default_value, background.inputs[1].default_value = color, strength
    return tree, background


def lights_and_materials():
    world((0.2, 0.3, 0.5, 1), 0.3)
    add("plane", material("floor", Base_Color=(0.7, 0.7, 0.7, 1), Roughness=0.8), size=12)
    for k, surface in enumerate((material("red", Base_Color=(0.8, 0.1, 0.1, 1), Roughness=0.4),
                                 material("gold", Base_Color=(0.9, 0.6, 0.2, 1), Metallic=1, Roughness=0.2),
                                 material("glass", Base_Color=(1, 1, 1, 1), Transmission_Weight=1, Roughness=0.0),
                                 material("coat", Base_Color=(0.1, 0.2, 0.7, 1), Coat_Weight=1, Roughness=0.6))):
        add("uv_sphere", surface, radius=0.6, location=(-2.4 + 1.6 * k, 0, 0.6), segments=48, ring_count=24)
        bpy.ops.object.shade_smooth()
    glow = material("glow", Base_Color=(0.1, 0.1, 0.1, 1), Emission_Color=(0.3, 1, 0.4, 1), Emission_Strength=2)
    add("cube", glow, size=0.8, location=(0, 2.2, 0.9)).modifiers.new("bevel", "BEVEL").width = 0.08
    lamp("AREA", 150, (-2, -1, 3.5), (0.3, -0.4, 0), shape="RECTANGLE", size=1.2, size_y=0.6, color=(1, 0.9, 0.8))
    lamp("POINT", 60, (2.5, -1.5, 2.2), shadow_soft_size=0.15)
    lamp("SPOT", 200, (1, 3.5, 4), (-0.6, 0, 0), spot_size=0.8, spot_blend=0.2, shadow_soft_size=0, color=(0.6, 0.7, 1))
    lamp("SUN", 0.5, (0, 0, 5), (0.7, 0.5, 0))
    camera((0, -8, 3.2), (1.25, 0, 0))


def sky():
    tree, background = world(strength=0.1)
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sun_elevation, node.sun_rotation = 0.4, 2.0
    tree.links.new(node.outputs[0], background.inputs[0])
    add("plane", size=20)
    add("cube", size=1, location=(0, 0, 0.5))
    camera((0, -6, 2), (1.3, 0, 0))


def motion():
    world()
    add("plane", size=20)
    cube = add("cube", size=1, location=(-1, 0, 0.5))
    for frame, x, turn in ((1, -1, 0), (3, 1, 2)):
        cube.location.x, cube.rotation_euler.z = x, turn
        cube.keyframe_insert("location", frame=frame)
        cube.keyframe_insert("rotation_euler", frame=frame)
    lamp("SUN", 3, (0, 0, 3), (0.5, 0.4, 0))
    camera((0, -6, 2), (1.3, 0, 0))
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.8
    scene.frame_set(2)


def lens():
    world()
    add("plane", size=20)
    for x in range(-2, 3):
        add("cube", material("cube", Base_Color=(0.5 + 0.15 * x, 0.3, 0.5 - 0.15 * x, 1)), size=0.6,
            location=(x, 1.2 * x, 0.3))
    data = camera((0, -6, 2), (1.3, 0, 0), shift_x=0.2, shift_y=0.1)
    data.dof.use_dof, data.dof.aperture_fstop, data.dof.focus_object = True, 0.2, bpy.data.objects["Cube"]


def render(engine, samples, file):
    """The image of the scene, float32 (height, width, 3)."""
    scene = bpy.context.scene
    scene.render.engine, scene.render.filepath = engine, str(file)
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.sheaf.samples = scene.cycles.samples = samples
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(file))
    pixels = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], image.channels)[..., :3]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", required=True, type=Path)
    parser.add_argument("--output", type=Path, default=Path(FOLDER), help="folder of the images")
    arguments = parser.parse_args()
    shutil.copy(ADDON, bpy.utils.user_resource("SCRIPTS", path="addons", create=True))
    sys.path.insert(0, bpy.utils.user_resource("SCRIPTS", path="addons"))
    lines, failed = [], False
    for make in (lights_and_materials, sky, motion, lens):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.preferences.addon_enable(module="sheaf_render")
        bpy.context.preferences.addons["sheaf_render"].preferences.program = str(arguments.sheaf.resolve())
        bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 240, 135
        make()
        images = [render(engine, 64, arguments.output / f"{make.__name__}_{engine.lower()}.exr")
                  for engine in ("SHEAF", "CYCLES")]
        # Values above 4 are reflections of lamps, whose noise would hide differences
        means = [np.minimum(image, 4).mean((0, 1)) for image in images]
        good = np.allclose(*means, rtol=0.03)
        failed |= not good
        lines.append(f"{make.__name__}: Sheaf {means[0]}, Cycles {means[1]}{'' if good else ' DIFFERENT'}")
    print(*lines, sep="\n")
    return failed


if __name__ == "__main__":
    status = main()
    shutil.rmtree(FOLDER)
    sys.exit(status)
