#!/usr/bin/env python3
"""Fits the wavelength density of spectral mode: the table in core/color/wavelengths.cpp. Needs numpy and scipy.

The objective is color noise: the variance of red, green and blue over the squared luminance for paths with 4
stratified wavelengths. It is summed over the illuminants D65, A and equal energy (E) and averaged over smooth
reflectances, which are sigmoids of quadratic polynomials with random coefficients, as in spectral uplifting. The same
variance for a single wavelength, the case after dispersion, is added with weight 0.01.

  tools/color/fit_wavelengths.py [--colors 24] [--iterations 100]
"""

import argparse
import re
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

SOURCE = (Path(__file__).resolve().parents[2] / "core/color/color.cpp").read_text()
WAVELENGTHS = np.linspace(360, 830, 2351)
KNOTS = np.arange(360, 831, 10)
TO_REC709 = np.array([[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556],
                      [0.055648, -0.204043, 1.057311]])


def curve(name):
    """Returns a table of core/color/color.cpp, interpolated at WAVELENGTHS."""
    numbers = re.search(r"constexpr Curve " + name + r"\{(.*?)\};", SOURCE, re.DOTALL).group(1)
    return np.interp(WAVELENGTHS, np.arange(360, 831, 5), [float(n) for n in re.findall(r"[-\d.e]+(?=f)", numbers)])


XYZ = np.array([curve("kCieX"), curve("kCieY"), curve("kCieZ")])
RESPONSE = TO_REC709 @ XYZ
LIGHTS = {"D65": curve("kD65"), "A": WAVELENGTHS**-5 / (np.exp(1.435e7 / (2848 * WAVELENGTHS)) - 1), "E": np.ones(2351)}


def reflectances(count, seed=1):
    """Returns white and random reflectances, without nearly black ones."""
    generator, found = np.random.default_rng(seed), [np.ones(2351)]
    t = (WAVELENGTHS - 360) / 470
    while len(found) < count:
        a, b, c = generator.normal(size=3) * [8, 8, 3]
        x = (a * t + b) * t + c
        reflectance = 0.5 + x / (2 * np.sqrt(1 + x * x))
        if (XYZ[1] * reflectance).sum() > 0.05 * XYZ[1].sum():
            found.append(reflectance)
    return np.array(found)


def noise(density, colors, count=512):
    """Returns, per illuminant: variance of white and mean over all colors with 4 wavelengths, and that mean with 1."""
    steps = (density[1:] + density[:-1]) / 2 * np.diff(WAVELENGTHS)
    cumulative = np.concatenate([[0], np.cumsum(steps)])
    drawn = np.interp((np.arange(count) + 0.5) / count * cumulative[-1], cumulative, WAVELENGTHS)
    at = lambda values: np.interp(drawn, WAVELENGTHS, values)
    pdf, response, y = at(density) / cumulative[-1], np.array([at(c) for c in RESPONSE]), at(XYZ[1])
    seen, result = np.array([at(r) for r in colors]), []
    for light in LIGHTS.values():
        power = at(light) / pdf
        luminance = (seen * y * power).mean(1)
        one = seen[:, None, :] * response * power
        four = one.reshape(len(seen), 3, 4, count // 4).mean(2)
        variances = [(each.var(2).sum(1) / luminance**2) for each in (four, one)]
        result.append((variances[0][0], variances[0].mean(), variances[1].mean()))
    return np.array(result)


def by_knots(logarithms):
    return np.interp(WAVELENGTHS, KNOTS, np.exp(logarithms))


def show(name, density):
    values = noise(density, reflectances(200, 2), 4096)
    columns = (f"  {n:3} {v[0]:7.4f} {v[1]:7.4f} {v[2]:6.2f}" for n, v in zip(LIGHTS, values))
    print(f"{name:28}" + "".join(columns), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--colors", type=int, default=24, help="number of reflectances in the average")
    parser.add_argument("--iterations", type=int, default=100, help="maximum number of iterations")
    arguments = parser.parse_args()
    print("density; per illuminant: variance of white, mean over colors, mean with a single wavelength")
    for center in (538, 520):
        show(f"1 / cosh^2 around {center} nm", np.cosh(0.0072 * (WAVELENGTHS - center)) ** -2)
    length = np.linalg.norm(RESPONSE, axis=0)
    show("length of the response", length)
    show("its square root", np.sqrt(length))
    colors = reflectances(arguments.colors)

    def cost(logarithms):
        values = noise(by_knots(logarithms), colors)
        return values[:, 1].sum() + 0.01 * values[:, 2].mean()

    start = np.log(np.interp(KNOTS, WAVELENGTHS, np.sqrt(length)))
    found = minimize(cost, start, method="L-BFGS-B", options={"maxiter": arguments.iterations}).x
    table = np.exp(found - found.max())
    show("the table", np.interp(WAVELENGTHS, KNOTS, np.round(table, 4)))
    print(", ".join(f"{v:.4f}f" for v in table))


if __name__ == "__main__":
    main()
