"""`planetfall new`: a scene file of one's own, in which every knob stands with its value, range and meaning."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import tomli_w
from cyclopts import Parameter

from ..engine.settings import plain_table, rules_of
from ..errors import OutputError
from ..systems.capture import require_writable, written_beside
from .progress import console, written

__all__ = ["new_command", "scene_template"]

_WIDTH = 110


def new_command(
    file: Path,
    *,
    base: str = "earth",
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Write a scene file of your own: it starts from a planet, and names every knob to change, with range and help.

    Parameters
    ----------
    file
        The file to write, such as mine.toml.
    base
        The planet to start from: a planet's name (see planetfall planets), or a scene's TOML file.
    force
        Write over a file that is there already.
    """
    if file.suffix != ".toml":
        raise OutputError(f"new: expected a name ending in .toml, found {str(file)!r}; such as {file.stem}.toml")
    if file.exists() and not force:
        raise OutputError(f"new: {str(file)!r} is there already; give another name, or --force to write over it")
    require_writable(file)
    text = scene_template(base, file)
    with written_beside(file) as beside:
        beside.write_text(text, encoding="utf-8")
    render = f"planetfall render {file} --view orbit -o {file.stem}.png"
    written(file)
    console.print(f"Next: change values in it, then {render}", markup=False, highlight=False, soft_wrap=True)


def scene_template(base: str, file: Path) -> str:
    """The text of a scene file for `file` that equals `base` until a line of it is changed.

    Settings are commented out with a bare # before them, remarks with # and a space. PresetError or UnknownNameError
    when base is no planet and no scene file; OutputError when it is `file` itself.
    """
    from ..scene.file import describe, planets, scenes

    told = describe(base)
    preset = base.strip() in (*planets(), *scenes())
    if not preset and told.path.absolute() == file.absolute():
        raise OutputError(f"new: {base!r} can't be its own base; give the new file another name")
    named = base.strip() if preset else _beside(told.path, file)
    lines = [
        f"# A scene of its own. It is {named} with what is changed below: take the # before a setting away and change",
        "# its value. Colours are linear RGB reflectances, directions are in planet axes.",
        f"base = {_toml(named)}",
        f"about = {_toml(told.about)}",
        *_tables(told.components, file),
    ]
    return "\n".join(lines) + "\n"


def _tables(components: Mapping[str, Any], file: Path) -> Iterator[str]:
    from ..scene.kinds import KINDS

    for table, kind in KINDS.items():
        there = components.get(table)
        yield ""
        if there is None:
            yield f"# There is no {table} yet: take the # before [{table}] away, and it has one with the values below."
            yield f"#[{table}]"
        else:
            yield f"[{table}]"
        yield from _knobs(kind() if there is None else there, file)


def _knobs(component: Any, file: Path) -> Iterator[str]:
    values = plain_table(component)
    for name, rule in rules_of(type(component)).items():
        if rule.kind == "function":
            continue
        if rule.knob.widget == "path" and values.get(name):
            values[name] = _beside(Path(values[name]), file)
        said = " ".join(part for part in (_sentence(rule.knob.help), _sentence(f"Expected: {rule.expected}")) if part)
        if name not in values:
            said = f"{name}, which is not set: {said}"
        yield from (f"# {line}" for line in textwrap.wrap(said, _WIDTH, break_long_words=False))
        if name in values:
            yield f"#{name} = {_toml(values[name])}"


def _sentence(text: str) -> str:
    return text if not text or text.endswith(".") else f"{text}."


def _toml(value: Any) -> str:
    """A value as it stands behind the = on one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return tomli_w.dumps({"v": value}).removeprefix("v = ").rstrip("\n")


def _beside(path: Path, file: Path) -> str:
    """A path as `file` names it: from its own folder, or whole on another drive."""
    try:
        return Path(os.path.relpath(path.absolute(), file.absolute().parent)).as_posix()
    except ValueError:  # Windows: no way leads from one drive to another
        return path.absolute().as_posix()
