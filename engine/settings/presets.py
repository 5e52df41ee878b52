"""Presets: components from and to TOML tables, with messages that name file, key, expected and found."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from .check import PresetError, SettingError, check_value, rules_of
from .suggest import did_you_mean

__all__ = ["build_components", "functions_of", "plain_table", "read_toml", "write_toml"]


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The file's content; PresetError when it is missing, unreadable or no TOML (naming line and column)."""
    path = Path(path)
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        raise PresetError(f"{path}: no such file (looked from {Path.cwd()}); check its name and folder") from None
    except OSError as error:
        advice = "name a TOML file in it" if path.is_dir() else "check its rights"
        raise PresetError(f"{path}: can't be read: {error.strerror or error}; {advice}") from error
    try:
        return msgspec.toml.decode(text)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise PresetError(f"{path}: not valid TOML: {error}; check quotes, brackets and = there") from error


def write_toml(path: str | os.PathLike[str], data: Mapping[str, object]) -> None:
    """Write the file so that it is at any time either the old one or the new one, also if the power fails.

    It is written beside its place, flushed to disk, and renamed. PresetError when the folder is missing or refuses.
    """
    import tempfile  # with compressors, which who only reads presets need not wait for

    path = Path(path)
    if not path.parent.is_dir():
        raise PresetError(f"{path}: the folder {path.parent.absolute()} doesn't exist; make it first")
    try:
        handle, beside = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".tmp", dir=path.parent)
    except OSError as error:
        raise PresetError(f"{path}: can't write into {path.parent.absolute()}: {error.strerror or error}") from error
    try:
        with os.fdopen(handle, "wb") as file:
            tomli_w.dump(data, file)
            file.flush()
            os.fsync(file.fileno())
        # A temporary file is private; the preset gets what the old file, or any new file, would have.
        with contextlib.suppress(OSError):
            os.chmod(beside, path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask())
        os.replace(beside, path)
    except OSError as error:
        _discard(beside)
        raise PresetError(f"{path}: can't be written: {error.strerror or error}") from error
    except BaseException:
        _discard(beside)
        raise
    _sync_folder(path.parent)


def build_components(
    data: Mapping[str, Any], kinds: Mapping[str, type], file: str | os.PathLike[str], *, also: tuple[str, ...] = ()
) -> dict[str, Any]:
    """{table: component} from the tables of a TOML file.

    kinds: {table name: component class}; a table may also be written as the class's name ([Ocean] for [ocean]).
    also: top-level keys that the caller reads itself. Raises PresetError with all problems of the file at once.
    """
    aliases = {cls.__name__: table for table, cls in kinds.items()}
    problems: list[str] = []
    built: dict[str, Any] = {}
    for key, value in data.items():
        if key in also:
            continue
        table = aliases.get(key, key)
        if table not in kinds:
            noun = "table" if isinstance(value, Mapping) else "key"
            homes = [] if noun == "table" else [name for name, cls in kinds.items() if key in rules_of(cls)]
            hint = did_you_mean(key, [*kinds, *also], "allowed")
            if homes:
                hint = f"put it below a line {' or '.join(f'[{name}]' for name in homes)}"
            if noun == "table" and not hint.startswith("did you mean"):
                hint += ". A table of a game's own needs its module imported first (planetfall --import MODULE)"
            problems.append(f"{key}: unknown {noun}; {hint}")
        elif table in built:
            problems.append(f"{key}: given twice, as [{table}] and as [{kinds[table].__name__}]; keep one")
        elif not isinstance(value, Mapping):
            problems.append(f"{key}: expected a table, found {value!r}. Write [{table}] on a line of its own")
        else:
            found: list[str] = []
            built[table] = _build(kinds[table], value, key, found)
            problems += found
    if problems:
        raise PresetError(_listing(file, problems), problems)
    return built


def _build(cls: type, values: Mapping[str, Any], table: str, problems: list[str]) -> Any:
    rules = rules_of(cls)
    checked: dict[str, Any] = {}
    for key, value in values.items():
        rule = rules.get(key)
        if rule is None:
            problems.append(f"{table}.{key}: unknown key; {did_you_mean(key, rules, 'allowed')}")
            continue
        clash = next((o for o in rule.knob.excludes if o in checked), None)
        if clash is not None:
            problems.append(f"{table}.{key}: excludes {table}.{clash}; give only one of them")
            continue
        try:
            checked[key] = check_value(rule, value, f"{table}.{key}")
        except SettingError as error:
            problems.append(str(error))
    return None if problems else cls(**checked)


def plain_table(component: object) -> dict[str, Any]:
    """The component's knobs as a TOML table, without those that are None and without functions (`functions_of`).
    Reading it back gives an equal component but for the latter."""
    table: dict[str, Any] = {}
    for name, rule in rules_of(type(component)).items():
        value = getattr(component, name)
        if rule.kind in ("tables", "list"):
            if value:
                table[name] = [plain_table(item) for item in value]
        elif rule.kind == "rows":
            if value:
                table[name] = [list(row) for row in value]
        elif value is not None and rule.kind != "function":
            table[name] = list(value) if isinstance(value, tuple) else value
    return table


def functions_of(component: object) -> list[str]:
    """Names such as "Cover.mask" of its knobs that hold a function, which no file can."""
    kind = type(component)
    rules = rules_of(kind).values() if dataclasses.is_dataclass(kind) else ()
    found = [rule.name for rule in rules if rule.kind == "function" and getattr(component, rule.name) is not None]
    return [f"{kind.__name__}.{name}" for name in found]


def _listing(file: str | os.PathLike[str], problems: list[str]) -> str:
    if len(problems) == 1:
        return f"{os.fspath(file)}: {problems[0]}"
    return f"{os.fspath(file)}: {len(problems)} problems:\n" + "\n".join(f"  - {p}" for p in problems)


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _discard(path: str) -> None:
    with contextlib.suppress(OSError):
        os.unlink(path)


def _sync_folder(folder: Path) -> None:
    # The rename itself lasts only once the folder is on disk. Windows can't open a folder and needs no such thing.
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
