"""What compilers of GPU drivers refuse although the reference compiler takes it, found in the text of shaders."""

from __future__ import annotations

import re

from planetfall import ASSETS

# `a[1] = a[2] = x` reads a[2], says NVIDIA's compiler, and refuses it where the buffer is write-only.
CHAIN = re.compile(r"\b(\w+)\[[^\]=]*\][\w.]*\s*=\s*\1\[[^\]=]*\][\w.]*\s*=[^=]")
WRITE_ONLY = re.compile(r"writeonly\s+buffer\s+\w+\s*\{([^}]*)\}")


def chains(text: str) -> list[str]:
    names = {name for block in WRITE_ONLY.findall(text) for name in re.findall(r"(\w+)\s*(?:\[[^\]]*\])?\s*;", block)}
    return [found.group(0) for found in CHAIN.finditer(text) if found.group(1) in names]


def test_chains_are_found():
    block = "layout(std430) writeonly buffer B { uint n; uint arguments[]; };\n"
    assert chains(block + "arguments[2] = arguments[3] = 0u;") and chains(
        block + "arguments[i + 1] = arguments[i] = x;"
    )
    assert not chains(block + "arguments[2] = 0u; arguments[3] = 0u;")
    assert not chains(block.replace("writeonly ", "") + "arguments[2] = arguments[3] = 0u;")


def test_no_assignment_is_read_from_a_write_only_buffer():
    found = {
        path.relative_to(ASSETS).as_posix(): lines
        for path in (ASSETS / "shaders").rglob("*")
        if path.is_file() and (lines := chains(path.read_text(encoding="utf-8")))
    }
    assert not found
