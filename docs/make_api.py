"""Writes docs/api.md from the docstrings and docs/bindings.md from the registry: `python docs/make_api.py`.

Tests want them to be current.
"""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "docs" / "api.md"
BINDINGS = ROOT / "docs" / "bindings.md"
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

HEAD = """# API reference

Everything that `import planetfall as pf` offers, from its docstrings; `python docs/make_api.py` writes this page.
Lengths are metres, angles degrees or radians as the names say, positions float64 in planet axes: +Z the north pole, +X
latitude 0 and longitude 0. Errors name what was expected, what was found and what to do.
"""

BINDINGS_HEAD = """# Binding points

The registry `engine/blocks/bindings.py`, written here by `python docs/make_api.py`. Python imports its names, shaders
get them from `#include "generated/bindings.glsl"`. Where a number has several names, no program has two of them.

**Yours to bind** in a system of your own, for the time of one pass, wherever your shaders include nothing that has the
number: {free}.
`assets/shaders/common/camera.glsl` takes uniform blocks 0 and 1 and nothing else. A host's state guard keeps these
numbers and those below, no others.

"""


def text() -> str:
    """The page."""
    import planetfall as pf
    from planetfall import extend

    parts = [HEAD]
    names = sorted((n for n in pf.__all__ if not n.startswith("__") and n != "ASSETS"), key=str.lower)
    groups: dict[str, list[str]] = {"Functions": [], "Classes": [], "Components": [], "Errors": []}
    for name in names:
        groups[_group(getattr(pf, name))].append(name)
    for title in ("Classes", "Components", "Functions", "Errors"):
        parts.append(f"\n## {title}\n")
        parts += [_entry(f"pf.{name}", getattr(pf, name)) for name in groups[title]]
    parts.append("\n## planetfall.extend\n")
    parts.append(f"\n{(inspect.getdoc(extend) or '').strip()}\n")
    names = ["register", "unregister", "register_material", "unregister_material", "Ripples"]
    for name in (*names, "fullscreen_pass", "knob", "System", "Setup", "Frame", "ViewInfo"):
        parts.append(_entry(f"extend.{name}", getattr(extend, name)))
    return "".join(parts)


def bindings_text() -> str:
    """The page of binding points."""
    from planetfall.engine.blocks import bindings

    free = "; ".join(f"{kind} {own[0]}{f' to {own[-1]}' * (len(own) > 1)}" for kind, own in bindings.OWN.items())
    return BINDINGS_HEAD.format(free=free) + bindings.table()


def _group(thing: Any) -> str:
    if not isinstance(thing, type):
        return "Functions"
    if issubclass(thing, BaseException):
        return "Errors"
    return "Components" if _knobs(thing) else "Classes"


def _entry(name: str, thing: Any) -> str:
    lines = [f"\n### `{name}`\n"]
    is_error = isinstance(thing, type) and issubclass(thing, BaseException)
    if not _knobs(thing) and not is_error and not dataclasses.is_dataclass(thing):
        lines.append(f"\n```text\n{_signature(name.rpartition('.')[2], thing)}\n```\n")
    lines.append(f"\n{(inspect.getdoc(thing) or '').strip()}\n")
    if is_error:
        bases = ", ".join(f"`{b.__name__}`" for b in thing.__mro__[1:] if b not in (object, BaseException, Exception))
        lines.append(f"\nIt is a {bases}.\n" if bases else "")
    elif _knobs(thing):
        lines += ["\n| field | default | allowed | |\n|---|---|---|---|\n", *map(_knob_row, _knobs(thing))]
    elif isinstance(thing, type):
        lines += _members(thing)
    return "".join(lines)


def _members(kind: type) -> list[str]:
    lines = []
    members: dict[str, Any] = {}
    for each in reversed(kind.__mro__):
        if each.__module__.startswith("planetfall"):
            members.update(vars(each))
    for name, member in sorted(members.items()):
        if name.startswith("_"):
            continue
        plain = member.__func__ if isinstance(member, classmethod | staticmethod) else member
        if isinstance(plain, property):
            about = inspect.getdoc(plain) or ""
            lines.append(f"\n- `{name}`" + (f": {_one(about)}" if about else "") + "\n")
        elif inspect.isfunction(plain):
            about = inspect.getdoc(plain) or ""
            lines.append(f"\n- `{_signature(name, plain, own=True)}`" + (f": {_one(about)}" if about else "") + "\n")
    return lines


def _knobs(thing: Any) -> list[Any]:
    if not dataclasses.is_dataclass(thing) or not isinstance(thing, type):
        return []
    if not any("knob" in f.metadata for f in dataclasses.fields(thing)):
        return []
    from planetfall.engine.settings import rules_of

    return list(rules_of(thing).values())


def _knob_row(rule: Any) -> str:
    default = f"{rule.default:.12g}" if isinstance(rule.default, float) else str(rule.default)
    cells = (f"`{rule.name}`", default, rule.expected, rule.knob.help)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def _signature(name: str, thing: Any, own: bool = False) -> str:
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return f"{name}(...)"
    left = [
        p.replace(annotation=_bare(p.annotation), default=_place(p.default))
        for n, p in signature.parameters.items()
        if not (n in ("self", "cls") and (own or isinstance(thing, type)))
    ]
    returned = inspect.Signature.empty if isinstance(thing, type) else _bare(signature.return_annotation)
    return name + str(signature.replace(parameters=left, return_annotation=returned))


class _Bare:
    """An annotation that is shown as it was written."""

    def __init__(self, text_: str) -> None:
        self._text = text_

    def __repr__(self) -> str:
        return self._text


def _place(default: Any) -> Any:
    """A default that is a file of ours, by its place in the project."""
    return _Bare(default.relative_to(ROOT).as_posix()) if isinstance(default, Path) else default


def _bare(annotation: Any) -> Any:
    return _Bare(annotation) if isinstance(annotation, str) else annotation


def _one(about: str) -> str:
    """A docstring in one paragraph."""
    return " ".join(about.split())


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    for target, page in ((TARGET, text()), (BINDINGS, bindings_text())):
        target.write_text(page, encoding="utf-8")
        sys.stdout.write(f"{target}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
