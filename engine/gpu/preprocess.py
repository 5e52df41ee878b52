"""GLSL sources before the compiler: include-once, defines, contracts, virtual files, and the way from a log to a file.

No #line is emitted: drivers disagree on what it means. A flat table (line of the expanded text -> file and line) is
exact on all of them.
"""

from __future__ import annotations

import difflib
import hashlib
import re
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..blocks import bindings
from ..made_shaders import MADE
from .errors import ShaderError, ShaderMessage

__all__ = ["Defines", "Expanded", "ShaderSources", "map_log"]

Defines = Mapping[str, "int | float | bool | str | None"]

_INCLUDE = re.compile(r'^\s*#\s*include\b\s*(?:["<]([^">]+)[">])?')
_DROP = re.compile(r"^\s*#\s*(version\b|pragma\s+once\b)")
_EXTENSION = re.compile(r"^\s*#\s*extension\b")
_IF = re.compile(r"^\s*#\s*(if|ifdef|ifndef)\b")
_ENDIF = re.compile(r"^\s*#\s*endif\b")
_NAME = re.compile(r"^[A-Za-z_]\w*$")
_WORD = re.compile(r"\w+")
VERSION = "#version 430 core"


@dataclass
class Expanded:
    """One stage, ready to compile. table[n - 1]: the (file, line) of line n; files: every file name that took part."""

    name: str
    text: str
    table: list[tuple[str, int]]
    files: frozenset[str]
    contracts: frozenset[str]

    @property
    def key(self) -> str:
        """Hash of the text: equal texts can share one program."""
        return hashlib.sha256(self.text.encode()).hexdigest()


# Mesa "0:8(33): error: ..", NVIDIA "0(8) : error C1503: ..", AMD, Intel and macOS "ERROR: 0:8: ..".
_PLACES = (
    re.compile(r"^\s*\d+:(?P<line>\d+)\(\d+\)\s*:\s*(?P<text>.*)$"),
    re.compile(r"^\s*\d+\((?P<line>\d+)\)\s*:\s*(?P<text>.*)$"),
    re.compile(r"^\s*(?P<kind>ERROR|WARNING):\s*\d+:(?P<line>\d+):\s*(?P<text>.*)$"),
)
_STAGE_TITLE = re.compile(
    r"^\s*(vertex|fragment|geometry|tess_control|tess_evaluation|tessellation control|tessellation evaluation|compute)"
    r"(_shader$| info\b| shader\b)",
    re.IGNORECASE,
)


def map_log(log: str, stages: Mapping[str, Expanded]) -> list[ShaderMessage]:
    """The lines of a driver's compile or link log (moderngl's headings included), each at its file and line."""
    current = next(iter(stages.values())) if len(stages) == 1 else None
    messages: list[ShaderMessage] = []
    for line in log.splitlines():
        text = line.strip()
        if not text or not text.strip("=-") or text.startswith("GLSL ") or text == "Program":
            continue
        title = _STAGE_TITLE.match(text)
        if title:
            stage = title[1].lower().replace("tessellation ", "tess_")
            current = stages.get(stage, current)
            continue
        for place in _PLACES:
            found = place.match(text)
            if found:
                number = int(found["line"])
                words = found["text"].strip()
                if "kind" in place.groupindex:
                    words = f"{found['kind'].lower()}: {words}"
                if current and 0 < number <= len(current.table):
                    messages.append(ShaderMessage(*current.table[number - 1], words))
                else:
                    messages.append(ShaderMessage("", 0, text))
                break
        else:
            messages.append(ShaderMessage("", 0, text))
    return messages


@dataclass
class _Expansion:
    name: str
    lines: list[str] = field(default_factory=list)
    table: list[tuple[str, int]] = field(default_factory=list)
    extensions: list[tuple[str, tuple[str, int]]] = field(default_factory=list)
    files: set[str] = field(default_factory=set)
    contracts: set[str] = field(default_factory=set)
    stack: list[str] = field(default_factory=list)
    done: set[str] = field(default_factory=set)
    depth: int = 0

    def add(self, text: str, file: str, line: int) -> None:
        self.lines.append(text)
        self.table.append((file, line))


@dataclass
class _Piece:
    """Lines of a file up to an include. depth: how many #if they leave open. include: what the directive names (None:
    it is malformed) and its place; None after the last include."""

    lines: list[str] = field(default_factory=list)
    table: list[tuple[str, int]] = field(default_factory=list)
    extensions: list[tuple[str, tuple[str, int]]] = field(default_factory=list)
    depth: int = 0
    include: tuple[str | None, tuple[str, int]] | None = None


class ShaderSources:
    """Finds and expands shader files. Names are relative to the roots, with forward slashes; the first root wins.

    `generation` rises whenever a contract's provider or a virtual file changes, so that users know when to look again.
    """

    def __init__(self, roots: Iterable[Path | str]) -> None:
        self.roots = [Path(root) for root in roots]
        self.generation = 0
        self._virtual: dict[str, str] = {"generated/bindings.glsl": bindings.glsl()}
        self._providers: dict[str, tuple[str, str]] = {}
        self._texts: dict[str, tuple[Path, tuple[int, int], str]] = {}
        self._parsed: dict[str, tuple[str, list[_Piece]]] = {}
        self._words: dict[str, tuple[str, frozenset[str]]] = {}

    # -- contracts and virtual files ---------------------------------------------------------------------------------

    def add_virtual(self, name: str, text: str) -> None:
        """Make `#include "name"` mean this text, without a file. The same name may be set again."""
        if self._virtual.get(name) != text:
            self._virtual[name] = text
            self.generation += 1

    def provide(self, contract: str, file: str, owner: str) -> None:
        """Let `file` answer `#include "contract/<contract>.glsl"` until `owner` withdraws it."""
        held = self._providers.get(contract)
        if held and held[1] != owner:
            raise ValueError(
                f"shader contract {contract!r}: {owner!r} offers {file}, but {held[1]!r} already provides {held[0]}; "
                "one of them has to withdraw first"
            )
        if held != (file, owner):
            self._providers[contract] = (file, owner)
            self.generation += 1

    def withdraw(self, owner: str) -> None:
        """Forget everything that `owner` provides; the defaults under common/ answer again."""
        kept = {name: held for name, held in self._providers.items() if held[1] != owner}
        if len(kept) != len(self._providers):
            self._providers = kept
            self.generation += 1

    def provider(self, contract: str) -> str:
        """The file that answers a contract at present."""
        held = self._providers.get(contract)
        return held[0] if held else f"common/{contract}.glsl"

    # -- files -------------------------------------------------------------------------------------------------------

    def read(self, name: str) -> str | None:
        """The text of a file, virtual or made file, None if there is none. Kept until poll() sees that it changed."""
        if name in self._virtual:
            return self._virtual[name]
        if name in MADE:
            return MADE[name]()
        cached = self._texts.get(name)
        if cached:
            return cached[2]
        for root in self.roots:
            path = root / name
            try:
                stamp = _stamp(path)
                text = path.read_text(encoding="utf-8")
            except (OSError, ValueError):
                continue
            self._texts[name] = (path, stamp, text)
            return text
        return None

    def in_first_root(self, name: str) -> bool:
        """Whether a file that has been read stands there, or in no root: virtual and made ones."""
        held = self._texts.get(name)
        return held is None or held[0] == self.roots[0] / name

    def words(self, name: str) -> frozenset[str]:
        """All words of a file as it is now, comments included; looked for once for each text."""
        text = self.read(name) or ""
        held = self._words.get(name)
        if held is None or held[0] is not text:
            # One string for a word that many files have.
            held = self._words[name] = (text, frozenset(map(sys.intern, _WORD.findall(text))))
        return held[1]

    def poll(self) -> set[str]:
        """Look at the files read so far and forget those whose text changed (or went away); their names."""
        changed: set[str] = set()
        for name, (path, stamp, text) in list(self._texts.items()):
            try:
                now = _stamp(path)
                if now == stamp:
                    continue
                fresh = path.read_text(encoding="utf-8")
            except (OSError, ValueError):
                # Editors replace files: a missing one counts as changed, and is read again when it is back.
                del self._texts[name]
                changed.add(name)
                continue
            self._texts[name] = (path, now, fresh)
            if fresh != text:
                changed.add(name)
        return changed

    def names(self) -> list[str]:
        """All names that can be included, for error messages."""
        found = {*self._virtual, *MADE}
        for root in self.roots:
            found.update(p.relative_to(root).as_posix() for p in root.rglob("*") if p.is_file())
        return sorted(found)

    # -- expansion ---------------------------------------------------------------------------------------------------

    def expand(self, name: str, defines: Defines | None = None) -> Expanded:
        """One stage's text with everything included. ShaderError names the line of an include that cannot be found."""
        work = _Expansion(name)
        self._expand_file(work, name, None)
        head = [VERSION]
        places = [("<defines>", 1)]
        for extension, place in work.extensions:
            head.append(extension)
            places.append(place)
        for key, value in sorted((defines or {}).items()):
            if value is None:
                continue
            if not _NAME.match(key):
                raise ShaderError(name, f"define {key!r} is not a GLSL identifier")
            head.append(f"#define {key} {int(value) if isinstance(value, bool) else value}")
            places.append(("<defines>", len(head)))
        text = "\n".join(head + work.lines) + "\n"
        return Expanded(name, text, places + work.table, frozenset(work.files), frozenset(work.contracts))

    def _expand_file(self, work: _Expansion, name: str, place: tuple[str, int] | None) -> None:
        text = self.read(name)
        work.files.add(name)
        if text is None:
            near = difflib.get_close_matches(name, self.names(), 1, 0.5)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            roots = ", ".join(str(root) for root in self.roots)
            what = f"no file {name!r} under {roots}{hint}"
            messages = [ShaderMessage(*place, f"cannot include {name!r}{hint}")] if place else []
            raise ShaderError(work.name, what, messages)
        if work.depth == 0:
            work.done.add(name)
        work.stack.append(name)
        for piece in self._pieces(name, text):
            work.lines += piece.lines
            work.table += piece.table
            work.extensions += piece.extensions
            work.depth += piece.depth
            if piece.include is not None:
                self._include(work, piece.include[0], piece.include[1])
        work.stack.pop()

    def _pieces(self, name: str, text: str) -> list[_Piece]:
        """A file up to each include and after the last: looked through once, because programs share most files."""
        held = self._parsed.get(name)
        if held is None or held[0] is not text:
            held = self._parsed[name] = (text, _parse(name, text))
        return held[1]

    def _include(self, work: _Expansion, target: str | None, place: tuple[str, int]) -> None:
        if not target:
            expected = ShaderMessage(*place, 'expected #include "folder/file.glsl"')
            raise ShaderError(work.name, "malformed #include", [expected])
        if target.startswith("contract/"):
            contract = target.removeprefix("contract/").removesuffix(".glsl")
            work.contracts.add(contract)
            target = self.provider(contract)
        elif self.read(target) is None:
            beside = (Path(place[0]).parent / target).as_posix()
            target = beside if self.read(beside) is not None else target
        if target in work.done or target in work.stack:
            work.add("", *place)
            return
        # A file first included inside an #if may be skipped there, so it is written again later, behind a guard.
        guard = "PF_INCLUDED_" + re.sub(r"\W", "_", target)
        work.add(f"#ifndef {guard}", *place)
        work.add(f"#define {guard}", *place)
        self._expand_file(work, target, place)
        work.add("#endif", *place)


def _parse(name: str, text: str) -> list[_Piece]:
    pieces = [_Piece()]
    in_comment = False
    for number, line in enumerate(text.splitlines(), 1):
        piece, place, shown = pieces[-1], (name, number), ""
        was_comment = in_comment
        if in_comment or "/*" in line:
            in_comment = _comment_open(line, in_comment)
        if "#" not in line:  # nearly all
            shown = line
        elif was_comment:
            shown = _defuse(line)
        elif include := _INCLUDE.match(line):
            piece.include = (include[1], place)
            pieces.append(_Piece())
            continue
        elif _EXTENSION.match(line):
            piece.extensions.append((line, place))  # must stand before any code, wherever it was written
        elif not _DROP.match(line):
            if _IF.match(line):
                piece.depth += 1
            elif _ENDIF.match(line):
                piece.depth -= 1
            shown = _defuse(line)
        piece.lines.append(shown)
        piece.table.append(place)
    return pieces


def _stamp(path: Path) -> tuple[int, int]:
    info = path.stat()
    return info.st_mtime_ns, info.st_size


def _defuse(line: str) -> str:
    # moderngl resolves whatever looks like an include, comments too: break the word.
    return line.replace("#include", "# include") if "#include" in line else line


def _comment_open(line: str, inside: bool) -> bool:
    """Whether a block comment is open after this line."""
    position = 0
    while True:
        if inside:
            position = line.find("*/", position)
            if position < 0:
                return True
            position, inside = position + 2, False
        else:
            start, line_comment = line.find("/*", position), line.find("//", position)
            if start < 0 or 0 <= line_comment < start:
                return False
            position, inside = start + 2, True
