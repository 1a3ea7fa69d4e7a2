"""Scene-file elements as text, shared by the scripts that write scenes."""


def camera(origin, target, fov, width, height):
    """Returns a perspective sensor with y up and $spp samples per pixel."""
    return f"""  <sensor type="perspective">
    <transform name="to_world">
      <lookat origin="{origin}" target="{target}" up="0, 1, 0"/>
    </transform>
    <float name="fov" value="{fov}"/>
    <film type="hdrfilm">
      <integer name="width" value="{width}"/>
      <integer name="height" value="{height}"/>
      <rfilter type="gaussian"/>
    </film>
    <sampler type="independent">
      <integer name="sample_count" value="$spp"/>
    </sampler>
  </sensor>
"""


def sensor(origin, target, fov, width, height, spp=128):
    return f"""  <default name="spp" value="{spp}"/>
  <integrator type="path"/>
""" + camera(origin, target, fov, width, height)


def write_scene(path, title, script, *parts):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {title} Written by scenes/make/{script}. -->\n'
                    '<scene version="3.0.0">\n' + "".join(parts) + "</scene>\n")
