"""`planetfall bench --against COMMIT`: processor time of frames of this checkout over that of a commit's.

Two processes, one with each version, draw the same frames in turns (A B, B A, A B ...): a machine that slows down or is
busy slows both alike. What counts is the ratio of processor times of such a pair of blocks.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import qualities
from ..camera.views import views
from ..engine.settings.suggest import did_you_mean
from ..errors import SettingError, UnknownNameError

__all__ = ["CASES", "Case", "CaseFailed", "Outcome", "Ratio", "checkout_of", "choose_cases", "measure_case", "ratio_of"]

ROOT = Path(__file__).resolve().parents[1]
QUALITIES = ("low", "medium", "high")
VIEWS = ("near", "high", "orbit", "sea")
RUN_UP = 40
"""Frames after which what a jump to a view leaves to those that follow is done."""

MOST_MEDIAN = 1.03
"""A median above it is slower, however wide the interval is."""


@dataclass(frozen=True)
class Case:
    """Frames of Earth in a view."""

    quality: str
    view: str
    clouds: bool

    def __str__(self) -> str:
        return f"{self.quality}.{self.view}.{'clouds' if self.clouds else 'clear'}"


CASES = tuple(Case(q, v, c) for q in QUALITIES for v in VIEWS for c in (False, True))


def choose_cases(patterns: Iterable[str]) -> list[Case]:
    """Cases from patterns such as "low", "near.clouds" and "low.near.clear"; none: all of CASES.

    Words are a quality, a view of Earth, and clouds or clear; what a pattern does not name is as in CASES. "high" is
    the quality where no other word is one, else the view. Raises SettingError, UnknownNameError.
    """
    kinds = {word: "sky" for word in ("clear", "clouds")}
    kinds |= {name: "view" for name in views("earth") if name not in kinds} | {name: "quality" for name in qualities()}
    both = set(qualities()) & set(views("earth"))
    found: dict[Case, None] = {}
    for pattern in patterns:
        named: dict[str, str] = {}
        for word in sorted(pattern.split("."), key=both.__contains__):
            if word not in kinds:
                raise UnknownNameError(f"--against: no cases {pattern!r}; {did_you_mean(word, kinds, 'parts')}")
            kind = "view" if word in both and "quality" in named else kinds[word]
            if kind in named:
                raise SettingError(f"--against: {pattern!r} names a {kind} twice: {named[kind]} and {word}")
            named[kind] = word
        for quality in (named["quality"],) if "quality" in named else QUALITIES:
            for view in (named["view"],) if "view" in named else VIEWS:
                skies = (named["sky"] == "clouds",) if "sky" in named else (False, True)
                found.update({Case(quality, view, clouds): None for clouds in skies})
    return list(found) or list(CASES)


@dataclass(frozen=True)
class Ratio:
    """New over old: the median over pairs of blocks and its 95 % interval."""

    median: float
    low: float
    high: float

    @property
    def no_slower(self) -> bool:
        """Whether nothing says that the new version takes longer."""
        return self.low <= 1.0 and self.median <= MOST_MEDIAN


def ratio_of(old: Sequence[float], new: Sequence[float], seed: int = 1, resamples: int = 10_000) -> Ratio:
    """Of times of blocks, pair by pair; the interval is a bootstrap's over the pairs (percentiles of medians)."""
    ratios = np.asarray(new, np.float64) / np.asarray(old, np.float64)
    picks = np.random.default_rng(seed).integers(0, len(ratios), (resamples, len(ratios)))
    low, high = np.quantile(np.median(ratios[picks], axis=1), (0.025, 0.975))
    return Ratio(float(np.median(ratios)), float(low), float(high))


@dataclass(frozen=True)
class Outcome:
    """What a case came to; times are of single frames."""

    case: Case
    cpu: Ratio
    wall: Ratio
    old_cpu_ms: tuple[float, ...]
    """Processor time of all threads: a mean over the frames of each block."""
    new_cpu_ms: tuple[float, ...]

    def row(self) -> dict[str, Any]:
        """For a JSON file."""
        return {
            "case": str(self.case),
            "ratio": self.cpu.median,
            "low": self.cpu.low,
            "high": self.cpu.high,
            "no_slower": self.cpu.no_slower,
            "wall_ratio": self.wall.median,
            "old_cpu_ms": self.old_cpu_ms,
            "new_cpu_ms": self.new_cpu_ms,
        }


class CaseFailed(Exception):
    """A version that can't draw a case; the message says which and why."""


@contextmanager
def checkout_of(commit: str, root: Path = ROOT) -> Iterator[tuple[str, Path]]:
    """(full hash, folder) of a worktree of the commit beside the checkout `root`; it is removed afterwards.

    SettingError where there is no git, no checkout or no such commit.
    """
    if shutil.which("git") is None:
        raise SettingError("--against needs git, which was not found on the PATH")
    if not (root / ".git").exists():
        raise SettingError(f"--against needs a git checkout of planetfall; {root} is none")
    # What begins with "-" would be an option of git's.
    found = _git(root, "rev-parse", "--verify", "--quiet", f"{'' if commit[:1] == '-' else commit}^{{commit}}")
    if found.returncode:
        raise SettingError(f"--against: no commit {commit!r} in {root}; expected a hash, a branch or a tag")
    name = found.stdout.strip()
    beside = root.parent if os.access(root.parent, os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="planetfall-against-", dir=beside, ignore_cleanup_errors=True) as folder:
        tree = Path(folder) / "planetfall"
        try:
            made = _git(root, "worktree", "add", "--detach", str(tree), name)
            if made.returncode:
                raise SettingError(f"--against {commit}: git could not check it out: {made.stderr.strip()[-400:]}")
            yield name, tree
        finally:
            _git(root, "worktree", "remove", "--force", "--force", str(tree))


def _git(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, check=False)


class Child:
    """A process that draws frames with the library of a checkout."""

    def __init__(self, what: str, root: Path) -> None:
        self._what, self._root = what, root.resolve()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        # -P: the script's own folder, full of modules, stays off the path.
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(Path(__file__).with_name("against_child.py"))],
            env={**os.environ, "PYTHONPATH": str(self._root)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            text=True,
            encoding="utf-8",
        )

    def ask(self, **request: Any) -> None:
        """Send a request; `answer` waits for what comes of it."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
        except OSError:  # it has ended: its answer says why
            pass

    def answer(self) -> dict[str, Any]:
        """The answer to the last request. CaseFailed where it is an error, or the process has ended."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            code = self._process.wait()
            self._said.seek(0)
            said = self._said.read().decode("utf-8", "replace").strip().splitlines()
            raise CaseFailed(f"{self._what}: ended with {code}: {' '.join(said[-1:])}")
        found = json.loads(line)
        if "error" in found:
            raise CaseFailed(f"{self._what}: {found['error']}")
        return found

    def open(self, case: Case, size: tuple[int, int]) -> None:
        """Begin to settle a case's picture."""
        self.ask(open={"quality": case.quality, "view": case.view, "clouds": case.clouds, "size": size})

    def opened(self) -> None:
        """Wait until it has settled, and see that the library is the one that is meant."""
        loaded = self.answer()["from"]
        if Path(loaded).resolve() != self._root:
            raise CaseFailed(f"{self._what}: planetfall came from {loaded} in place of {self._root}")

    def draw(self, frames: int) -> dict[str, float]:
        """Time of some frames."""
        self.ask(draw=frames)
        return self.answer()

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()
        self._said.close()


def measure_case(
    case: Case,
    old: Path,
    new: Path = ROOT,
    size: tuple[int, int] = (640, 360),
    blocks: int = 20,
    frames: int = 8,
    run_up: int = RUN_UP,
    progress: Callable[[int, int], None] | None = None,
) -> Outcome:
    """Pairs of blocks of frames by both versions in turns. progress: told (pairs done, of). Raises CaseFailed."""
    with ExitStack() as stack:
        children: list[Child] = []
        for what, root in (("old", old), ("new", new)):
            children.append(Child(what, root))
            stack.callback(children[-1].close)
        for child in children:
            child.open(case, size)
        for child in children:
            child.opened()
        for child in children:
            child.draw(run_up)
        found: list[list[dict[str, float]]] = [[], []]
        for block in range(blocks):
            for which in (0, 1) if block % 2 == 0 else (1, 0):
                found[which].append(children[which].draw(frames))
            if progress is not None:
                progress(block + 1, blocks)
    cpu, wall = ([[b[key] * 1e3 / frames for b in side] for side in found] for key in ("cpu_s", "wall_s"))
    return Outcome(case, ratio_of(cpu[0], cpu[1]), ratio_of(wall[0], wall[1]), tuple(cpu[0]), tuple(cpu[1]))
