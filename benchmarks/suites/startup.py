"""Suite startup: how long until the first picture, in a process of its own each time."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from statistics import median
from types import MappingProxyType
from typing import Any

from ..child import answer_of, keeping_bytecode
from ..display import display
from ..session import Bench, Session
from ..target import at_most
from ..timing import Timing

_NOTHING: Mapping[str, str] = MappingProxyType({})
_VIEWS = ("near", "ground", "high", "orbit")
_CHILD = """
import json, sys, time
began = time.perf_counter()
def since(): return (time.perf_counter() - began) * 1e3
import planetfall as pf
marks = {"import": since()}
scene = pf.load_scene("earth")
marks["scene"] = since()
if sys.argv[1] == "picture":
    renderer = pf.Renderer(scene, size=(640, 360), quality=sys.argv[2])
    marks["renderer"] = since()
    camera = pf.view(sys.argv[3])
    renderer.render(camera)
    marks["first picture"] = since()
    renderer.render(camera)
    marks["second picture"] = since()
    marks["graph bytes"] = renderer.graph.memory_bytes()
elif sys.argv[1] == "sampler":
    import numpy
    pf.TerrainSampler(scene).height(numpy.array([[1.0, 0.0, 0.0]]))
    marks["first height"] = since()
def memory(key):
    try:
        return next((int(line.split()[1]) * 1024 for line in open("/proc/self/status") if line.startswith(key)), 0)
    except OSError:
        return 0
marks["resident bytes"], marks["own bytes"] = memory("VmRSS:"), memory("RssAnon:")
marks["peak bytes"] = memory("VmHWM:")
print(json.dumps(marks))
"""


def run_child(*arguments: str, environment: Mapping[str, str] = _NOTHING) -> dict[str, Any]:
    """Milliseconds of the stages since the interpreter was up, and memory, of a fresh process."""
    return answer_of("-c", _CHILD, *arguments, environment=environment)


def _import(session: Session) -> None:
    """Importing planetfall; a program that only asks for heights; both without OpenGL."""
    with keeping_bytecode() as again:
        run_child("sampler", environment=again)
        runs = [run_child("sampler", environment=again) for _ in range(session.runs(7, 3))]
    for stage in ("import", "scene", "first height"):
        session.row(stage, timing=Timing.of([run[stage] for run in runs]))
    session.row("resident memory", error=_mib(runs, "resident bytes"), error_unit="MiB")


def _first_picture(session: Session) -> None:
    """From the interpreter to the first picture: a second start, and one that finds the driver's cache empty."""
    for name in ("near",) if session.extent == "quick" else ("near", "orbit") if session.small else _VIEWS:
        with keeping_bytecode() as again:
            run_child("picture", "medium", name, environment=again)
            warm = [run_child("picture", "medium", name, environment=again) for _ in range(session.runs(5, 2))]
        for stage in ("renderer", "first picture", "second picture"):
            first = stage == "first picture"
            session.row(f"warm: {stage}", name, (640, 360), Timing.of([run[stage] for run in warm]),
                        target=at_most(3000.0, "ms") if first else None, target_on="ms")  # fmt: skip
        if session.extent != "quick":
            with tempfile.TemporaryDirectory() as empty:
                places = {"MESA_SHADER_CACHE_DIR": empty, "XDG_CACHE_HOME": empty, "__GL_SHADER_DISK_CACHE_PATH": empty}
                cold = run_child("picture", "medium", name, environment=places)
            session.row("cold: first picture", name, (640, 360), Timing.of([cold["first picture"]]))
        plain = [run_child("picture", "medium", name, environment={**again, "PLANETFALL_COMPILED": "0"})]
        session.row("peak memory, without compiled loops", name, (640, 360), error=_mib(plain, "peak bytes"),
                    error_unit="MiB", target=at_most(480.0, "MiB"), own_mib=_mib(plain, "own bytes"),
                    graph_mib=_mib(plain, "graph bytes"))  # fmt: skip
        session.row("peak memory", name, (640, 360), error=_mib(warm, "peak bytes"), error_unit="MiB",
                    own_mib=_mib(warm, "own bytes"), graph_mib=_mib(warm, "graph bytes"))  # fmt: skip


def _window(session: Session) -> None:
    """From the command to the demo's first picture on the screen, with its interface; the driver's cache is warm."""
    arguments = ["earth", "--window", "glfw"]
    with display() as where, keeping_bytecode() as again:
        places = {**where, **again}
        _demo_start(arguments, places)
        warm = [_demo_start(arguments, places) for _ in range(session.runs(5, 1))]
    for stage in warm[0]:
        first = stage == "first picture"
        session.row(f"warm: {stage}", "orbit", (1280, 720), Timing.of([run[stage]["ms"] for run in warm]),
                    target=at_most(2000.0, "ms") if first else None, target_on="ms",
                    cpu_ms=median(run[stage]["cpu_ms"] for run in warm))  # fmt: skip


def _demo_start(arguments: list[str], environment: Mapping[str, str]) -> dict[str, dict[str, float]]:
    module = "planetfall.benchmarks.measure.window_start"
    return answer_of("-m", module, str(time.time()), *arguments, environment=environment)


def _mib(runs: list[dict[str, Any]], key: str) -> float:
    return max(run[key] for run in runs) / 2**20


BENCHES: Mapping[str, Bench] = {"import": _import, "first_picture": _first_picture, "window": _window}
