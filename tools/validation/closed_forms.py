"""Closed forms of the radiance in some scenes of scenes/validation. They repeat the numbers of the scene files, except
the camera, and average over points of each pixel."""

import math
import re

import numpy as np

POINTS = 4  # per side of a pixel


def numbers(text):
    return np.array([float(v) for v in text.replace(",", " ").split()])


def camera_rays(scene, quick_scale):
    """Yields the origin and the directions (height x width x 3) of rays through each of POINTS^2 points of a pixel."""
    text = scene.read_text()
    if scene.suffix == ".pbrt":
        look = numbers(re.search(r"LookAt (.*)", text)[1])
        origin, target, up = look[:3], look[3:6], look[6:]
        width, height, fov = (float(re.search(rf'"\w+ {name}" (\d+)', text)[1])
                              for name in ("xresolution", "yresolution", "fov"))
        # pbrt measures the field of view along the shorter side.
        tangent = math.tan(math.radians(fov) / 2) * width / min(width, height)
    else:
        origin, target, up = (numbers(re.search(rf'{name}="([^"]*)"', text)[1]) for name in ("origin", "target", "up"))
        width, height, fov = (float(re.search(rf'name="{name}" value="(\d+)"', text)[1])
                              for name in ("width", "height", "fov"))
        tangent = math.tan(math.radians(fov) / 2)
    width, height = round(width * quick_scale), round(height * quick_scale)
    forward = normalized(target - origin)
    right = normalized(np.cross(forward, up))
    above = np.cross(right, forward)
    if scene.suffix == ".pbrt":
        right = -right  # pbrt's coordinates are left-handed
    for i in range(POINTS**2):
        x = (np.arange(width) + (i % POINTS + 0.5) / POINTS) / width * 2 - 1
        y = (np.arange(height) + (i // POINTS + 0.5) / POINTS) / height * 2 - 1
        x, y = x[None, :, None] * tangent, -y[:, None, None] * tangent * height / width
        yield origin, normalized(forward + x * right + y * above)


def normalized(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def render(radiance, scene, quick_scale=1):
    """Averages radiance(origin, directions) over the points of each pixel."""
    return np.mean([radiance(origin, directions) for origin, directions in camera_rays(scene, quick_scale)], axis=0)


def chord(origin, directions, center, radius):
    """Length of each ray inside of a sphere, with one channel."""
    offset = origin - center
    middle = (directions * offset).sum(axis=-1, keepdims=True)
    return 2 * np.sqrt(np.maximum(middle**2 - (offset**2).sum(axis=-1, keepdims=True) + radius**2, 0))


def null_ball(origin, directions):
    """Beer's law: a constant environment of radiance 1 behind an absorbing ball."""
    return np.exp(-2.5 * np.array([0.08, 0.36, 1]) * chord(origin, directions, np.zeros(3), 1))


def emission(origin, directions):
    """An emissive ball without scattering above a diffuse floor: Le (1 - exp(-sigma_a s)) along a chord s. The
    irradiance on the floor is an integral over the angle to the middle of the ball."""
    center, radius, reflectance = np.array([0, 1.2, 0]), 0.8, 0.6
    sigma, source = np.array([0.4, 0.8, 1.6]), np.array([4, 2.2, 1.2])
    transmitted = np.exp(-sigma * chord(origin, directions, center, radius))
    distances = np.linspace(0, 14, 400)
    lit = np.array([floor_irradiance(d, center[1], radius, sigma, source) for d in distances]) * reflectance / math.pi
    t = -origin[1] / np.minimum(directions[..., 1], -1e-9)
    points = origin + t[..., None] * directions
    is_floor = (directions[..., 1] < 0) & (np.abs(points[..., [0, 2]]).max(axis=-1) < 8)
    r = np.linalg.norm(points[..., [0, 2]], axis=-1)
    floor = np.stack([np.interp(r, distances, lit[:, c]) for c in range(3)], axis=-1) * is_floor[..., None]
    return source * (1 - transmitted) + transmitted * floor


def floor_irradiance(r, height, radius, sigma, source):
    """Irradiance on the floor at a distance of r from below the ball."""
    distance = math.hypot(r, height)
    edge = math.asin(radius / distance)
    theta = (np.arange(400) + 0.5) / 400 * edge
    length = 2 * np.sqrt(radius**2 - (distance * np.sin(theta)) ** 2)
    radiance = source * (1 - np.exp(-sigma * length[:, None]))
    weights = 2 * math.pi * np.cos(theta) * np.sin(theta) * edge / 400
    return height / distance * (radiance * weights[:, None]).sum(axis=0)


def spot_smooth(origin, directions):
    """A spot light whose intensity is a smooth step in the cosine, on a diffuse floor of half width 6."""
    light, target, reflectance = np.array([-1.2, 2, 0.8]), np.array([0.1, 0, 0]), 0.6
    intensity, total, start = np.array([10, 8, 6]), math.cos(math.radians(32)), math.cos(math.radians(10))
    t = -origin[1] / np.minimum(directions[..., 1:2], -1e-9)
    points = origin + t * directions
    away = points - light
    squared = (away**2).sum(axis=-1, keepdims=True)
    away = away / np.sqrt(squared)
    s = np.clip(((away * normalized(target - light)).sum(axis=-1, keepdims=True) - total) / (start - total), 0, 1)
    is_floor = (directions[..., 1:2] < 0) & (np.abs(points[..., [0, 2]]).max(axis=-1, keepdims=True) < 6)
    return is_floor * reflectance / math.pi * intensity * s * s * (3 - 2 * s) * -away[..., 1:2] / squared
