"""Pictures of a planet with a ring: from space, and from the ground in the morning."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import planetfall as pf

from .ring import Ring


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="new_system", description=__doc__)
    parser.add_argument("--size", type=int, nargs=2, default=(960, 540), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--output", "-o", type=Path, default=Path("ring"), help="folder of the pictures")
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    scene = pf.load_scene("earth")
    scene.planet.add(Ring())
    scene.sun = pf.Sun(direction=(0.55, -0.6, 0.42))
    shots = {
        "space": pf.Camera.at(24.0, 0.0, 2.6e7, pitch_deg=-86.0, fov_y_deg=62.0),
        "ground": pf.Camera.at(28.0, -40.0, 400.0, heading_deg=190.0, pitch_deg=20.0, fov_y_deg=75.0, above="ground"),
    }
    with pf.Renderer(scene, tuple(options.size), "medium") as renderer:
        for name, camera in shots.items():
            renderer.snapshot(camera).save(options.output / f"{name}.png")
            sys.stdout.write(f"{options.output / name}.png\n")
    scene.save(options.output / "ringed.toml")  # with a table [ring]; load_scene reads it while Ring is registered
    return 0


if __name__ == "__main__":
    sys.exit(main())
