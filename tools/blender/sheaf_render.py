"""Blender add-on: renders the scene with Sheaf.

Install this file in Edit > Preferences > Add-ons > Install from Disk, and choose Sheaf as the render engine. The add-on
needs Blender 4.2 or newer and the program `sheaf`, from PATH or from the add-on's preferences.

A render saves a copy of the scene. A second Blender in the background flattens it to one object per mesh or instance
and exports it by Blender's glTF exporter (`Exporter` below); Cycles converts the world to an environment map. Then
`sheaf render` renders the file, sends the unfinished image by the protocol of the viewer tev, and writes an OpenEXR
image, whose layers become Blender's render passes. docs/get-started/blender.md describes what the scene may contain.
"""

import contextlib
import json
import math
import os
import pty
import re
import select
import shlex
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

bl_info = {
    "name": "Sheaf",
    "description": "Path tracing on the CPU with Sheaf",
    "version": (0, 2, 0),
    "blender": (4, 2, 0),
    "location": "Render properties > Render Engine",
    "category": "Render",
}

ENGINE = "SHEAF"
MESHES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}  # types of objects that become meshes
FAR = 1e10                                             # depth of the background, as in Cycles
STOP_SECONDS = 10                                      # for Sheaf to write the unfinished image


class RenderError(Exception):
    """An error that Blender shows to the user."""


# ---- Images --------------------------------------------------------------------------------------------------------


def read_exr(path):
    """The channels of an uncompressed OpenEXR file of scan lines, as `sheaf render --compression none` writes it: a
    dictionary of float32 arrays of shape (height, width), the first row at the bottom. ValueError: another file."""
    data = Path(path).read_bytes()
    if data[:4] != b"\x76\x2f\x31\x01" or data[5] & 0x1A:  # tiles, deep data, several parts
        raise ValueError(f"{path} is not an OpenEXR file of scan lines")

    # Read the header
    position, header = 8, {}
    while data[position]:
        name_end = data.index(0, position)
        type_end = data.index(0, name_end + 1)
        size, = struct.unpack_from("<i", data, type_end + 1)
        header[data[position:name_end].decode()] = data[type_end + 5:type_end + 5 + size]
        position = type_end + 5 + size
    if header["compression"][0] != 0:
        raise ValueError(f"{path} is compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1

    # Describe a scan line: the row, the number of bytes, then one run of values per channel
    channels, fields, at = header["channels"], [("y", "<i4"), ("size", "<i4")], 0
    while channels[at]:
        end = channels.index(0, at)
        kind, = struct.unpack_from("<i", channels, end + 1)
        fields.append(("c:" + channels[at:end].decode(), ("<u4", "<f2", "<f4")[kind], (width,)))
        at = end + 17
    lines = np.frombuffer(data, np.dtype(fields), height, position + 1 + 8 * height)
    return {name[2:]: lines[name][::-1].astype(np.float32) for name, *_ in fields[2:]}


class TevServer:
    """Receives the image during rendering by the protocol of the viewer tev. A packet begins with its length, including
    these four bytes, and its type. Integers are little-endian, strings end with a zero byte."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.setblocking(False)
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.client, self.buffer, self.image = None, bytearray(), None

    def receive(self, x0, y0, width, height):
        """Reads what has arrived. The image of the window as float32 of shape (height, width, 4), the first row at the
        bottom, or None if nothing has changed."""
        if self.client is None:
            with contextlib.suppress(BlockingIOError):
                self.client, _ = self.listener.accept()
                self.client.setblocking(False)
            if self.client is None:
                return None
        with contextlib.suppress(BlockingIOError, ConnectionError):
            while piece := self.client.recv(1 << 20):
                self.buffer += piece
        changed = False
        while len(self.buffer) >= 4 and len(self.buffer) >= (size := struct.unpack_from("<I", self.buffer)[0]) > 4:
            changed |= self.handle(bytes(self.buffer[4:size]))
            del self.buffer[:size]
        return self.image[y0:y0 + height, x0:x0 + width][::-1] if changed else None

    def handle(self, packet):
        """Applies a packet. Whether it has changed the image."""
        at = packet.index(0, 2) + 1  # after the type, a flag and the name
        if packet[0] == 4:  # opens an empty image
            width, height = struct.unpack_from("<2i", packet, at)
            self.image = np.zeros((height, width, 4), np.float32)
        elif packet[0] == 6 and self.image is not None:  # rows of an image
            count, = struct.unpack_from("<i", packet, at)
            at += 4
            names = []
            for _ in range(count):
                end = packet.index(0, at)
                names.append(packet[at:end].decode())
                at = end + 1
            x, y, width, height = struct.unpack_from("<4i", packet, at)
            rows = np.frombuffer(packet, "<f4", width * height * count, at + 16 + 16 * count)
            rows = rows.reshape(height, width, count)
            for channel, name in enumerate("RGBA"):
                if name in names:
                    self.image[y:y + height, x:x + width, channel] = rows[:, :, names.index(name)]
            return True
        return False

    def close(self):
        for connection in (self.client, self.listener):
            if connection is not None:
                connection.close()


# ---- Programs ------------------------------------------------------------------------------------------------------


class Program:
    """A running program. Its output goes to a terminal of its own, so that it shows a progress bar."""

    def __init__(self, command):
        self.master, slave = pty.openpty()
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=slave, stderr=slave,
                                            start_new_session=True)
        except OSError as error:
            os.close(self.master)
            raise RenderError(f"{command[0]} does not start: {error.strerror}") from error
        finally:
            os.close(slave)
        self.rest, self.lines, self.progress = "", [], 0.0

    def wait(self, seconds):
        """Reads output for up to `seconds`. Whether the program is still running."""
        ends = time.monotonic() + seconds
        while (left := ends - time.monotonic()) > 0:
            if not select.select([self.master], [], [], left)[0]:
                break
            try:
                text = os.read(self.master, 65536).decode(errors="replace")
            except OSError:  # the program has ended
                self.process.wait()
                break
            pieces = re.split(r"[\r\n]+", re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", self.rest + text))
            self.rest = pieces.pop()
            for line in [*pieces, self.rest]:
                if match := re.search(r"(\d+) %", line):
                    self.progress = min(int(match[1]) / 100, 1.0)
            self.lines += [line.strip() for line in pieces if line.strip()]
        return self.process.poll() is None

    def stop(self, number):
        if self.process.poll() is None:
            os.killpg(self.process.pid, number)

    def close(self):
        self.stop(signal.SIGKILL)
        self.process.wait()
        os.close(self.master)


def find_sheaf(preferred):
    """The program: the file `preferred`, or if that is empty, `sheaf` from PATH."""
    path = shutil.which(os.path.expanduser(preferred) if preferred else "sheaf")
    if path is None:
        raise RenderError(f"{preferred} is not a program; correct the path in the preferences of the add-on Sheaf"
                          if preferred else "the program sheaf is not in PATH; set its path in the preferences of the "
                          "add-on Sheaf")
    return path


def exporter_command(job):
    """Starts this file in a second Blender, which runs `Exporter`. `job`: path of its JSON file."""
    if not bpy.app.binary_path:  # Blender as a Python module
        return [sys.executable, __file__, "--", job]
    scripts = bpy.context.preferences.filepaths.use_scripts_auto_execute
    return [bpy.app.binary_path, "--background", "--factory-startup",
            "--enable-autoexec" if scripts else "--disable-autoexec", "--python-exit-code", "1", "--python", __file__,
            "--", job]


def render_window(render, width, height):
    """The pixels to render, as x0, y0, width, height with y downwards from the top."""
    if not render.use_border:
        return 0, 0, width, height
    x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
    y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
    return x0, height - y1, max(x1 - x0, 1), max(y1 - y0, 1)


def render_command(sheaf, settings, job, exported, size, window, threads):
    """The command that renders the exported scene to job["image"]."""
    x0, y0, width, height = window
    command = [sheaf, "render", job["model"], "-o", job["image"], "--compression", "none", "--float",
               "--no-timestamps", "--size", f"{size[0]}x{size[1]}", "--no-floor", "--env",
               exported["environment"] or "none", "--aov", "albedo,normal,position,depth", "--spp",
               str(settings.samples), "--seed", str(settings.seed), "--max-depth", str(settings.max_depth)]
    if window != (0, 0, *size):
        command += ["--crop", f"{x0},{y0},{x0 + width},{y0 + height}"]
    if settings.integrator != "path":
        command += ["--integrator", settings.integrator]
    else:
        command += [f"--guiding={settings.guiding}"]
    if settings.noise_target > 0:
        command += ["--noise-target", f"{settings.noise_target:g}"]
    if settings.denoiser != "none":
        command += ["--denoise", settings.denoiser]
    if settings.spectral:
        command += ["--color", "spectral"]
    if exported["shutter"]:
        command += ["--time", "0", "--shutter", "0:" + str(exported["shutter"])]
    if threads:
        command += ["--threads", str(threads)]
    if settings.lenient:
        command += ["--lenient"]
    return command + shlex.split(settings.options)


def passes_of(layers):
    """Blender's passes from the layers of Sheaf's image: name to float32 array (height, width, channels)."""
    def stack(*names):
        return np.stack([layers[name] for name in names], axis=-1)
    prefix = "denoised." if "denoised.R" in layers else ""
    out = {"Combined": stack(prefix + "R", prefix + "G", prefix + "B", "A")}
    if "Z" in layers:
        out["Depth"] = np.where(layers["Z"] > 0, layers["Z"], FAR)[..., None].astype(np.float32)
    if "N.X" in layers:  # glTF's y axis points up
        out["Normal"] = stack("N.X", "N.Z", "N.Y") * np.array([1, -1, 1], np.float32)
    if "P.X" in layers:
        out["Position"] = stack("P.X", "P.Z", "P.Y") * np.array([1, -1, 1], np.float32)
    if "albedo.R" in layers:
        out["DiffCol"] = stack("albedo.R", "albedo.G", "albedo.B")
    return out


def shutter_times(render, frame):
    """The first, middle and last time of the shutter in frames; the frame alone without motion blur."""
    if not render.use_motion_blur or render.motion_blur_shutter <= 0:
        return [frame]
    length = render.motion_blur_shutter
    first = frame + {"START": 0.0, "CENTER": -0.5, "END": -1.0}[render.motion_blur_position] * length
    return [first, first + 0.5 * length, first + length]


# ---- Export, in a second Blender -----------------------------------------------------------------------------------


def complete_materials(gltf):
    """Makes transmissive materials refract: glTF regards a surface without a volume as thin."""
    for material in gltf.get("materials", []):
        extensions = material.get("extensions", {})
        if extensions.get("KHR_materials_transmission"):
            extensions.setdefault("KHR_materials_volume", {"thicknessFactor": 1.0})
            used = gltf.setdefault("extensionsUsed", [])
            if "KHR_materials_volume" not in used:
                used.append("KHR_materials_volume")


def edit_glb(path, edit):
    """Applies `edit` to the JSON of a binary glTF file."""
    data = Path(path).read_bytes()
    length, = struct.unpack_from("<I", data, 12)
    gltf = json.loads(data[20:20 + length])
    edit(gltf)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + data[20 + length:]
    Path(path).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)


def area_of(vertices, triangles):
    """Area of a mesh of triangles."""
    a, b, c = (np.asarray(vertices, float)[[t[k] for t in triangles]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def lamp_mesh(light, scale):
    """Vertices and triangles of an area light, which shines along -z, or of a soft point light. `scale`: of the object;
    it scales area lights alone."""
    if light.type == "POINT":
        rings, sides = 8, 16
        points = [(math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t))
                  for t in np.linspace(0, math.pi, rings + 1)
                  for p in np.arange(sides) * 2 * math.pi / sides]
        triangles = []
        for ring in range(rings):
            for side in range(sides):
                a, b = ring * sides + side, ring * sides + (side + 1) % sides
                triangles += [(a, a + sides, b + sides)] if ring < rings - 1 else []
                triangles += [(a, b + sides, b)] if ring > 0 else []
        return [tuple(light.shadow_soft_size * x for x in point) for point in points], triangles
    width = 0.5 * light.size * scale[0]
    height = 0.5 * (light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size) * scale[1]
    if light.shape in {"SQUARE", "RECTANGLE"}:
        corners = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
    else:
        corners = [(math.cos(a), -math.sin(a)) for a in np.arange(48) * math.pi / 24]
    return ([(width * x, height * y, 0.0) for x, y in corners],
            [(0, k, k + 1) for k in range(1, len(corners) - 1)])


class Exporter:
    """Exports the scene of a copied .blend file."""

    def __init__(self, job):
        self.job, self.warnings = job, []
        for thing in list(bpy.data.objects):  # of the same names, perhaps
            bpy.data.objects.remove(thing)
        with bpy.data.libraries.load(job["blend"]) as (_, to):
            to.scenes = [job["scene"]]
        self.scene = to.scenes[0]
        bpy.context.window.scene = self.scene
        bpy.context.window.view_layer = self.scene.view_layers[job["view_layer"]]
        self.objects, self.meshes, self.cameras = {}, {}, {}

    def warn(self, text):
        if text not in self.warnings:
            self.warnings.append(text)

    def run(self):
        """Writes the files that the job names. Returns the environment map, the shutter and the warnings."""
        job = self.job
        environment = self.bake_world() if self.scene.world else None
        self.use_render_settings()
        times = job["times"]
        middle = len(times) // 2
        placements = {}
        for k in [middle, *(k for k in range(len(times)) if k != middle)]:
            self.scene.frame_set(math.floor(times[k]), subframe=times[k] - math.floor(times[k]))
            placements[k] = self.collect(create=k == middle)
        moves = self.place(placements, middle)
        self.export(moves, len(times))
        return {"environment": environment, "shutter": len(times) - 1 if moves else 0, "warnings": self.warnings}

    def use_render_settings(self):
        """Shows what a render shows: the exporter sees the scene as in a viewport."""
        def show(layer):
            layer.hide_viewport = False
            layer.collection.hide_viewport = layer.collection.hide_render
            for child in layer.children:
                show(child)
        show(bpy.context.view_layer.layer_collection)
        for thing in self.scene.objects:
            thing.hide_viewport = thing.hide_render
            thing.hide_set(False)
            for modifier in thing.modifiers:
                modifier.show_viewport = modifier.show_render
                if modifier.type in {"SUBSURF", "MULTIRES"}:
                    modifier.levels = modifier.render_levels

    def collect(self, create):
        """Matrices of all objects and instances by a key that lasts over time. `create`: make their copies, too."""
        depsgraph = bpy.context.evaluated_depsgraph_get()
        matrices = {}
        for instance in depsgraph.object_instances:
            thing = instance.object
            if not instance.show_self or thing.type not in MESHES | {"LIGHT"}:
                if create and thing.type in {"CURVES", "VOLUME", "POINTCLOUD"}:
                    self.warn(f"{thing.name}: objects of the type {thing.type} are left out")
                continue
            key = (thing.name, instance.parent.name if instance.parent else "", *instance.persistent_id)
            matrices[key] = instance.matrix_world.copy()
            if create:
                copy = self.copy_light(thing, matrices[key]) if thing.type == "LIGHT" else self.copy_mesh(thing,
                                                                                                       depsgraph)
                if copy is not None:
                    self.objects[key] = copy
        camera = self.scene.objects[self.job["camera"]]
        matrices["camera"] = camera.evaluated_get(depsgraph).matrix_world.normalized()
        if create:
            self.objects["camera"] = bpy.data.objects.new("sheaf_camera", self.copy_camera(camera, matrices["camera"],
                                                                                           depsgraph))
        return matrices

    def copy_mesh(self, thing, depsgraph):
        """An object with the evaluated mesh. Instances share their mesh."""
        materials = tuple(slot.material.name if slot.material else "" for slot in thing.material_slots)
        key = (thing.data.as_pointer(), materials) if thing.type == "MESH" else (thing.name, materials)
        if key not in self.meshes:
            # Geometry nodes make objects that only exist during the iteration: their meshes are complete
            is_real = thing.type != "MESH" or thing.data == thing.original.evaluated_get(depsgraph).data
            mesh = bpy.data.meshes.new_from_object(thing, preserve_all_data_layers=is_real, depsgraph=depsgraph)
            self.meshes[key] = mesh
            if not mesh.materials:
                mesh.materials.append(None)
            for k, material in enumerate(mesh.materials):
                if material is None:  # glTF's default is a metal
                    mesh.materials[k] = self.new_material("default", (0.8, 0.8, 0.8, 1))[0]
                else:
                    self.check_material(material)
        mesh = self.meshes[key]
        return bpy.data.objects.new(thing.name, mesh) if mesh.polygons else None

    @staticmethod
    def new_material(name, color):
        """A diffuse material and its inputs."""
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        inputs = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED").inputs
        inputs["Base Color"].default_value = color
        inputs["Specular IOR Level"].default_value = 0
        inputs["Roughness"].default_value = 1
        return material, inputs

    def check_material(self, material):
        """Warns of nodes that glTF cannot express."""
        nodes = material.node_tree.nodes if material.use_nodes else []
        if material.use_nodes and not any(node.type == "BSDF_PRINCIPLED" for node in nodes):
            self.warn(f"material {material.name}: it has no Principled BSDF, so it is only approximated")
        procedural = sorted({node.type for node in nodes if node.type.startswith("TEX_") and node.type != "TEX_IMAGE"})
        if procedural:
            self.warn(f"material {material.name}: {', '.join(procedural)} is ignored; bake it to an image")

    def copy_light(self, thing, matrix):
        """A light, or a mesh that emits its power for lights with an area."""
        light = thing.data
        if light.energy == 0:
            return None
        if light.use_nodes and any(node.type.startswith("TEX_") for node in light.node_tree.nodes):
            self.warn(f"light {thing.name}: its nodes are ignored")
        if light.type == "AREA" or (light.type == "POINT" and self.job["soft_lights"] and light.shadow_soft_size > 0):
            return self.emissive_mesh(thing.name, light, matrix)
        if light.type == "SPOT" and light.shadow_soft_size > 0:
            self.warn(f"light {thing.name}: spot lights have hard shadows; the radius is ignored")
        if light.type == "SUN" and light.angle > math.radians(2):
            self.warn(f"light {thing.name}: suns have hard shadows; the angle is ignored")
        copy = thing.original.data.copy()
        copy.animation_data_clear()
        copy.energy, copy.color = self.power(light), light.color
        return bpy.data.objects.new(thing.name, copy)

    @staticmethod
    def power(light):
        """Power in W, or the irradiance of a sun in W/m2. Blender 4.5 added the exposure."""
        return light.energy * 2.0 ** getattr(light, "exposure", 0.0)

    def emissive_mesh(self, name, light, matrix):
        """A light's surface. Its radiance is P / (pi A), for one side."""
        vertices, triangles = lamp_mesh(light, matrix.to_scale())
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(vertices, [], triangles)
        material, inputs = self.new_material(name, (0, 0, 0, 1))
        material.use_backface_culling = True
        inputs["Emission Color"].default_value = (*light.color, 1)
        inputs["Emission Strength"].default_value = self.power(light) / (math.pi * area_of(vertices, triangles))
        mesh.materials.append(material)
        copy = bpy.data.objects.new(name, mesh)
        copy["sheaf_rigid"] = True
        return copy

    def copy_camera(self, thing, matrix, depsgraph):
        """The camera, whose lens is passed on as custom properties."""
        camera = thing.original.data.copy()
        camera.animation_data_clear()
        evaluated = thing.evaluated_get(depsgraph).data
        if evaluated.type == "PANO":
            raise RenderError(f"camera {thing.name}: panoramic cameras are not supported")
        for name in ("lens", "ortho_scale", "clip_start", "clip_end"):
            setattr(camera, name, getattr(evaluated, name))
        render = self.scene.render
        width, height = render.resolution_x * render.pixel_aspect_x, render.resolution_y * render.pixel_aspect_y
        fit = {"HORIZONTAL": width, "VERTICAL": height}.get(camera.sensor_fit, max(width, height))
        camera["principal_point_offset_x"] = evaluated.shift_x * fit / width
        camera["principal_point_offset_y"] = -evaluated.shift_y * fit / height
        if evaluated.dof.use_dof:
            distance, target = evaluated.dof.focus_distance, evaluated.dof.focus_object
            if target is not None:
                to_target = target.evaluated_get(depsgraph).matrix_world.translation - matrix.translation
                distance = abs(to_target.dot(matrix.col[2].xyz))
            focal = evaluated.lens / 1000 if evaluated.type == "PERSP" else 1.0
            camera["aperture_radius"] = focal / (2 * evaluated.dof.aperture_fstop)
            camera["focus_distance"] = distance
        return camera

    def place(self, placements, middle):
        """Replaces the objects of the scene by their copies. Adds keys at the frames 0, 1 ... to those that move.
        Returns whether there are any."""
        for thing in list(self.scene.objects):
            bpy.data.objects.remove(thing)
        moves = False
        for key, thing in self.objects.items():
            self.scene.collection.objects.link(thing)
            thing.rotation_mode = "QUATERNION"
            matrices = [placements[k].get(key, placements[middle][key]) for k in range(len(placements))]
            if thing.type == "CAMERA" or thing.pop("sheaf_rigid", False):
                matrices = [matrix.normalized() for matrix in matrices]
            if all(matrix == matrices[0] for matrix in matrices):
                thing.matrix_world = matrices[0]
                continue
            moves = True
            self.insert_keys(thing, matrices)
        self.scene.camera = self.objects["camera"]
        return moves

    @staticmethod
    def insert_keys(thing, matrices):
        before = None
        for frame, matrix in enumerate(matrices):
            thing.location, rotation, thing.scale = matrix.decompose()
            if before is not None:
                rotation.make_compatible(before)
            before = thing.rotation_quaternion = rotation
            for path in ("location", "rotation_quaternion", "scale"):
                thing.keyframe_insert(path, frame=frame)

    def export(self, moves, count):
        """Writes the glTF file. With motion, the frame k is the time k in seconds."""
        scene = self.scene
        scene.render.fps, scene.render.fps_base = 1, 1.0
        scene.frame_start, scene.frame_end = 0, max(count - 1, 1)
        scene.frame_set(0)
        animation = {"export_animation_mode": "ACTIVE_ACTIONS", "export_force_sampling": True} if moves else {}
        bpy.ops.export_scene.gltf(
            filepath=self.job["model"], export_format="GLB", use_active_scene=True, export_cameras=True,
            export_lights=True, export_import_convert_lighting_mode="COMPAT", export_extras=True, export_tangents=False,
            export_yup=True, export_animations=moves, export_morph=False, export_skins=False, **animation)
        edit_glb(self.job["model"], complete_materials)

    def bake_world(self):
        """Renders the world with Cycles to an environment map by longitude and latitude. None: it is black."""
        world = self.scene.world
        nodes = world.node_tree.nodes if world.use_nodes else []
        width = 64  # a constant color
        if any(node.type not in {"BACKGROUND", "OUTPUT_WORLD"} for node in nodes):
            images = [node.image.size[0] for node in nodes if node.type == "TEX_ENVIRONMENT" and node.image]
            width = min(max(images, default=1024), 8192)
        if any(node.type.startswith("VOLUME") for node in nodes):
            self.warn("the volume of the world is ignored")
        scene = bpy.data.scenes.new("sheaf_world")
        scene.world = world
        scene.render.engine = "CYCLES"
        scene.frame_set(self.scene.frame_current)
        cycles = scene.cycles  # takes more than 4 samples only where the world varies within a pixel, such as at the sun
        cycles.samples, cycles.use_adaptive_sampling, cycles.adaptive_min_samples = 64, True, 4
        cycles.adaptive_threshold, cycles.use_denoising, cycles.pixel_filter_type = 0.01, False, "BOX"
        camera = bpy.data.cameras.new("sheaf_world")
        camera.type = "PANO"
        owner = camera if hasattr(camera, "panorama_type") else camera.cycles  # Blender 5, Blender 4
        owner.panorama_type = "EQUIRECTANGULAR"
        scene.camera = bpy.data.objects.new("sheaf_world", camera)
        scene.camera.rotation_euler = (math.pi / 2, 0, math.pi)  # as --env expects
        scene.collection.objects.link(scene.camera)
        render = scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, width // 2, 100
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        render.filepath = self.job["environment"]
        bpy.ops.render.render(write_still=True, scene=scene.name)
        bpy.data.scenes.remove(scene)
        return self.job["environment"]


def export(job_file):
    """Entry point of the second Blender. Writes the results beside the job."""
    job = json.loads(Path(job_file).read_text())
    try:
        result = Exporter(job).run()
    except RenderError as error:
        result = {"error": str(error)}
    except Exception as error:  # of Blender's operators and files
        lines = [line for line in str(error).splitlines() if line.strip() and not line.startswith("Location:")]
        result = {"error": f"the scene cannot be exported: {(lines or [type(error).__name__])[-1].strip()}"}
    Path(job["result"]).write_text(json.dumps(result))


# ---- Render engine -------------------------------------------------------------------------------------------------


class SheafEngine(bpy.types.RenderEngine):
    bl_idname = ENGINE
    bl_label = "Sheaf"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True

    def update_render_passes(self, scene, view_layer):
        self.register_pass(scene, view_layer, "Combined", 4, "RGBA", "COLOR")
        for enabled, name, channels, letters, kind in (
                (view_layer.use_pass_z, "Depth", 1, "Z", "VALUE"),
                (view_layer.use_pass_normal, "Normal", 3, "XYZ", "VECTOR"),
                (view_layer.use_pass_position, "Position", 3, "XYZ", "VECTOR"),
                (view_layer.use_pass_diffuse_color, "DiffCol", 3, "RGB", "COLOR")):
            if enabled:
                self.register_pass(scene, view_layer, name, channels, letters, kind)

    def update(self, data, depsgraph):
        """Copies the scene. Blender locks it meanwhile, unlike during render()."""
        scene, render = depsgraph.scene, depsgraph.scene.render
        self.folder = tempfile.mkdtemp(prefix="sheaf_", dir=bpy.app.tempdir)
        camera = self.camera_override or scene.camera
        self.job = {name: os.path.join(self.folder, file) for name, file in (
            ("blend", "scene.blend"), ("model", "scene.glb"), ("environment", "world.exr"), ("image", "image.exr"),
            ("result", "result.json"))}
        self.job |= {"scene": scene.name, "view_layer": depsgraph.view_layer.name,
                     "camera": camera.name if camera else "", "times": shutter_times(render, scene.frame_current_final),
                     "soft_lights": scene.sheaf.soft_lights}
        data.libraries.write(self.job["blend"], {scene.original}, path_remap="ABSOLUTE", fake_user=True)

    def render(self, depsgraph):
        try:
            self.render_image(depsgraph)
        except RenderError as error:
            self.report({"ERROR"}, str(error))
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)

    def render_image(self, depsgraph):
        scene, render = depsgraph.scene, depsgraph.scene.render
        scale = render.resolution_percentage / 100
        size = int(render.resolution_x * scale), int(render.resolution_y * scale)
        window = render_window(render, *size)
        sheaf = find_sheaf(bpy.context.preferences.addons[__name__].preferences.program)
        if not self.job["camera"]:
            raise RenderError("the scene has no camera")
        for unsupported, what in ((render.film_transparent, "transparent film"), (render.use_multiview, "stereoscopy"),
                                  (render.pixel_aspect_x != render.pixel_aspect_y, "pixels that are not square")):
            if unsupported:
                self.report({"WARNING"}, f"Sheaf has no {what}")

        exported = self.export_scene()
        if exported is None:
            return
        result = self.begin_result(0, 0, window[2], window[3], layer=depsgraph.view_layer.name)
        try:
            threads = render.threads if render.threads_mode == "FIXED" else 0
            self.run_sheaf(result, window, render_command(sheaf, scene.sheaf, self.job, exported, size, window, threads))
        finally:
            self.end_result(result)

    def export_scene(self):
        """Exports the scene in a second Blender. None: the user stops it."""
        self.update_stats("", "Exporting the scene")
        job_file = os.path.join(self.folder, "job.json")
        Path(job_file).write_text(json.dumps(self.job))
        program = Program(exporter_command(job_file))
        with contextlib.closing(program):
            while program.wait(0.1):
                if self.test_break():
                    return None
        with contextlib.suppress(FileNotFoundError):
            exported = json.loads(Path(self.job["result"]).read_text())
            if "error" in exported:
                raise RenderError(exported["error"])
            for text in exported["warnings"]:
                self.report({"WARNING"}, text)
            return exported
        raise RenderError(f"the scene cannot be exported: Blender ends with the code {program.process.returncode}")

    def run_sheaf(self, result, window, command):
        """Runs Sheaf, shows the unfinished images and then the final one with its passes."""
        passes = result.layers[0].passes
        server = TevServer()
        with contextlib.closing(server), contextlib.closing(Program([*command, "--tev", server.address])) as program:
            self.update_stats("", "Rendering")
            stops_at = None
            while program.wait(0.1):
                self.update_progress(program.progress)
                image = server.receive(*window)
                if image is not None:
                    passes["Combined"].rect.foreach_set(np.ascontiguousarray(image).ravel())
                    self.update_result(result)
                if stops_at is None and self.test_break():
                    program.stop(signal.SIGINT)  # writes the unfinished image
                    stops_at = time.monotonic() + STOP_SECONDS
                if stops_at is not None and time.monotonic() > stops_at:
                    break
            code = program.process.poll()
        self.report_messages(program.lines, code)
        if not os.path.exists(self.job["image"]):
            if stops_at is not None:
                return
            raise RenderError("Sheaf has written no image")
        for name, values in passes_of(read_exr(self.job["image"])).items():
            if name in passes:
                passes[name].rect.foreach_set(np.ascontiguousarray(values, np.float32).ravel())

    def report_messages(self, lines, code):
        """Shows Sheaf's warnings. Throws its error."""
        texts = [line.removeprefix("sheaf: ") for line in lines if line.startswith("sheaf: ")]
        for text in texts:
            if text.startswith(("warning: ", "note: ")):
                self.report({"WARNING" if text.startswith("warning") else "INFO"}, text.split(": ", 1)[1])
        if code not in (0, None, 128 + signal.SIGINT):
            raise RenderError("Sheaf: " + (texts[-1] if texts else f"exit code {code}"))


# ---- Settings ------------------------------------------------------------------------------------------------------


class SheafPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: bpy.props.StringProperty(name="Program", subtype="FILE_PATH",
                                      description="The program sheaf; empty: from PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


class SheafSettings(bpy.types.PropertyGroup):
    samples: bpy.props.IntProperty(name="Samples", default=64, min=1, max=1 << 20, description="Samples per pixel")
    noise_target: bpy.props.FloatProperty(
        name="Noise Target", default=0, min=0, max=1, precision=3,
        description="Relative standard error at which a tile is finished; 0: all samples. Samples is the maximum")
    seed: bpy.props.IntProperty(name="Seed", default=0, min=0, description="Seed of the random numbers")
    max_depth: bpy.props.IntProperty(name="Maximum Depth", default=-1, min=-1, max=1024,
                                     description="Segments of a path; -1: unlimited, 2: direct light")
    integrator: bpy.props.EnumProperty(name="Integrator", default="path", items=[
        ("path", "Path Tracing", "Paths from the camera"),
        ("direct", "Direct Light", "Emission and direct light"),
        ("ptracer", "Light Tracing", "Paths from the lights"),
        ("photonmapper", "Photon Mapping", "Photon maps with final gathering"),
        ("sppm", "Progressive Photon Mapping", "Stochastic progressive photon mapping"),
        ("ao", "Ambient Occlusion", "Visibility of the surroundings")])
    guiding: bpy.props.EnumProperty(name="Guiding", default="auto", items=[
        ("auto", "Automatic", "Guide paths where the training passes show that it pays"),
        ("on", "On", "Learn the incident radiance and sample directions from it"),
        ("off", "Off", "Sample directions from materials and lights")])
    denoiser: bpy.props.EnumProperty(name="Denoiser", default="none", items=[
        ("none", "None", "No denoising"),
        ("nlm", "Non-Local Means", "Non-local means"),
        ("oidn", "Open Image Denoise", "Open Image Denoise, if Sheaf was built with it")])
    spectral: bpy.props.BoolProperty(name="Spectral", description="Render with wavelengths instead of RGB")
    soft_lights: bpy.props.BoolProperty(
        name="Soft Point Lights", default=True,
        description="Render point lights with a radius as emissive spheres, which are visible to the camera")
    lenient: bpy.props.BoolProperty(name="Lenient", description="Drop or replace what Sheaf cannot read")
    options: bpy.props.StringProperty(name="Options", description="Further options of sheaf render")


class SheafRenderPanel(bpy.types.Panel):
    bl_idname = "RENDER_PT_sheaf"
    bl_label = "Sheaf"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE

    def draw(self, context):
        self.layout.use_property_split = True
        for name in SheafSettings.__annotations__:
            self.layout.prop(context.scene.sheaf, name)


class SheafPassesPanel(bpy.types.Panel):
    bl_idname = "VIEWLAYER_PT_sheaf_passes"
    bl_label = "Passes"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "view_layer"
    poll = SheafRenderPanel.poll

    def draw(self, context):
        self.layout.use_property_split = True
        for name, text in (("use_pass_z", "Depth"), ("use_pass_normal", "Normal"), ("use_pass_position", "Position"),
                           ("use_pass_diffuse_color", "Albedo")):
            self.layout.prop(context.view_layer, name, text=text)


CLASSES = (SheafPreferences, SheafSettings, SheafEngine, SheafRenderPanel, SheafPassesPanel)


def shared_panels():
    """Blender's own panels that suit every engine, such as those of the film's size, of lights and of materials."""
    excluded = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}
    for panel in bpy.types.Panel.__subclasses__():
        if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__ not in excluded:
            yield panel


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.sheaf = bpy.props.PointerProperty(type=SheafSettings)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    del bpy.types.Scene.sheaf
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


if __name__ == "__main__":
    if "--" in sys.argv:
        export(sys.argv[-1])
    else:
        register()
