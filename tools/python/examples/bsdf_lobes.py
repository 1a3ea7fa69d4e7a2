#!/usr/bin/env python3
"""Plots the lobes of a metal in the plane of incidence for several roughnesses, and the albedo by angle. Needs Matplotlib.

  python3 bsdf_lobes.py lobes.png
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np

import sheaf


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output")
    parser.add_argument("--samples", type=int, default=20000, help="of the albedo, for each angle")
    arguments = parser.parse_args()

    scene = sheaf.load_dict({"type": "scene", "camera": {"type": "perspective"}, "sky": {"type": "constant"},
                             "gold": {"type": "roughconductor", "material": "Au", "alpha": 0.1},
                             "ball": {"type": "sphere", "bsdf": {"type": "ref", "id": "gold"}}})
    angles = np.radians(np.linspace(-90, 90, 361))
    wi = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
    wo = np.array([-np.sin(np.radians(30)), 0, np.cos(np.radians(30))])
    incidence = np.radians(np.linspace(0, 85, 18))

    figure = plt.figure(figsize=(9, 4))
    lobes, albedo = figure.add_subplot(121, projection="polar"), figure.add_subplot(122)
    for alpha in (0.1, 0.2, 0.4):
        scene.materials["gold"].alpha = alpha
        gold = sheaf.bsdf(scene, "gold")
        lobes.plot(angles, gold.evaluate(wo, wi)[:, 1], label=f"alpha = {alpha}")
        # The mean weight of samples is the directional albedo
        means = [gold.sample((np.sin(a), 0, np.cos(a)), count=arguments.samples).weight[:, 1].mean() for a in incidence]
        albedo.plot(np.degrees(incidence), means, label=f"alpha = {alpha}")
    lobes.set(title="f cos, light from -30°", theta_zero_location="N", theta_direction=-1, thetamin=-90, thetamax=90)
    albedo.set(title="directional albedo", xlabel="angle of incidence, degrees", ylim=(0, 1))
    albedo.legend()
    figure.tight_layout()
    figure.savefig(arguments.output)


if __name__ == "__main__":
    main()
