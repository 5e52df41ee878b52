"""No line of code, shaders, presets or docs is over 120 columns wide, but for tables, pictures and addresses."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WIDEST = 120
FOLDERS = ("planetfall", "engine", "systems", "components", "games", "benchmarks", "tests", "assets")
CODE = {".py", ".glsl", ".vert", ".frag", ".comp", ".toml"}
GENERATED = {"api.md", "bindings.md", "benchmarks.md", "numerical-stability.md"}
"""Pages that programs write."""
PRAGMA = r"\s+# (type|pyright|noqa|ruff):? ?.*$"
"""What tools are told at a line's end, which ruff does not count either."""


def too_wide(text: str, prose: bool) -> list[int]:
    """Numbers of lines that are too wide, from 1."""
    found, fenced = [], False
    for number, line in enumerate(text.splitlines(), start=1):
        fenced ^= prose and line.lstrip().startswith("```")
        free = prose and (fenced or line.startswith(("|", "    ", "![")) or "http" in line)
        if len(re.sub(PRAGMA, "", line)) > WIDEST and not free:
            found.append(number)
    return found


def test_lines_fit() -> None:
    wrong = []
    files = [f for folder in FOLDERS for f in (ROOT / folder).rglob("*") if f.suffix in CODE and "data" not in f.parts]
    for file in (*files, ROOT / "run.py", ROOT / "pyproject.toml"):
        wrong += [f"{file.relative_to(ROOT)}:{n}" for n in too_wide(file.read_text("utf-8"), prose=False)]
    folders = (".", "docs", "docs/tutorials", "docs/gallery")
    pages = [page for folder in folders for page in (ROOT / folder).glob("*.md")]
    for file in (page for page in pages if page.name not in GENERATED):
        wrong += [f"{file.relative_to(ROOT)}:{n}" for n in too_wide(file.read_text("utf-8"), prose=True)]
    assert not wrong, "wider than 120 columns: " + ", ".join(wrong)


def test_the_rule_sees_wide_lines() -> None:
    wide = "x" * 121
    assert too_wide(f"a\n{wide}", prose=False) == [2]
    assert too_wide(f"| {wide} |\n```\n{wide}\n```\n{wide}\n", prose=True) == [5]
