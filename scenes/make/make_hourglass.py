#!/usr/bin/env python3
"""Writes the meshes, textures and grids of scenes/hourglass: an hourglass on a table by a window, with an iceberg that
melts onto a city. Needs Python with numpy and a build; the output is deterministic. Lengths in cm; y is up.

  scenes/make/make_hourglass.py [--make-cloud PROGRAM]

make_cloud is taken from build/release, where tools/quickstart.sh builds it, or else from PATH, where an installed
package has it.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np

from hourglass_city import RADIUS, ground_height, make_city
from hourglass_furniture import make_frame, make_room, make_table
from hourglass_meshes import Mesh, grid_triangles, profile_normals, revolved, spline, surface
from hourglass_textures import fractal, make_book, make_brass, make_environment, make_paper, make_snow, make_wood
from make_media_scenes import find_make_cloud

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "hourglass" / "generated"

# Inner wall of the lower bulb as radius and height, from the bottom to the neck. The upper bulb mirrors it.
BULB = [(0.0, 2.0), (1.4, 2.01), (2.8, 2.12), (4.45, 2.75), (5.45, 4.2), (5.8, 6.0), (5.52, 7.8), (4.55, 9.4),
        (3.1, 10.62), (1.7, 11.4), (0.82, 11.86), (0.5, 12.3)]
NECK = 12.3
THICKNESS = 0.26
SIDES = 320
MENISCUS = 0.09
LAKE = 15.2  # water level in the upper bulb
FLOOD = 4.12  # water level in the lower bulb
STREETS = 4.10  # height of the city's ground level
SUN = (-0.55, 0.34, -0.77)

# Peaks of the iceberg, also under water, relative to the center of its waterline: summit, slope of the sides in
# degrees, number of facets.
PEAKS = [((0.55, 5.4, -0.1), 15, 9), ((-1.75, 3.9, 0.6), 15, 8), ((1.8, 3.2, 0.4), 18, 8), ((0.7, 2.0, 2.3), 25, 7),
         ((-0.8, 1.9, -2.4), 28, 7), ((-2.75, 1.3, 1.2), 32, 7), ((1.9, 0.9, -1.3), 40, 7),
         ((0.3, -2.5, 0.0), -22, 9), ((-1.1, -1.6, -0.5), -30, 8), ((1.2, -1.2, 0.8), -35, 8)]


def inner_wall():
    half = spline(BULB, 14)
    return np.vstack([half, (half * (1, -1) + (0, 2 * NECK))[::-1][1:]])


def cut(profile, normals, height):
    """Splits a profile and its normals at the first point that reaches `height`; both parts get that point."""
    k = int(np.argmax(profile[:, 1] >= height))
    t = (height - profile[k - 1, 1]) / (profile[k, 1] - profile[k - 1, 1])
    point, normal = ((a[k - 1] + t * (a[k] - a[k - 1]))[None] for a in (profile, normals))
    rest = k + 1 if t > 1 - 1e-9 else k
    return ((np.vstack([profile[:k], point]), np.vstack([normals[:k], normal])),
            (np.vstack([point, profile[rest:]]), np.vstack([normal, normals[rest:]])))


def distance_to_plane(directions, normal, distance):
    """Distance from the origin along unit directions to the plane with this normal; large where they do not meet it."""
    facing = directions @ normal
    return np.where(facing > 1e-3, distance / np.maximum(facing, 1e-3), 1e9)


def peak_radius(directions, summit, slope, facets, rng):
    """Distance from the center of the waterline to the surface of a convex peak, bounded by planes."""
    radius = np.full(directions.shape[:-1], 1e9)
    # The sides meet near the summit
    for k in range(facets):
        azimuth = 2 * np.pi * (k + rng.uniform(-0.3, 0.3)) / facets
        t = np.radians(slope) * rng.uniform(0.6, 1.35)
        normal = np.array([np.cos(azimuth) * np.cos(t), np.sin(t), np.sin(azimuth) * np.cos(t)])
        distance = max(normal @ summit, 0.35) * rng.uniform(0.9, 1.1) + (0.15 if k % 2 else 0.4)
        radius = np.minimum(radius, distance_to_plane(directions, normal, distance))
    # The top is truncated, and the other end lies just beyond the waterline
    ends = rng.uniform(-0.35, 0.35, (2, 3))
    ends[:, 1] = np.sign(summit[1]) * np.array([1, -1])
    for normal, distance in zip(ends, (ends[0] @ summit * rng.uniform(0.92, 0.98), 0.7)):
        radius = np.minimum(radius, distance_to_plane(directions, normal, distance))
    return radius


def iceberg_radius(directions, wall):
    """Distance from the center of the waterline to the surface: a union of peaks, worn by noise, inside the bulb."""
    rng = np.random.default_rng(11)
    radius = np.full(directions.shape[:-1], 0.3)
    for peak in PEAKS:
        radius = np.maximum(radius, peak_radius(directions, *peak, rng))
    # Wear: ridges, runnels of melting water, and small bumps
    x, y, z = np.moveaxis(directions * radius[..., None], -1, 0)
    ridges = 1 - np.abs(2 * fractal(0.8 * x, 0.8 * y, 0.8 * z, octaves=4, seed=100) - 1)
    runnels = fractal(2.2 * x, 0.5 * y, 2.2 * z, octaves=3, seed=110)
    fine = fractal(5 * x, 5 * y, 5 * z, octaves=3, seed=120)
    radius = radius - 0.30 * (1 - ridges) - 0.30 * (runnels - 0.5) - 0.10 * (fine - 0.5)
    # Keep away from the glass
    bulb = wall[wall[:, 1] >= NECK]
    angle = np.arctan2(bulb[:, 1] - LAKE, bulb[:, 0])
    reach = np.interp(np.arcsin(directions[..., 1]), angle, np.hypot(bulb[:, 0], bulb[:, 1] - LAKE))
    return np.minimum(radius, 0.80 * reach)


def make_iceberg(wall, rows=180):
    """Writes the parts of the iceberg above and below the water. Returns the ring of points between them."""
    elevation = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * rows + 1)
    azimuth = np.linspace(0, 2 * np.pi, SIDES + 1)
    phi, theta = np.meshgrid(elevation, azimuth, indexing="ij")
    directions = np.stack([np.cos(phi) * np.cos(theta), np.sin(phi), -np.cos(phi) * np.sin(theta)], -1)
    directions[rows, :, 1] = 0
    directions[0], directions[-1] = (0, -1, 0), (0, 1, 0)
    directions[:, -1] = directions[:, 0]
    radius = iceberg_radius(directions, wall)
    radius[0], radius[-1] = radius[0].mean(), radius[-1].mean()
    points = directions * radius[..., None] + (0, LAKE, 0)
    whole = surface(points).agreeing()
    normals = whole.normals.reshape(points.shape)
    uvs = whole.uvs.reshape(2 * rows + 1, SIDES + 1, 2)
    for name, part in (("ice_below", slice(0, rows + 1)), ("ice_above", slice(rows, 2 * rows + 1))):
        Mesh(points[part], normals[part], uvs[part], grid_triangles(rows + 1, SIDES + 1)).write(FOLDER / f"{name}.ply")
    make_snow(FOLDER, points, normals)
    return points[rows]


def water_surface(inner, radius, level, rows, seed, waves):
    """Water between the ring `inner` and the wall, whose contact line is `MENISCUS` above the level."""
    angle = np.linspace(0, 2 * np.pi, SIDES + 1)
    outer = np.stack([radius * np.cos(angle), np.zeros(SIDES + 1), -radius * np.sin(angle)], -1)
    outer[-1] = outer[0]
    t = (1 - np.linspace(1, 0, rows)**2)[:, None, None]
    points = inner + t * (outer - inner) * (1, 0, 1)
    distance = radius - np.hypot(points[..., 0], points[..., 2])
    height = waves * (fractal(1.1 * points[..., 0], 1.1 * points[..., 2], octaves=3, seed=seed) - 0.5)
    height = height * np.sin(np.pi * t[..., 0])**0.5
    points[..., 1] = level + height + MENISCUS * np.exp(-distance / 0.16)
    points[0] = inner
    points[0, :, 1] = level
    points[-1, :, 1] = level + MENISCUS
    points[:, -1] = points[:, 0]
    return surface(points).flipped()


def make_glass():
    """Writes the glass, the water and the ice. The boundaries of glass, water and air meet in shared rings of points.

    Normals point out of the glass, and out of the water into the air.
    """
    wall = inner_wall()
    normals = profile_normals(wall)
    outside = wall + THICKNESS * normals
    outside[0, 0] = outside[-1, 0] = 0
    revolved(outside, SIDES).write(FOLDER / "glass_outer.ply")
    (flood, flood_n), (rest, rest_n) = cut(wall, normals, FLOOD + MENISCUS)
    (below, below_n), (rest, rest_n) = cut(rest, rest_n, NECK)
    (lake, lake_n), (above, above_n) = cut(rest, rest_n, LAKE + MENISCUS)
    for name, profile, n in (("glass_flood", flood, flood_n), ("glass_below", below, below_n),
                             ("glass_lake", lake, lake_n), ("glass_above", above, above_n)):
        revolved(profile, SIDES, n).flipped().write(FOLDER / f"{name}.ply")
    ring = make_iceberg(wall)
    water_surface(ring, lake[-1, 0], LAKE, 60, 130, 0.05).write(FOLDER / "lake.ply")
    center = np.zeros((SIDES + 1, 3)) + (0, FLOOD, 0)
    water_surface(center, flood[-1, 0], FLOOD, 120, 140, 0.045).write(FOLDER / "flood.ply")
    pendant = spline([(0.0, 11.28), (0.16, 11.31), (0.31, 11.45), (0.37, 11.68), (0.38, 11.9), (0.43, 12.12),
                      (0.5, NECK)], 8)
    revolved(pendant, SIDES).write(FOLDER / "pendant.ply")
    drop = spline([(0.0, -0.20), (0.12, -0.165), (0.195, -0.05), (0.17, 0.09), (0.09, 0.22), (0.03, 0.30),
                   (0.0, 0.32)], 8)
    revolved(drop, 48).write(FOLDER / "drop.ply")


def make_island():
    """Writes the ground under the city, and the cliffs from its shore down to the bottom of the bulb."""
    radii = np.linspace(0, RADIUS, 90)
    ground = np.stack([radii, STREETS + ground_height(radii, 0)], -1)
    edge = ground[-1]
    cliff = spline([edge, edge + (0.12, -0.16), (4.35, 3.45), (3.5, 3.05), (2.6, 2.75), (2.2, 2.3), (0.0, 2.2)], 24)[1:]
    revolved(ground[::-1], SIDES).write(FOLDER / "streets.ply")
    mesh = revolved(np.vstack([edge, cliff])[::-1], SIDES)
    p = mesh.positions
    rough = fractal(*(1.6 * p.T), octaves=5, seed=150) - 0.5
    strata = np.sin(14 * p[:, 1] + 4 * fractal(0.7 * p[:, 0], 0.7 * p[:, 2], octaves=3, seed=160))
    depth = np.clip(3 * (edge[1] - p[:, 1]), 0, 1)
    p += mesh.normals * (depth * (0.5 * rough - 0.09 + 0.035 * strata))[:, None]
    mesh.smoothed().write(FOLDER / "cliffs.ply")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make-cloud", default=find_make_cloud())
    arguments = parser.parse_args()
    if not Path(arguments.make_cloud).is_file():
        parser.error(f"no program {arguments.make_cloud}: build it, or say --make-cloud where it is")
    FOLDER.mkdir(parents=True, exist_ok=True)
    make_glass()
    make_island()
    make_city(FOLDER, (0.0, 0.0), STREETS, 24)
    for name, profile, seed in make_frame(FOLDER):
        make_brass(FOLDER, name, profile, seed)
    make_room(FOLDER)
    make_wood(FOLDER, *make_table(FOLDER), 22)
    make_paper(FOLDER)
    make_book(FOLDER)
    make_environment(FOLDER / "environment.pfm", SUN)
    for seed, name in ((4, "cloud_left"), (9, "cloud_right")):
        subprocess.run([arguments.make_cloud, str(FOLDER / f"{name}.nvdb"), "--resolution", "112", "--seed", str(seed)],
                       check=True)


if __name__ == "__main__":
    main()
