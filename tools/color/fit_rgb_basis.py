#!/usr/bin/env python3
"""Fits the basis spectra that represent linear Rec.709 colors: the table in scene/data/rgb_basis.cpp. Needs numpy and
scipy.

Follows Mallett and Yuksel ("Spectral Primary Decomposition for Rendering with sRGB Reflectance", 2019): three spectra
in [0, 1] that sum to 1 at every wavelength and have the colors red, green and blue under D65. Among all piecewise
linear solutions, the script finds the smoothest, which minimizes the sum of squared second differences.

  tools/color/fit_rgb_basis.py [--step 10]
"""

import argparse
import re
from pathlib import Path

import numpy as np
from scipy.optimize import lsq_linear

SOURCE = (Path(__file__).resolve().parents[2] / "core/color/color.cpp").read_text()
WAVELENGTHS = np.linspace(360, 830, 471)
TO_REC709 = np.array([[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556],
                      [0.055648, -0.204043, 1.057311]])


def curve(name):
    """Returns a table of core/color/color.cpp, interpolated at WAVELENGTHS."""
    numbers = re.search(r"constexpr Curve " + name + r"\{(.*?)\};", SOURCE, re.DOTALL).group(1)
    return np.interp(WAVELENGTHS, np.arange(360, 831, 5), [float(n) for n in re.findall(r"[-\d.e]+(?=f)", numbers)])


def basis(step):
    """Returns the knots, the three spectra at the knots, and the color of each hat function."""
    knots = np.arange(360, 831, step)
    n = len(knots)
    hats = np.array([np.interp(WAVELENGTHS, knots, row) for row in np.eye(n)])
    response = TO_REC709 @ np.array([curve("kCieX"), curve("kCieY"), curve("kCieZ")]) * curve("kD65")
    response /= response.sum(1, keepdims=True)
    seen = response @ hats.T  # color of each hat
    smooth = np.diff(np.eye(n), 2, axis=0)
    zeros, strict = np.zeros((n, n)), 1e5
    rows, goals = [], []
    for k in range(3):
        rows.append(np.hstack([smooth if j == k else 0 * smooth for j in range(3)]))
        goals.append(np.zeros(n - 2))
        rows.append(strict * np.hstack([seen if j == k else 0 * seen for j in range(3)]))
        goals.append(strict * np.eye(3)[k])
    rows.append(strict * np.hstack([np.eye(n)] * 3))
    goals.append(strict * np.ones(n))
    found = lsq_linear(np.vstack(rows), np.concatenate(goals), bounds=(0, 1), tol=1e-14, max_iter=2000, method="bvls")
    return knots, found.x.reshape(3, n), seen


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--step", type=int, default=10, help="knot spacing in nm")
    knots, spectra, seen = basis(parser.parse_args().step)
    print("colors of the spectra:\n", np.round(seen @ spectra.T, 5).T)
    print("smallest", spectra.min(), "largest sum", spectra.sum(0).max())
    for name, values in zip(("red", "blue"), (spectra[0], spectra[2])):
        print(name + ":", ", ".join(f"{abs(v):.6f}f" for v in values))


if __name__ == "__main__":
    main()
