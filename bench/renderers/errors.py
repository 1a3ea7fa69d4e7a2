"""Errors of images against a reference, and the efficiency of renderers."""

import hashlib
import json
from dataclasses import dataclass
from statistics import mean, median

import numpy as np

REFERENCE_SEEDS = (1001, 1002)
OUTLIERS = 0.001  # share of pixel values that the relative error leaves out
MAX_MEAN_DIFFERENCE = 0.005
MAX_BIAS_SHARE = 0.1


@dataclass(frozen=True)
class Reference:
    """Two independent renders by Sheaf with many samples per pixel."""
    a: np.ndarray
    b: np.ndarray

    @property
    def mean(self):
        return (self.a + self.b) / 2

    @property
    def scale(self):
        """Divisor of squared errors in the relative error."""
        return self.mean**2 + 0.01 * self.mean.mean() ** 2 + 1e-9


def render_reference(sheaf, scene, spp, threads, folder):
    """Renders a reference, or reads that of an earlier run of the same scene file and settings."""
    key = json.dumps([scene.file.read_text(errors="replace"), scene.defines, spp, list(sheaf.options), REFERENCE_SEEDS])
    path = folder / f"{scene.name}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz"
    if not path.exists():
        halves = [sheaf.render(scene, spp, seed, threads).images[0] for seed in REFERENCE_SEEDS]
        folder.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name("incomplete.npz")
        np.savez(temporary, halves=np.array(halves, dtype=np.float32))
        temporary.rename(path)
    with np.load(path) as stored:
        return Reference(*stored["halves"].astype(float))


def trimmed_mean(values):
    """Mean without the largest values."""
    values = np.sort(values.ravel())
    return float(values[:max(1, int(len(values) * (1 - OUTLIERS)))].mean())


@dataclass(frozen=True)
class Errors:
    """mse, relative: one value per process. mean_ratio: mean of the images over that of the reference;
    mean_uncertainty: its standard error. is_own: measured against the renderer's own mean, because it converges to
    another image than the reference."""
    mse: list
    relative: list
    mean_ratio: float
    mean_uncertainty: float
    is_own: bool

    def differs_by(self, limit):
        """Whether the mean is off by more than a limit, and not by chance."""
        return abs(self.mean_ratio - 1) > max(limit, 3 * self.mean_uncertainty)


def measure_errors(renders, reference, is_own=None):
    """Errors of the renders of one renderer. `is_own`: None decides by the images."""
    images = [image for render in renders for image in render.images]
    if images[0].shape != reference.a.shape:
        raise ValueError(f"the image has {images[0].shape[1]} x {images[0].shape[0]} pixels instead of "
                         f"{reference.a.shape[1]} x {reference.a.shape[0]}")
    means = np.array([image.mean() for image in images]) / reference.mean.mean()
    uncertainty = float(means.std(ddof=1) / len(means) ** 0.5) if len(means) > 1 else float("inf")
    # A product of differences from two independent references is free of their noise.
    against = [(image - reference.a) * (image - reference.b) for image in images]
    own = squares_from_mean(images)
    if is_own is None:
        is_own = own is not None and differs(float(means.mean()), uncertainty, against, own)
    if is_own and own is None:
        raise ValueError("an error against the renderer's own mean needs two images")
    # Images are trimmed one by one, so that the number of images per process does not matter.
    squares = iter(own if is_own else against)
    per_image = [[(float(s.mean()), trimmed_mean(s / reference.scale)) for s in (next(squares) for _ in render.images)]
                 for render in renders]
    mse, relative = np.array([np.mean(of_process, axis=0) for of_process in per_image]).T.tolist()
    return Errors(mse, relative, float(means.mean()), uncertainty, is_own)


def squares_from_mean(images):
    """Squared differences from the mean of the other images, scaled to the squared error of each; None for one."""
    if len(images) < 2:
        return None
    count, total = len(images), np.sum(images, axis=0)
    return [(count - 1) / count * (image - (total - image) / (count - 1)) ** 2 for image in images]


def differs(mean_ratio, uncertainty, against, own):
    """Whether images converge to another image than the reference: by their mean, or if a part of their error against
    the reference is not noise."""
    if abs(mean_ratio - 1) > max(MAX_MEAN_DIFFERENCE, 3 * uncertainty):
        return True
    error, noise = np.mean(against), np.mean(own)
    return bool(error - noise > MAX_BIAS_SHARE * noise)


@dataclass(frozen=True)
class Measurement:
    """Renders of one scene by one renderer at equal settings, one per round, and their errors.
    first_process_seconds: of the first process, which is not among the renders."""
    program: str
    renders: list
    errors: Errors
    first_process_seconds: float | None = None

    def times(self, which="seconds"):
        return [getattr(render, which) for render in self.renders]

    def time(self, which="seconds"):
        return median(self.times(which))

    @property
    def mse(self):
        return mean(self.errors.mse)

    @property
    def peak_bytes(self):
        return max(self.times("peak_bytes"))


@dataclass(frozen=True)
class Ratio:
    """A ratio of two renderers: from all rounds, and the extremes of single rounds."""
    value: float
    low: float
    high: float

    def __str__(self):
        return f"{figure(self.value)} ({figure(self.low)} to {figure(self.high)})"


def figure(value):
    """Two significant digits."""
    return f"{value:.0f}" if value >= 99.5 else f"{value:.2g}" if value >= 9.95 else f"{value:.1f}"


def time_ratios(ours, other, which):
    """Times of the other renderer over ours, by rounds, since programs that disturb one round disturb both."""
    return [b / a for a, b in zip(ours.times(which), other.times(which))]


def speed_ratio(ours, other, which="seconds"):
    """Time of the other renderer over ours."""
    rounds = time_ratios(ours, other, which)
    return Ratio(median(rounds), min(rounds), max(rounds))


def efficiency_ratio(ours, other, error="mse", which="seconds"):
    """Error times time of the other renderer over ours: the factor by which it takes longer to the same error."""
    a, b = getattr(ours.errors, error), getattr(other.errors, error)
    times = time_ratios(ours, other, which)
    rounds = [eb / ea * time for ea, eb, time in zip(a, b, times)]
    return Ratio(mean(b) / mean(a) * median(times), min(rounds), max(rounds))
