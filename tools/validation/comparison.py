"""Compares two images with known variances by errors and by Welch's t-test over blocks of pixels."""

import math
from dataclasses import dataclass

import numpy as np

BLOCK = 16  # pixels per side


@dataclass(frozen=True)
class Image:
    """A rendered or computed image.

    pixels: linear Rec. 709, height x width x 3, at the samples per pixel of the case; the page shows it.
    mean: the best estimate of the expectation; `pixels`, or the mean of several runs.
    variance: of `mean` per value, from `replicates` sets; None if unknown. 0 for closed forms.
    renders: number of renders like `pixels` that make up `mean`.
    seconds: CPU time of `pixels`; None for closed forms.
    """
    pixels: np.ndarray
    mean: np.ndarray
    variance: np.ndarray | None
    replicates: int = 1
    renders: int = 1
    seconds: float | None = None

    def rows(self, begin, end):
        """The part between two lines."""
        variance = None if self.variance is None else self.variance[begin:end]
        return Image(self.pixels[begin:end], self.mean[begin:end], variance, self.replicates,
                     self.renders, self.seconds)


@dataclass(frozen=True)
class Measures:
    """mean_ratio: of the means over frame and channels. relative_mse: mean of (a - b)^2 / (b^2 + 0.01) of the images.
    expected_mse: the same as the variances predict it. largest_z: quantile of the normal distribution for the smallest
    p-value of all blocks. p: this p-value times the number of tests (Bonferroni), at most 1. The last three are None
    without variances."""
    mean_ratio: float
    relative_mse: float
    expected_mse: float | None = None
    largest_z: float | None = None
    p: float | None = None


def compare(a, b, tolerance, block=BLOCK):
    """Compares image `a` with the reference `b`. The test ignores relative differences below `tolerance`."""
    scale = b.mean**2 + 0.01
    ratio = a.mean.mean() / b.mean.mean()
    error = float(np.mean((a.pixels - b.pixels) ** 2 / scale))
    if a.variance is None or b.variance is None:
        return Measures(ratio, error)
    tests = list(block_tests(a, b, tolerance, block))
    smallest = min(p for p, _ in tests)
    z = max(z for _, z in tests)
    expected = float(np.mean((a.variance * a.renders + b.variance * b.renders) / scale))
    return Measures(ratio, error, expected, z, min(1.0, len(tests) * smallest))


def block_tests(a, b, tolerance, block):
    """Yields the p-value and the equivalent |z| of Welch's test, for each channel of each block and of the frame.
    `block`: pixels per side. Blocks must receive enough light of few bright samples to estimate its variance."""
    height, width, channels = a.mean.shape
    lines, columns = np.arange(0, height, block), np.arange(0, width, block)

    def sums(values):
        return np.add.reduceat(np.add.reduceat(values, lines, axis=0), columns, axis=1).reshape(-1, channels)

    count = sums(np.ones_like(a.mean))
    parts = [sums(v) for v in (a.mean - b.mean, b.mean, a.variance, b.variance, a.variance**2, b.variance**2)]
    frame = [part.sum(axis=0, keepdims=True) for part in [count, *parts]]
    for size, difference, reference, va, vb, wa, wb in zip(*(np.vstack(pair).ravel() for pair in
                                                            zip([count, *parts], frame))):
        # Differences of single precision are no evidence.
        margin = tolerance * abs(reference) + 1e-6 * size
        excess = max(abs(difference) - margin, 0.0)
        variance = va + vb
        if excess == 0 or variance == 0:
            yield (1.0, 0.0) if excess == 0 else (0.0, math.inf)
            continue
        # Welch and Satterthwaite: degrees of freedom of a sum of variances that are estimated themselves.
        spread = wa / max(a.replicates - 1, 1) + wb / max(b.replicates - 1, 1)
        p = student_p(excess / math.sqrt(variance), variance**2 / spread)
        yield p, normal_quantile(p)


def student_p(t, freedom):
    """Two-sided p-value of Student's t-distribution."""
    return incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t))


def normal_quantile(p):
    """|z| with a two-sided p-value of p, by bisection."""
    low, high = 0.0, 40.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if math.erfc(middle / math.sqrt(2)) > p else (low, middle)
    return low


def incomplete_beta(a, b, x):
    """Regularized incomplete beta function I_x(a, b) by its continued fraction (Lentz's method)."""
    if x <= 0 or x >= 1:
        return float(x >= 1)
    if x > (a + 1) / (a + b + 2):
        return 1 - incomplete_beta(b, a, 1 - x)
    front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)) / a
    tiny = 1e-300
    c, d = 1.0, 1 / (1 - (a + b) * x / (a + 1))
    value = d
    for m in range(1, 1000):
        for numerator in (m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                          -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))):
            d = 1 / ((1 + numerator * d) or tiny)
            c = (1 + numerator / c) or tiny
            value *= c * d
        if abs(c * d - 1) < 1e-12:
            break
    return front * value
