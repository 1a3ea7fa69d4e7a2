"""Makes, converts, writes and reads images."""

import numpy as np

import sheaf.mitsuba as mi  # Mitsuba: import mitsuba as mi

mi.set_variant("scalar_rgb")

x, y = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 48))
bitmap = mi.Bitmap(np.stack([x, y, 0.25 + 0 * x], axis=2).astype(np.float32))
print(bitmap.width(), bitmap.height(), bitmap.channel_count(), bitmap.srgb_gamma())

encoded = bitmap.convert(pixel_format=mi.Bitmap.PixelFormat.RGB, component_format=mi.Struct.Type.UInt8, srgb_gamma=True)
encoded.write("gradient.png")
bitmap.write("gradient.exr")

again = mi.Bitmap("gradient.png")
assert np.array_equal(np.array(again), np.array(encoded))
gray = again.convert(pixel_format=mi.Bitmap.PixelFormat.Y, component_format=mi.Struct.Type.Float32, srgb_gamma=False)
gray.write("gray.exr")
np.save("gray.npy", np.array(gray)[..., 0] if np.ndim(gray) == 3 else np.array(gray))
