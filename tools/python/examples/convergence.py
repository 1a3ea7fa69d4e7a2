#!/usr/bin/env python3
"""Plots the error of renders by their samples per pixel for two samplers. Needs Matplotlib.

  python3 convergence.py convergence.png
"""

import matplotlib.pyplot as plt

import common
import sheaf


def main():
    parser = common.parser(__doc__, 256, (96, 72))
    parser.add_argument("output")
    parser.add_argument("--reference-spp", type=int, default=4096)
    arguments = parser.parse_args()

    scene = common.still_life()
    reference = sheaf.render(scene, spp=arguments.reference_spp, size=arguments.size, seed=1)
    counts = [2 ** k for k in range(arguments.spp.bit_length())]
    for sampler in ("independent", "sobol"):
        errors = []
        for spp in counts:
            image = sheaf.render(scene, spp=spp, size=arguments.size, sampler=sampler)
            errors.append(sheaf.compare(image, reference)["relative_mse"])
        plt.loglog(counts, errors, "o-", label=sampler)
    plt.loglog(counts, [errors[0] / n for n in counts], "k:", label="1 / N")
    plt.xlabel("samples per pixel")
    plt.ylabel("relative mean squared error")
    plt.legend()
    plt.savefig(arguments.output)


if __name__ == "__main__":
    main()
