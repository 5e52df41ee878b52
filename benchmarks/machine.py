"""Which machine, driver and commit a run was made on."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import re
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..engine.processor import processor_name
from .schema import Machine

if TYPE_CHECKING:
    from ..engine.gpu.caps import Capabilities

_ROOT = Path(__file__).resolve().parent.parent


def describe_machine(caps: Capabilities | None) -> Machine:
    """The machine, and the GPU of a context's capabilities; without one the GL fields are empty."""
    return Machine(
        system=f"{platform.system()} {platform.machine()}",
        cpu=processor_name(),
        cpus=cpu_count(),
        memory_bytes=_memory_bytes(),
        python=f"{platform.python_implementation()} {platform.python_version()}",
        numpy=np.__version__,
        moderngl=importlib.metadata.version("moderngl"),
        gl_renderer="" if caps is None else caps.renderer,
        gl_vendor="" if caps is None else caps.vendor,
        gl_version="" if caps is None else caps.version,
        is_software=caps is None or caps.is_software,
        load_average=_load_average(),
    )


def device_slug(machine: Machine) -> str:
    """A folder name for results of this device: the renderer, and the CPUs too where those do the drawing."""
    name = _slug(machine.gl_renderer or "no-renderer")
    return f"{name}-{machine.cpus}cpu-{_slug(machine.cpu)}" if machine.is_software else name


def device_title(machine: Machine) -> str:
    """The same for a reader."""
    return ", ".join(filter(None, (machine.gl_renderer, machine.cpu if machine.is_software else ""))) or "unknown"


def _slug(name: str) -> str:
    plain = re.sub(r"\((r|tm)\)", "", name.lower())
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:48].strip("-") or "unknown"


def cpu_count() -> int:
    """CPUs that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity is not None else os.cpu_count() or 1


def current_commit() -> str:
    """The checkout's commit, with "+changes" where the library's files differ from it; empty outside a checkout."""
    if not (_ROOT / ".git").exists():
        return ""
    try:
        commit = _git("rev-parse", "--short=12", "HEAD")
        changed = _git("status", "--porcelain", "--untracked-files=no", "--", "engine", "systems", "components",
                       "planetfall", "assets", "benchmarks")  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return ""
    return commit + ("+changes" if changed else "")


def now_utc() -> str:
    """The time, for a report."""
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def resident_bytes(peak: bool = False) -> int:
    """Memory of this process, now or at its highest, pages of libraries' files with it; 0 where the system doesn't
    tell."""
    return _status_bytes("VmHWM:" if peak else "VmRSS:")


def own_bytes() -> int:
    """Memory that this process alone has: without pages of files, most of them libraries'. 0 where the system doesn't
    tell."""
    return _status_bytes("RssAnon:")


def _status_bytes(key: str) -> int:
    try:
        for line in Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith(key):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0


def _git(*arguments: str) -> str:
    done = subprocess.run(["git", "-C", str(_ROOT), *arguments], capture_output=True, text=True, timeout=20, check=True)
    return done.stdout.strip()


def _memory_bytes() -> int:
    try:
        return int(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return 0


def _load_average() -> float:
    try:
        return round(os.getloadavg()[0] / cpu_count(), 2)
    except (AttributeError, OSError):
        return 0.0
