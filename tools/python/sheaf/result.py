"""Images with layers, and what can be done with them."""

import json
import os
from typing import Any, Dict, List, Optional, Sequence, Union

import numpy as np

from ._native import native
from .errors import UsageError, converted_errors
from .options import values

_AOVS = {name: channels for name, channels in native.aovs()}


class Result:
    """An image with layers, in linear colors. Arrays are views of its memory."""

    def __init__(self, image):
        self._native = image

    @property
    def image(self) -> np.ndarray:
        """float32, H x W x 4: R, G, B and A, premultiplied. Gray images and images without alpha are completed."""
        rgba = self._native.array(["R", "G", "B", "A"])
        if rgba is not None:
            return rgba
        color = self._native.array(["R", "G", "B"])
        if color is None:
            gray = self._native.array(self._native.channels[:1])
            color = np.repeat(gray[..., None], 3, axis=2)
        return np.concatenate([color, np.ones_like(color[..., :1])], axis=2)

    @property
    def layers(self) -> List[str]:
        """The names of the layers, for `result[name]`."""
        channels = set(self._native.channels)
        names = [name for name, needed in _AOVS.items() if channels.issuperset(needed)]
        covered = {"R", "G", "B", "A", *(channel for name in names for channel in _AOVS[name])}
        for channel in self._native.channels:
            layer = channel.rsplit(".", 1)[0]
            if channel not in covered and layer not in names:
                names.append(layer)
        return names

    def __getitem__(self, name: str) -> np.ndarray:
        channels = self._native.channels
        if name in channels:
            return self._native.array([name])
        needed = _AOVS.get(name)
        if needed is None or not set(needed) <= set(channels):
            needed = [channel for channel in channels if channel.startswith(name + ".")]
            parts = [channel[len(name) + 1:] for channel in needed]
            if set(parts) >= {"R", "G", "B"}:
                needed = [f"{name}.{part}" for part in ("R", "G", "B")]
        if not needed:
            raise KeyError(f"the image has no layer '{name}' ({', '.join(self.layers) or 'it has none'})")
        return self._native.array(needed)

    def __contains__(self, name: str) -> bool:
        try:
            self[name]
        except KeyError:
            return False
        return True

    @property
    def variance(self) -> Optional[np.ndarray]:
        """float32, H x W x 3: the variance of the pixel's mean. None if unknown."""
        return self._native.array(_AOVS["variance"])

    @property
    def stats(self) -> Dict[str, Any]:
        """The content of `--stats`, and under "kept" what the render took over from the one before."""
        stats = json.loads(self._native.stats) if self._native.stats else {}
        stats["kept"] = {"scene": self._native.kept_scene, "acceleration_structure": self._native.kept_accel}
        return stats

    @property
    def attributes(self) -> Dict[str, Any]:
        """The attributes of the OpenEXR header."""
        return self._native.attributes

    @property
    def warnings(self) -> List[str]:
        """Messages about the scene and the render."""
        return self._native.warnings

    @property
    def interrupted(self) -> bool:
        """Whether the render ended early."""
        return self._native.interrupted

    def write(self, file, **options: Any) -> None:
        """Writes .exr with all layers, or .png, .jpg or .tif. options: see sheaf.options("write")."""
        given = values("write", options)
        with converted_errors():
            self._native.write(os.fspath(file), given)

    def png(self, **options: Any) -> bytes:
        """The image as a PNG file. options: see sheaf.options("write")."""
        with converted_errors():
            return self._native.png(values("write", options))

    def _repr_png_(self) -> bytes:
        return self.png()

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return np.array(self.image, dtype=dtype) if copy or dtype is not None else self.image

    def _pixels(self) -> np.ndarray:
        """For textures: linear colors, of one or three channels."""
        found = self._native.array(["R", "G", "B"])
        return self._native.array(self._native.channels[:1]) if found is None else found

    def __getstate__(self) -> tuple:
        return self._native.state()

    def __setstate__(self, state: tuple) -> None:
        with converted_errors():
            self._native = native.Image.from_state(state)

    def __repr__(self) -> str:
        return f"<sheaf.Result {self._native.width} x {self._native.height}, layers: {', '.join(self.layers)}>"


def read_image(file) -> Result:
    """Reads an image file of any format. Values are as stored; 8-bit values are divided by 255."""
    with converted_errors():
        return Result(native.read(os.fspath(file)))


def _result(image) -> Result:
    if isinstance(image, Result):
        return image
    if isinstance(image, (str, os.PathLike)):
        return read_image(image)
    values = np.asarray(image)
    if values.dtype.kind not in "fiu":
        raise UsageError(f"an array of {values.dtype}, expected numbers")
    with converted_errors():
        return Result(native.Image.from_array(values[..., None] if values.ndim == 2 else values))


def compare(a, b, significance: float = 0.01) -> Dict[str, Any]:
    """Differences between an image and a reference `b`: results, files or arrays H x W x C.

    Keys: mse, relative_mse, mean_a, mean_b, mean_ratio, non_finite, channels, width, height; with variances also
    accepted, mean_z_squared and mean_p of the Z-test.
    """
    if not 0 < significance < 1:
        raise UsageError(f"significance is {significance}, expected a number between 0 and 1")
    with converted_errors():
        return _result(a)._native.compare(_result(b)._native, significance)


def denoise(result, method: str = "nlm", threads: int = 0) -> Result:
    """Denoises an image; returns it with the layer `denoised`. method: "nlm" or "oidn"."""
    with converted_errors():
        return Result(_result(result)._native.denoise(method, threads))


def merge(parts: Sequence[Union[Result, str]], crop: Optional[Sequence[int]] = None,
          incomplete: bool = False) -> Result:
    """Merges parts of an image that were rendered with `crop` or `samples`: results or files."""
    with converted_errors():
        return Result(native.merge([_result(part)._native for part in parts], list(crop or []), incomplete))
