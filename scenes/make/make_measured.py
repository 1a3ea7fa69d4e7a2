#!/usr/bin/env python3
"""Writes measured materials in the format of the RGL database to scenes/materials/generated: metallic facets below a
transparent film, whose interference colors depend on the angle. Needs numpy; the output is deterministic.

  scenes/make/make_measured.py

The parameterization is that of Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and
Rendering" (2018): reflectances are tabulated over the random numbers that sample the visible normals.
"""

import struct
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "materials" / "generated"
ALPHA = 0.3  # roughness of the facets (GGX)
FILMS = {"beetle": 290.0, "copper_green": 395.0, "violet": 480.0}  # thickness in nm
FILM_IOR = 1.6
THETA = np.linspace(0, 1.5, 12)
SIDE, SAMPLES = 32, 24  # grid sizes of the normals and of the reflectances
WAVELENGTHS = np.linspace(400, 700, 25)


def directions(side):
    """Unit vectors on a grid with elevation pi x^2 / 2 and azimuth (2 y - 1) pi; x is the last axis but one."""
    x, y = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side))
    return direction(0.5 * np.pi * x * x, (2 * y - 1) * np.pi), x


def direction(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def ndf(m):
    """The GGX distribution of normals."""
    s = (m[..., 0]**2 + m[..., 1]**2) / ALPHA**2 + m[..., 2]**2
    return np.where(m[..., 2] > 0, 1 / (np.pi * ALPHA**2 * s * s), 0)


def masking(w):
    """Smith's masking."""
    z = np.maximum(w[..., 2], 1e-6)
    return 2 / (1 + np.sqrt(1 + ALPHA**2 * (w[..., 0]**2 + w[..., 1]**2) / z**2)) * (w[..., 2] > 0)


def reflectance(cosine, thickness):
    """The reflectance of the film, with the wavelengths on the first axis."""
    inside = np.sqrt(1 - (1 - cosine**2) / FILM_IOR**2)
    phase = 4 * np.pi * FILM_IOR * thickness * inside / WAVELENGTHS.reshape(-1, *[1] * cosine.ndim)
    grazing = (1 - cosine)**5
    return grazing + (1 - grazing) * (0.10 + 0.75 * (0.5 - 0.5 * np.cos(phase))**2)


def invert_integral(a, b, area):
    """The x in [0, 1] up to which the integral of a line from a to b is `area`."""
    slope = b - a
    root = np.sqrt(max(a * a + 2 * slope * area, 0))
    return min(max(2 * area / (a + root), 0), 1) if a + root > 0 else 0.5


def sample_grid(values, u, v):
    """A point of [0, 1]^2 with the bilinear density `values`: its row by v, then its column by u."""
    size = len(values) - 1
    totals = np.concatenate([np.zeros((size + 1, 1)), np.cumsum((values[:, 1:] + values[:, :-1]) / 2, axis=1)], axis=1)
    rows = totals[:, -1]
    marginal = np.concatenate([[0], np.cumsum((rows[1:] + rows[:-1]) / 2)])
    target = v * marginal[-1]
    row = min(max(int(np.searchsorted(marginal, target, side="right")) - 1, 0), size - 1)
    y = invert_integral(rows[row], rows[row + 1], target - marginal[row])
    line, density = ((1 - y) * grid[row] + y * grid[row + 1] for grid in (totals, values))
    target = u * line[-1]
    column = min(max(int(np.searchsorted(line, target, side="right")) - 1, 0), size - 1)
    x = invert_integral(density[column], density[column + 1], target - line[column])
    return (column + x) / size, (row + y) / size


def tabulate(thickness):
    """Returns {field: array} of a material."""
    normals, x = directions(SIDE)
    sine = np.hypot(normals[..., 0], normals[..., 1])
    vndf, luminance, spectra = [], [], []
    for theta in THETA:
        wo = direction(theta, 0.0)
        vndf.append(ndf(normals) * np.maximum(normals @ wo, 0) * x * sine)
        places = np.array([[sample_grid(vndf[-1], i / (SAMPLES - 1), j / (SAMPLES - 1)) for i in range(SAMPLES)]
                           for j in range(SAMPLES)])
        m = direction(0.5 * np.pi * places[..., 0]**2, (2 * places[..., 1] - 1) * np.pi)
        cosine = np.clip(m @ wo, 0, 1)
        wi = 2 * cosine[..., None] * m - wo
        spectra.append(masking(wi) * reflectance(cosine, thickness))
        luminance.append(spectra[-1].mean(axis=0))
    fine, _ = directions(2 * SIDE)
    sigma = np.where(fine[..., 2] > 1e-6, fine[..., 2] / np.maximum(masking(fine), 1e-9), 0.5 * ALPHA)
    return {"phi_i": np.zeros(1), "theta_i": THETA, "ndf": ndf(fine), "sigma": sigma, "vndf": np.array([vndf]),
            "luminance": np.array([luminance]), "spectra": np.array([spectra]), "wavelengths": WAVELENGTHS}


def write_tensors(path, fields):
    """Writes a tensor file: a header with the fields' names, shapes and offsets, then their numbers."""
    entries = [(name, 10, values.shape, values.astype("<f4").tobytes()) for name, values in fields.items()]
    entries += [("jacobian", 1, (1,), b"\x01"), ("description", 1, (4,), b"film")]
    offset = 18 + sum(13 + len(name) + 8 * len(shape) for name, _, shape, _ in entries)
    head, body = b"tensor_file\0\x01\x00" + struct.pack("<I", len(entries)), b""
    for name, kind, shape, data in entries:
        head += struct.pack(f"<H{len(name)}sHBQ", len(name), name.encode(), len(shape), kind, offset + len(body))
        head += struct.pack(f"<{len(shape)}Q", *shape)
        body += data
    path.write_bytes(head + body)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, thickness in FILMS.items():
        write_tensors(FOLDER / f"{name}.bsdf", tabulate(thickness))


if __name__ == "__main__":
    main()
