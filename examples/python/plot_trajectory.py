#!/usr/bin/env python3
"""Runs a configuration on a recording and plots the trajectory with the points of the last window, from above.

plot_trajectory.py RECORDING [--config NAME] [--map] [--out FILE.png]; needs python3-matplotlib. docs/guide/python.md
"""

import argparse
import sys

import matplotlib
import numpy as np

import plumbline


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording")
    parser.add_argument("--config", help="one of plumbline.configurations(); by default the one that fits")
    parser.add_argument("--map", action="store_true", help="close loops")
    parser.add_argument("--out", help="picture to write, instead of a window")
    options = parser.parse_args()
    if options.out:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    try:
        run = plumbline.run(options.recording, options.config, options.map)
    except (plumbline.Error, ValueError) as error:
        sys.exit(f"plot_trajectory.py: {error}")
    for note in run.notes:
        print(note, file=sys.stderr)
    print(run.summary)

    # Two axes that the motion fills: without an IMU, z of the world is where the camera looks at first.
    position = run.trajectory.position
    a, b = sorted(np.argsort(np.ptp(position, axis=0))[1:])
    figure, axes = plt.subplots(figsize=(8, 8))
    near = run.landmarks[np.linalg.norm(run.landmarks - position.mean(axis=0), axis=1) < 20 + np.ptp(position)]
    axes.scatter(near[:, a], near[:, b], s=4, color="0.6", label="points")
    axes.plot(position[:, a], position[:, b], color="C0", label="trajectory")
    axes.plot(*position[0, [a, b]], "o", color="C0", label="start")
    axes.set(xlabel=f"{'xyz'[a]} [m]", ylabel=f"{'xyz'[b]} [m]", aspect="equal")
    axes.set_title(f"{run.config}, {len(position)} poses")
    axes.legend()
    if options.out:
        figure.savefig(options.out, dpi=120)
    else:
        plt.show()


if __name__ == "__main__":
    main()
