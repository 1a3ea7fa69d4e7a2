#!/usr/bin/env python3
"""Renders every scene and every part of a scene in the documentation: blocks of the language `xml` or `pbrt`.

  tests/docs/check_snippets.py --sheaf build/release/sheaf [--keep FOLDER] [PAGE...]

Parts are completed to scenes: a <bsdf> on a mesh, a <texture> in a material, a <sampler> in a sensor, and so on. Files
that they name are generated. The parts on the page nori.md are completed in that dialect. Photons are reduced, images
are tiny. A comment <!-- not tested: REASON --> directly above a block excludes it.
Exit status: 0 all rendered, 1 something failed; each failure names the file and line of the block.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path

import assets
from documents import Failures, blocks, pages

PHOTONS = "1000"
# Sensors that prescribe the size of the film.
METERS = ("radiancemeter", "distant", "irradiancemeter")
# Plugins that belong into shapes.
AREA_LIGHTS = ("area", "directionalarea")
# Volumes of media that need another volume beside them are parts of this medium.
GRID = '<volume type="gridvolume" name="sigma_t"><string name="filename" value="completed.vol"/></volume>'
LOOK_AT = '<transform name="{name}"><lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>'
PLY = '<string name="filename" value="completed.ply"/>'


def element(tag, kind, *children, **attributes):
    """The text of an element."""
    given = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return f'<{tag} type="{kind}"{given}>' + "".join(children) + f"</{tag}>"


def text_of(part):
    return ET.tostring(part, encoding="unicode").strip()


def diffuse(*children):
    return element("bsdf", "diffuse", *children)


def holder_of(part, albedo):
    """The material or light that holds a texture or spectrum of this name."""
    name, text = part.get("name"), text_of(part)
    if name in ("radiance", "irradiance"):
        return None, text
    if name in ("reflectance", "albedo"):
        return diffuse(text.replace(f'name="{name}"', f'name="{albedo}"')), None
    if name == "opacity":
        return element("bsdf", "mask", text, diffuse()), None
    return element("bsdf", "principled", text), None


class Mitsuba:
    """A scene of Mitsuba around the parts in a block."""

    def __init__(self, parts):
        self.before, self.top, self.sensor = [], [], []
        self.film, self.has = [], {part.tag for part in parts}
        self.version = "3.0.0"
        for part in parts:
            getattr(self, "add_" + part.tag, self.add_top)(part)

    def add_top(self, part):
        self.top.append(text_of(part))

    def add_default(self, part):
        self.before.append(text_of(part))

    def add_bsdf(self, part):
        self.add_shape_with(text_of(part))

    def add_shape_with(self, *children):
        self.has.add("shape")
        self.top.append(element("shape", "ply", PLY, *children))

    def add_texture(self, part):
        material, radiance = holder_of(part, "reflectance")
        self.add_shape_with(material or element("emitter", "area", radiance))

    add_spectrum = add_rgb = add_blackbody = add_texture

    def add_shape(self, part):
        if part.get("type") == "irradiancemeter" or part.find("sensor") is not None:
            self.has.add("sensor")
        self.top.append(text_of(part))
        if part.get("type") == "shapegroup":
            self.top.append(element("shape", "instance", f'<ref id="{part.get("id")}"/>'))
        group = part.find("ref") if part.get("type") == "instance" else None
        if group is not None:
            self.before.append(element("shape", "shapegroup", element("shape", "sphere"), id=group.get("id")))

    def add_emitter(self, part):
        if part.get("type") in AREA_LIGHTS:
            self.add_shape_with(text_of(part))
        else:
            self.top.append(text_of(part))

    def add_medium(self, part):
        self.add_top(part)
        if "shape" not in self.has:
            self.has.add("shape")
            inside = f'<ref name="interior" id="{part.get("id")}"/>'
            self.top.append(element("shape", "sphere", element("bsdf", "null"), inside))

    def add_volume(self, part):
        if part.get("name") == "density":
            self.version = "0.6.0"
        others = "" if part.get("name") in ("sigma_t", "density") else GRID
        self.add_medium(ET.fromstring(element("medium", "heterogeneous", text_of(part), others, id="completed")))

    def add_phase(self, part):
        self.add_medium(ET.fromstring(element("medium", "homogeneous", text_of(part), id="completed")))

    def add_sensor(self, part):
        self.sensor.append(text_of(part))

    def add_transform(self, part):
        self.add_shape_with(text_of(part))

    def add_film(self, part):
        self.film.append(text_of(part))

    def add_sampler(self, part):
        self.film.append(text_of(part))

    def add_rfilter(self, part):
        self.film.append(element("film", "hdrfilm", text_of(part)))

    def text(self):
        rest = []
        if "sensor" not in self.has:
            rest.append(element("sensor", "perspective", LOOK_AT.format(name="to_world"), *self.film))
        if "integrator" not in self.has:
            rest.append(element("integrator", "path"))
        if "shape" not in self.has:
            rest.append(element("shape", "sphere"))
        if "emitter" not in self.has:
            rest.append(element("emitter", "constant"))
        opening = f'<scene version="{self.version}">'
        return "\n".join([opening, *self.before, *self.sensor, *rest, *self.top, "</scene>"])


class Nori:
    """A scene of Nori around the parts in a block."""

    def __init__(self, parts):
        self.top, self.camera = [], ""
        self.has = {part.tag for part in parts}
        for part in parts:
            getattr(self, "add_" + part.tag, self.add_top)(part)

    def add_top(self, part):
        self.top.append(text_of(part))

    add_shape = add_top

    def add_mesh_with(self, *children):
        self.has.add("mesh")
        self.top.append(element("mesh", "ply", PLY, *children))

    def add_bsdf(self, part):
        self.add_mesh_with(text_of(part))

    def add_texture(self, part):
        material, radiance = holder_of(part, "albedo")
        self.add_mesh_with(material or element("emitter", "area", radiance))

    def add_emitter(self, part):
        if part.get("type") == "area":
            self.add_mesh_with(text_of(part))
        else:
            self.add_top(part)

    def add_medium(self, part):
        self.add_mesh_with(text_of(part))

    def add_phase(self, part):
        self.add_mesh_with(element("medium", "homogeneous", text_of(part)))

    def add_rfilter(self, part):
        self.camera = text_of(part)

    def text(self):
        rest = []
        if "camera" not in self.has:
            rest.append(element("camera", "perspective", LOOK_AT.format(name="toWorld"), self.camera))
        if "integrator" not in self.has:
            rest.append(element("integrator", "path"))
        if "mesh" not in self.has:
            rest.append(element("mesh", "sphere"))
        if "emitter" not in self.has:
            rest.append(element("emitter", "constant"))
        return "\n".join(["<scene>", *rest, *self.top, "</scene>"])


def with_few_photons(part):
    """Reduces the photons of an integrator, or sets them if it has the default number."""
    for integrator in part.iter("integrator"):
        if not re.search("photon|ppm", integrator.get("type", "")):
            continue
        given = {re.sub("_", "", each.get("name", "")).lower(): each for each in integrator}
        for name, each in given.items():
            if name.endswith(("photoncount", "photons")) and name != "mediumphotons":
                each.set("value", PHOTONS)
        if not {"photoncount", "globalphotons"} & given.keys():
            ET.SubElement(integrator, "integer", name="photonCount", value=PHOTONS)
    return part


def complete_xml(block):
    """The scene for a block of XML, and whether a sensor prescribes the size of its film."""
    # Several elements may stand side by side.
    root = ET.fromstring(f"<block>{re.sub(r'<[?].*?[?]>', '', block.text)}</block>")
    parts = [with_few_photons(part) for part in root]
    sized = any(each.get("type") in METERS for each in root.iter("sensor"))
    if [part.tag for part in parts] == ["scene"]:
        return text_of(parts[0]), sized
    dialect = Nori if block.page.stem == "nori" else Mitsuba
    return dialect(parts).text(), sized


def complete_pbrt(block):
    if "WorldBegin" in block.text:
        return block.text
    before = r"^\s*(Camera|Film|PixelFilter|Sampler|Integrator|Option|Accelerator|ColorSpace|LookAt)\b"
    world = "" if re.match(before, block.text) else "WorldBegin\n"
    rest = "" if world else "WorldBegin\n"
    return f'{world}{block.text}\n{rest}LightSource "infinite" "float scale" 1\nShape "sphere"\n'


def render(block, folder, build):
    """Renders a block. Returns the reason of the failure, or nothing."""
    folder.mkdir()
    try:
        if block.language == "pbrt":
            scene, text, sized = folder / "scene.pbrt", complete_pbrt(block), False
        else:
            scene = folder / "scene.xml"
            text, sized = complete_xml(block)
    except ET.ParseError as error:
        return f"is not XML: {error}"
    scene.write_text(text)
    for name in re.findall(r'"([\w./-]+\.[a-z]+)"', text.replace("$frame4", "0001")):
        if not assets.write(folder, name, text, build):
            return f"names the file {name}, of a format that tests/docs/assets.py does not know"
    command = [build / "sheaf", "render", scene, "-o", folder / "image.exr", "--stats", folder / "stats.json",
               "--spp", "1", "--threads", "1", "--quiet", *([] if sized else ["--size", "12x8"])]
    done = subprocess.run(command, check=False, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode != 0:
        return f"exit status {done.returncode}\n{done.stdout}{text}"
    dropped = json.loads((folder / "stats.json").read_text())["dropped"]
    return f"samples were dropped: {dropped}\n{text}" if any(dropped.values()) else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheaf", type=lambda p: Path(p).resolve(), required=True, help="its folder has make_cloud")
    parser.add_argument("--keep", type=Path, help="keep the completed scenes in this folder")
    parser.add_argument("pages", nargs="*", type=lambda p: Path(p).resolve(), help="default: all documents")
    arguments = parser.parse_args()
    failures = Failures()
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(cpu_count()) as pool:
        found = [block for page in arguments.pages or pages() for block in blocks(page)
                 if block.language in ("xml", "pbrt")]
        skipped = [block for block in found if block.skip]
        tested = [block for block in found if not block.skip]
        folders = [Path(temporary) / f"{block.page.stem}_{block.line}" for block in tested]
        for block, failure in zip(tested, pool.map(render, tested, folders, [arguments.sheaf.parent] * len(tested))):
            if failure:
                failures.add(block.place, failure)
        if arguments.keep:
            shutil.copytree(temporary, arguments.keep, dirs_exist_ok=True)
    for block in skipped:
        print(f"left out {block.place}: {block.skip}")
    print(f"{len(tested)} blocks rendered, {len(skipped)} left out, {failures.count} failed")
    if not tested:
        failures.add("docs", "no block found")
    sys.exit(1 if failures.count else 0)


if __name__ == "__main__":
    main()
