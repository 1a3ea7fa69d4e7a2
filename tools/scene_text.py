"""What the programs that write scenes have in common: elements of a scene file, as text."""


def camera(origin, target, fov, width, height):
    """A sensor with the y axis up that takes $spp samples per pixel."""
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
