"""The shader library of a context: programs by content, shared and counted, and rebuilt when their sources change."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import moderngl

from . import gl as G
from .compile_ahead import CompileAhead
from .errors import ShaderError, ShaderMessage
from .preprocess import Defines, Expanded, ShaderSources, map_log
from .work import Work

if TYPE_CHECKING:
    from .spirv import Module

__all__ = ["LinkedProgram", "ShaderLibrary", "Stages"]

log = logging.getLogger(__name__)

Stages = Mapping[str, str]
"""Stage name (vertex, fragment, geometry, tess_control, tess_evaluation, compute) -> file name."""

# GL types of samplers; image types are not among them: images have units of their own.
_SAMPLER_TYPES = {
    *range(0x8B5D, 0x8B63), *range(0x8DC0, 0x8DC6), *range(0x8DC9, 0x8DD9), 0x8DC1, 0x8B63, 0x8B64,
    *range(0x9108, 0x910E), *range(0x900C, 0x9010),
}  # fmt: skip


GLProgram: TypeAlias = moderngl.Program | moderngl.ComputeShader


class LinkedProgram:
    """One GL program, shared by all wrappers whose expanded sources are equal; linked when `mgl` is first asked for.
    A scene has dozens that no picture of it may ever need, at a megabyte and some milliseconds each.

    `holder` is the wrapper whose uniform values are in it at the moment.
    """

    def __init__(self, key: str, link: Callable[[], GLProgram], ahead: int | None = None) -> None:
        self.key, self.ahead = key, ahead
        """ahead: the program that the driver compiles in its own threads, until this one is linked."""
        self._link: Callable[[], GLProgram] | None = link
        self._mgl: GLProgram | None = None
        self.references = 0
        self.holder: object | None = None
        self.modules: dict[str, Module] = {}
        """By stage what a reference compiler makes of it, where one is asked (`ShaderLibrary.check`)."""
        self.files: dict[str, str] = {}

    @property
    def is_linked(self) -> bool:
        return self._mgl is not None

    @property
    def mgl(self) -> GLProgram:
        """moderngl's object. ShaderError where the driver refuses the sources."""
        if self._mgl is None:
            assert self._link is not None
            self._mgl = self._link()
            self._link = self.ahead = None  # with it go the sources
        return self._mgl


class _Wrapper(Protocol):
    error: ShaderError | None

    @property
    def name(self) -> str: ...
    def refresh(self, changed: set[str] | None) -> bool: ...


class ShaderLibrary:
    """Shader files under `roots`, the programs made of them, contracts, virtual files and hot reload.

    Names are relative to the roots ("terrain/gbuffer.frag"). `base_defines` stand in every stage. `ahead`: who has the
    driver compile before programs are used. Those are linked at their first use, and, where `late`, those whose files
    all lie in the first root, the package's own; all others when they are acquired, so that a game hears of its
    mistakes at once.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        gl: G.GL,
        roots: Iterable[Path | str],
        base_defines: Defines,
        work: Work,
        ahead: CompileAhead | None = None,
        late: bool = False,
    ) -> None:
        self.ctx, self._gl = ctx, gl
        self.late = late
        self.sources = ShaderSources(roots)
        self.base_defines = dict(base_defines)
        self._work = work
        self._ahead = ahead
        self._linked: dict[str, LinkedProgram] = {}
        self._waiting: dict[str, LinkedProgram] = {}
        self._wrappers: dict[int, _Wrapper] = {}
        self.check: Callable[[Mapping[str, Expanded]], dict[str, Module]] | None = None
        """Asked before a program is linked; raises ShaderError for what other compilers would refuse (validate.py)."""

    # -- sources -----------------------------------------------------------------------------------------------------

    def add_virtual(self, name: str, text: str) -> None:
        """Make `#include "name"` mean this text (generated blocks). Programs follow when the text changes."""
        self.sources.add_virtual(name, text)

    def provide(self, contract: str, file: str, owner: str) -> None:
        """Answer `#include "contract/<contract>.glsl"` with `file` until withdraw(owner). Programs follow at next use.

        ValueError when another owner provides it already.
        """
        self.sources.provide(contract, file, owner)

    def withdraw(self, owner: str) -> None:
        """Take back every contract of this owner; the default assets/shaders/common/<contract>.glsl answers again."""
        self.sources.withdraw(owner)

    def expand(self, stages: Stages, defines: Defines | None = None) -> dict[str, Expanded]:
        """All stages expanded, with the base defines underneath."""
        merged = {**self.base_defines, **(defines or {})}
        return {stage: self.sources.expand(file, merged) for stage, file in stages.items()}

    # -- programs ----------------------------------------------------------------------------------------------------

    @staticmethod
    def key_of(expanded: Mapping[str, Expanded]) -> str:
        return "|".join(f"{stage}:{e.key}" for stage, e in sorted(expanded.items()))

    def acquire(self, expanded: Mapping[str, Expanded], program_name: str, at_once: bool = False) -> LinkedProgram:
        """The program of these sources, compiled if need be, with one more reference. ShaderError maps the log.

        Where the program is linked later, it raises at the first use, unless it has to be linked `at_once`.
        """
        key = self.key_of(expanded)
        linked = self._linked.get(key)
        if linked is None:
            modules = self.check(expanded) if self.check is not None else {}
            linked = self._begin(key, expanded, program_name)
            if at_once or not (linked.ahead is not None or (self.late and self._all_ours(expanded))):
                _ = linked.mgl
            else:
                self._waiting[key] = linked
            self._linked[key] = linked
            linked.modules = modules
            linked.files = {stage: each.name for stage, each in expanded.items()}
            self._work.programs_built += 1
        elif at_once:
            _ = linked.mgl
        linked.references += 1
        return linked

    def give_back(self, linked: LinkedProgram) -> None:
        """Drop a reference; the last one frees the GL program."""
        linked.references -= 1
        if linked.references == 0:
            del self._linked[linked.key]
            self._waiting.pop(linked.key, None)
            if self._ahead is not None and linked.ahead is not None:
                self._ahead.drop(linked.ahead)
            if not linked.is_linked:
                return
            if self._gl.integer(G.CURRENT_PROGRAM) == linked.mgl.glo:
                self._gl.function("glUseProgram", None, G.uint)(0)  # GL keeps a program alive while it is in use
            linked.mgl.release()

    def link_another(self) -> None:
        """Link one of those that nothing has used yet, for frames that must not wait for a compiler later. One that is
        broken just then is left to its first use."""
        while self._waiting:
            _, linked = self._waiting.popitem()
            if not linked.is_linked:
                with suppress(ShaderError):
                    _ = linked.mgl
                return

    def _all_ours(self, expanded: Mapping[str, Expanded]) -> bool:
        return all(self.sources.in_first_root(file) for each in expanded.values() for file in each.files)

    @property
    def programs(self) -> tuple[LinkedProgram, ...]:
        """All that are acquired, linked or not."""
        return tuple(self._linked.values())

    @property
    def program_count(self) -> int:
        """Programs acquired, each counted once however many share it; some may not be linked yet."""
        return len(self._linked)

    def _begin(self, key: str, expanded: Mapping[str, Expanded], name: str) -> LinkedProgram:
        ahead, compiling = self._ahead, None
        if ahead is not None:
            compiling = ahead.begin({stage: e.text for stage, e in expanded.items()})

        def link() -> GLProgram:
            if ahead is not None and linked.ahead is not None:
                ahead.wait(linked.ahead)
                linked.ahead = None  # it is gone, whether this one can be linked or not
            return self._link(expanded, name)

        linked = LinkedProgram(key, link, compiling)
        return linked

    def _link(self, expanded: Mapping[str, Expanded], name: str) -> GLProgram:
        sources: dict[str, Any] = {f"{stage}_shader": e.text for stage, e in expanded.items()}
        try:
            if "compute" in expanded:
                program: GLProgram = self.ctx.compute_shader(sources["compute_shader"])
            else:
                program = self.ctx.program(**sources)
        except (moderngl.Error, KeyError) as error:
            text = str(error)
            what = "linking failed" if "Linker" in text else "compilation failed"
            raise ShaderError(name, what, map_log(text, expanded), text) from None
        self._gl.detach_shaders(program.glo)  # they keep their text, and compiled anew their whole syntax tree
        clash = _unit_clash(program)
        if clash:
            program.release()
            first, unit, second = clash
            where = _declaration(expanded, second)
            text = (
                f"samplers {first!r} and {second!r} of different types share texture unit {unit}: "
                "give each its own layout(binding = N)"
            )
            raise ShaderError(name, "sampler units clash", [ShaderMessage(*where, text)])
        return program

    # -- hot reload --------------------------------------------------------------------------------------------------

    def register(self, wrapper: _Wrapper) -> None:
        self._wrappers[id(wrapper)] = wrapper

    def unregister(self, wrapper: _Wrapper) -> None:
        self._wrappers.pop(id(wrapper), None)

    def reload_changed(self) -> list[str]:
        """Look for changed files and rebuild the programs that use them; the names of those rebuilt.

        A program that fails keeps running in its last good form; its error stands in `errors` until it is repaired.
        Costs a stat per file: call it a few times a second at most.
        """
        changed = self.sources.poll()
        reloaded: list[str] = []
        for wrapper in list(self._wrappers.values()):
            if wrapper.refresh(changed):
                log.info("shader %s reloaded", wrapper.name)
                reloaded.append(wrapper.name)
        return reloaded

    @property
    def errors(self) -> list[ShaderError]:
        """The current error of each program that could not be rebuilt."""
        return [w.error for w in self._wrappers.values() if w.error is not None]


def _unit_clash(program: GLProgram) -> tuple[str, int, str] | None:
    """Two samplers of different types on one unit: draws are lost, and some drivers abort the process."""
    units: dict[int, tuple[str, int]] = {}
    for name in program:
        member = program[name]
        kind = getattr(member, "gl_type", None)
        if not isinstance(member, moderngl.Uniform) or kind not in _SAMPLER_TYPES:
            continue
        value = member.value
        for unit in value if isinstance(value, list) else [value]:
            held = units.setdefault(unit, (name, kind))
            if held[1] != kind:
                return held[0], unit, name
    return None


def _declaration(expanded: Mapping[str, Expanded], uniform: str) -> tuple[str, int]:
    pattern = re.compile(rf"\buniform\b.*\b{re.escape(uniform)}\b")
    for stage in expanded.values():
        for number, line in enumerate(stage.text.splitlines()):
            if pattern.search(line) and number < len(stage.table):
                return stage.table[number]
    return "", 0


def describe(stages: Stages) -> str:
    """A program's name in messages: its files joined."""
    return " + ".join(dict.fromkeys(stages.values()))


def unknown_uniform(name: str, program: str, members: Iterable[str]) -> str:
    known = ", ".join(sorted(members))
    return f"program {program} has no uniform {name!r}, and no source of it mentions one; it has {known}"
