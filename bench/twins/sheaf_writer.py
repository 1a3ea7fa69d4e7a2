"""Writes a twin scene for Sheaf and Mitsuba: scene.xml, a PLY file for each mesh, and the sky as a Radiance file."""

import hashlib

import numpy as np

from twins.scene import HEIGHT, MAX_DEPTH, WIDTH, Diffuse, Glass, Metal, PointLight, QuadLight

# Local axes of environment maps (y is up, the left edge of the image is at -z) to those of the scene.
SKY_TO_WORLD = [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]


def ply(mesh):
    """The bytes of a binary PLY file."""
    vertices, triangles = mesh
    faces = np.zeros(len(triangles), dtype=[("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, triangles
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\n"
              f"property float y\nproperty float z\nelement face {len(triangles)}\n"
              "property list uchar int vertex_indices\nend_header\n")
    return header.encode() + np.asarray(vertices, "<f4").tobytes() + faces.tobytes()


def radiance_hdr(pixels):
    """The bytes of an uncompressed Radiance file (RGBE)."""
    mantissa, exponent = np.frexp(np.maximum(pixels.max(axis=2), 1e-30))
    factor = mantissa * 256 / np.maximum(pixels.max(axis=2), 1e-30)
    rgbe = np.concatenate([pixels * factor[..., None], exponent[..., None] + 128], axis=2)
    height, width = pixels.shape[:2]
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + rgbe.astype(np.uint8).tobytes()


def numbers(values):
    return " ".join(f"{x:.9g}" for x in np.ravel(values))


def rgb(name, color):
    return f'<rgb name="{name}" value="{", ".join(f"{x:.9g}" for x in color)}"/>'


def matrix(values):
    return f'<transform name="to_world"><matrix value="{numbers(values)}"/></transform>'


def bsdf(name, material):
    if isinstance(material, Diffuse):
        return (f'<bsdf type="twosided" id="{name}"><bsdf type="diffuse">{rgb("reflectance", material.color)}</bsdf>'
                "</bsdf>")
    if isinstance(material, Metal):
        return (f'<bsdf type="twosided" id="{name}"><bsdf type="roughconductor">'
                f'<string name="distribution" value="ggx"/><float name="alpha" value="{material.alpha}"/>'
                f'{rgb("eta", material.eta)}{rgb("k", material.k)}</bsdf></bsdf>')
    assert isinstance(material, Glass)
    return (f'<bsdf type="dielectric" id="{name}"><float name="int_ior" value="{material.ior}"/>'
            '<float name="ext_ior" value="1"/></bsdf>')


def light(lamp):
    if isinstance(lamp, PointLight):
        return (f'<emitter type="point"><point name="position" value="{numbers(lamp.position)}"/>'
                f'{rgb("intensity", lamp.intensity)}</emitter>')
    assert isinstance(lamp, QuadLight)
    normal = np.cross(lamp.u, lamp.v)
    columns = np.column_stack([lamp.u, lamp.v, normal / np.linalg.norm(normal), lamp.center])
    return (f'<shape type="rectangle">{matrix(np.vstack([columns, [0, 0, 0, 1]]))}<bsdf type="diffuse">'
            f'{rgb("reflectance", (0, 0, 0))}</bsdf><emitter type="area">{rgb("radiance", lamp.radiance)}</emitter>'
            "</shape>")


def shapes(scene):
    """The objects; meshes with several of them become shape groups with instances."""
    for name, (_, material) in scene.meshes.items():
        mesh = (f'<string name="filename" value="{name}.ply"/><boolean name="face_normals" value="true"/>'
                f'<ref id="{material}"/>')
        if scene.count(name) > 1:
            yield f'<shape type="shapegroup" id="{name}-group"><shape type="ply">{mesh}</shape></shape>'
            mesh = f'<ref id="{name}-group"/>'
        kind = "instance" if scene.count(name) > 1 else "ply"
        for where in (m for of_mesh, m in scene.objects if of_mesh == name):
            yield f'<shape type="{kind}">{mesh}{matrix(where)}</shape>'


def fog_lines(fog):
    center, half = (np.add(fog.high, fog.low) / 2, np.subtract(fog.high, fog.low) / 2)
    placement = np.diag([*half, 1])
    placement[:3, 3] = center
    return [f'<medium type="homogeneous" id="fog">{rgb("sigma_s", [fog.scattering] * 3)}'
            f'{rgb("sigma_a", [fog.absorption] * 3)}<phase type="isotropic"/></medium>',
            f'<shape type="cube">{matrix(placement)}<bsdf type="null"/><ref name="interior" id="fog"/></shape>']


def scene_lines(scene):
    kind = "volpath" if scene.fog else "path"
    yield '<scene version="3.0.0">'
    yield f'<default name="width" value="{WIDTH}"/> <default name="height" value="{HEIGHT}"/>'
    yield (f'<integrator type="{kind}"><integer name="max_depth" value="{MAX_DEPTH}"/>'
           f'<boolean name="hide_emitters" value="{str(scene.hides_lights).lower()}"/></integrator>')
    yield (f'<sensor type="perspective"><float name="fov" value="{scene.fov}"/><transform name="to_world">'
           f'<lookat origin="{numbers(scene.eye)}" target="{numbers(scene.target)}" up="0 0 1"/></transform>'
           '<film type="hdrfilm"><integer name="width" value="$width"/><integer name="height" value="$height"/>'
           '<rfilter type="box"/></film><sampler type="independent"/></sensor>')
    if scene.has_sky:
        yield f'<emitter type="envmap"><string name="filename" value="sky.hdr"/>{matrix(SKY_TO_WORLD)}</emitter>'
    elif scene.environment:
        yield f'<emitter type="constant">{rgb("radiance", scene.environment)}</emitter>'
    yield from (bsdf(name, material) for name, material in scene.materials.items())
    yield from shapes(scene)
    yield from (light(lamp) for lamp in scene.lights)
    if scene.fog:
        yield from fog_lines(scene.fog)
    yield "</scene>"


def write(scene, folder):
    """Writes the files of a scene to a folder and returns the scene file. Its comment depends on all other files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {f"{name}.ply": ply(mesh) for name, (mesh, _) in scene.meshes.items()}
    if scene.has_sky:
        files["sky.hdr"] = radiance_hdr(scene.environment)
    digest = hashlib.sha256()
    for name, data in files.items():
        digest.update(data)
        (folder / name).write_bytes(data)
    lines = [f"<!-- Written by bench/make_twins.py; digest of the other files {digest.hexdigest()[:16]} -->",
             *scene_lines(scene)]
    (folder / "scene.xml").write_text("\n".join(lines) + "\n")
    return folder / "scene.xml"
