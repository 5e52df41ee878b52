"""llvmpipe's threads: a processor each, and left alone where that would not help."""

import os
import subprocess
import sys

import pytest

from planetfall.engine.gpu.software_threads import OFF

PROGRAM = """
import os, sys
mode = sys.argv[1]
if mode == "fewer":
    os.environ["LP_NUM_THREADS"] = "1"
if mode == "off":
    os.environ["PLANETFALL_PIN"] = "0"
from planetfall.engine.gpu import Gpu
from planetfall.engine.gpu.software_threads import _threads, spread_threads
from planetfall.engine.hosts.headless import create_headless
gpu = Gpu(create_headless(), [])
if not gpu.caps.renderer.startswith("llvmpipe"):
    print("another renderer")
    sys.exit()
threads = _threads()
assert len(threads) == (1 if mode == "fewer" else min(len(os.sched_getaffinity(0)), 16)), threads
print(*("+".join(map(str, sorted(os.sched_getaffinity(thread)))) for _, thread in threads))
print("again", spread_threads(), "main", "+".join(map(str, sorted(os.sched_getaffinity(0)))))
"""

pytestmark = pytest.mark.skipif(
    not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) not in range(2, 17),
    reason="needs Linux and two to sixteen processors",
)


def _places(mode: str) -> list[str]:
    chosen = {name: value for name, value in os.environ.items() if name != OFF}  # beside another worker it is off
    done = subprocess.run([sys.executable, "-c", PROGRAM, mode], capture_output=True, text=True, check=True, env=chosen)
    lines = done.stdout.splitlines()
    if lines == ["another renderer"]:
        pytest.skip("not llvmpipe")
    assert lines[1] == "again 0 main " + "+".join(map(str, sorted(os.sched_getaffinity(0))))
    return lines[0].split()


def test_each_thread_has_a_processor() -> None:
    assert _places("on") == [str(processor) for processor in sorted(os.sched_getaffinity(0))]


@pytest.mark.parametrize("mode", ["off", "fewer"])
def test_threads_are_left_alone(mode: str) -> None:
    everywhere = "+".join(map(str, sorted(os.sched_getaffinity(0))))
    assert set(_places(mode)) == {everywhere}
