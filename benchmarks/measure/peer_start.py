"""From the command to the first picture of a scene of suite `peers`, in this process; prints JSON. Run as a module.

Arguments: the time.time() at which the process was asked for, a name of peer_scenes.SCENES, a quality.
"""

from __future__ import annotations

import json
import sys
import time


def main(asked_s: float, name: str, quality: str) -> dict[str, float]:
    """Milliseconds since asked_s by stage; "first picture" has been drawn and read."""
    marks = {"interpreter": 1e3 * (time.time() - asked_s)}
    from ... import Renderer
    from . import peer_scenes

    marks["import"] = 1e3 * (time.time() - asked_s)
    with peer_scenes.SCENES[name]() as scene, Renderer(scene, (640, 360), quality) as renderer:
        marks["renderer"] = 1e3 * (time.time() - asked_s)
        renderer.render(peer_scenes.camera("ground"), peer_scenes.TIME_S, peer_scenes.sun())
        marks["first picture"] = 1e3 * (time.time() - asked_s)
    return marks


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(float(sys.argv[1]), sys.argv[2], sys.argv[3])))
