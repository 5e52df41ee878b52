"""A display for benches that open windows: the one there is, or a virtual one."""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import subprocess
import sys
from collections.abc import Iterator

__all__ = ["NoDisplay", "display"]

_WAIT_S = 20.0


class NoDisplay(RuntimeError):
    """There is no display, and none could be made."""


@contextlib.contextmanager
def display(size: str = "1280x800x24") -> Iterator[dict[str, str]]:
    """What to add to a process' environment for it to open windows. Starts Xvfb where there is no display, and
    NoDisplay where that isn't there either."""
    if sys.platform != "linux" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        yield {}
        return
    program = shutil.which("Xvfb")
    if program is None:
        raise NoDisplay("no display, and no Xvfb to make one (on Debian `apt install xvfb`)")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(
        [program, "-displayfd", str(write_end), "-screen", "0", size, "-nolisten", "tcp"],
        pass_fds=(write_end,),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(write_end)
    try:
        ready, _, _ = select.select([read_end], [], [], _WAIT_S)
        number = os.read(read_end, 16).decode().strip() if ready else ""
        if not number:
            raise NoDisplay(f"Xvfb did not start within {_WAIT_S:g} s")
        yield {"DISPLAY": f":{number}"}
    finally:
        os.close(read_end)
        server.terminate()
        server.wait(timeout=_WAIT_S)
