#!/usr/bin/env python3
"""Renders views from random places with depth, normals and object numbers, for computer vision. Each view becomes a PNG
file and a .npz file with the arrays depth (H x W, meters along the optical axis, 0: nothing), normal (H x W x 3, world
space), object (H x W, exact numbers of the pixel centers), and camera (4 x 4, camera to world, +z forwards).

  python3 dataset.py views --count 100
"""

from pathlib import Path

import numpy as np

import common
import sheaf


def pixel_directions(matrix, width, height, fov):
    """World-space directions through the centers of the pixels, H * W x 3. `fov`: horizontal, degrees."""
    x = (1 - 2 * (np.arange(width) + 0.5) / width) * np.tan(np.radians(fov / 2))
    y = (1 - 2 * (np.arange(height) + 0.5) / height) * np.tan(np.radians(fov / 2)) * height / width
    local = np.stack([*np.meshgrid(x, y), np.ones((height, width))], axis=-1)
    return local.reshape(-1, 3) @ matrix[:3, :3].T


def main():
    parser = common.parser(__doc__, 32, (128, 96))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=100, help="number of views")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()

    arguments.folder.mkdir(parents=True, exist_ok=True)
    scene, random = common.still_life(), np.random.default_rng(arguments.seed)
    width, height = arguments.size
    for view in range(arguments.count):
        camera = common.look_from(random.uniform(0, 360), random.uniform(5, 60), random.uniform(6, 9))
        scene.camera.to_world = camera
        result = sheaf.render(scene, spp=arguments.spp, size=arguments.size, aovs=["depth", "normal"], denoise="nlm")
        # Objects have no mean over a pixel: trace its center
        matrix = np.array(camera.matrix, dtype=float)
        hits = sheaf.trace(scene, matrix[:3, 3], pixel_directions(matrix, width, height, scene.camera.fov))
        result.write(arguments.folder / f"view_{view:04}.png")
        np.savez_compressed(arguments.folder / f"view_{view:04}.npz", depth=result["depth"], normal=result["normal"],
                            object=hits.object.reshape(height, width), camera=matrix)
    print(f"wrote {arguments.count} views to {arguments.folder}; objects: {', '.join(hits.object_names)}")


if __name__ == "__main__":
    main()
