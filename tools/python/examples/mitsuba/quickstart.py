"""Renders the Cornell box and writes an image."""

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")

scene = mi.load_dict(mi.cornell_box())
image = mi.render(scene, spp=64)
mi.util.write_bitmap("quickstart.png", image)
mi.util.write_bitmap("quickstart.exr", image)
