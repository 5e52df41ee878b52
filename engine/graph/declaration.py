"""One pass as it was declared, with the checks that need no other pass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

from .errors import GraphError, did_you_mean
from .names import Scope
from .pass_io import PassIO
from .resources import BufferSpec, CreatedSpec, TextureSpec
from .stages import STAGES

PassKind = Literal["raster", "compute", "copy"]
Run = Callable[[], object]
"""What a pass does in a frame."""
Bind = Callable[[PassIO], Run]
"""Looks everything up and returns the Run; called at compile and again after a resize."""


@dataclass(frozen=True, slots=True)
class PassDecl:
    """A declared pass; the fields are the arguments of `GraphBuilder.add_pass`, and the scope of the builder. Name and
    creates are qualified from the start, what is named of others at compile."""

    name: str
    bind: Bind
    creates: tuple[CreatedSpec, ...]
    reads: tuple[str, ...]
    reads_optional: tuple[str, ...]
    writes: tuple[str, ...]
    after: tuple[str, ...]
    after_optional: tuple[str, ...]
    stage: str
    history: tuple[str, ...]
    when: Callable[[], object] | None
    only_while: Callable[[], object] | None
    side_effect: bool
    kind: PassKind
    system: str
    help: str
    scope: Scope

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise GraphError(f"add_pass: the name must be a non-empty string, found {self.name!r}.")
        where = f"pass {self.name!r}"
        if not callable(self.bind):
            raise GraphError(f"{where}: bind={self.bind!r} is not callable; give a function of (io: PassIO).")
        if self.when is not None and not callable(self.when):
            raise GraphError(f"{where}: when={self.when!r} is not callable; give a function without arguments or None.")
        if self.only_while is not None and not callable(self.only_while):
            raise GraphError(
                f"{where}: only_while={self.only_while!r} is not callable; give a function without arguments or None."
            )
        if self.kind not in get_args(PassKind):
            hint = did_you_mean(str(self.kind), get_args(PassKind), listing=False)
            raise GraphError(f"{where}: kind={self.kind!r} is not one of 'raster', 'compute', 'copy'.{hint}")
        self._check_stage(where)
        self._check_creates(where)
        for field in ("reads", "reads_optional", "writes", "after", "after_optional", "history"):
            _check_names(where, field, getattr(self, field))
        self._check_against_each_other(where)

    def _check_stage(self, where: str) -> None:
        if self.stage == "":
            return
        if self.stage not in STAGES:
            hint = did_you_mean(str(self.stage), STAGES, listing=False) or f" The stages are {', '.join(STAGES)}."
            raise GraphError(f"{where}: stage={self.stage!r} is no stage.{hint}")
        if not self.writes:
            raise GraphError(f"{where}: stage={self.stage!r} is the place of a write, but writes= is empty; drop it.")

    def _check_creates(self, where: str) -> None:
        for spec in self.creates:
            if not isinstance(spec, (TextureSpec, BufferSpec)):
                raise GraphError(f"{where}: creates= holds {spec!r}; give TextureSpec(...) or BufferSpec(...).")
        names = [spec.name for spec in self.creates]
        for name in names:
            if names.count(name) > 1:
                raise GraphError(f"{where} creates {name!r} twice; a resource has one spec: drop one of the two.")
        if self.when is not None:
            for spec in self.creates:
                if spec.lifetime != "persistent":
                    raise GraphError(
                        f"{where} has a when= but creates {spec.name!r} with lifetime={spec.lifetime!r}: in a frame in"
                        " which it is skipped the content would be undefined. Use lifetime='persistent', or drop when=."
                    )

    def _check_against_each_other(self, where: str) -> None:
        created = {spec.name for spec in self.creates}
        for name in self.writes:
            if name in created:
                raise GraphError(
                    f"{where} both creates and writes {name!r}; a creator writes anyway: drop it from writes=."
                )
        for name in (*self.reads, *self.reads_optional):
            if name in created:
                raise GraphError(
                    f"{where} both creates and reads {name!r}; drop it from reads=, or name it in history= (with"
                    " lifetime='history') if last frame's content is meant."
                )
        for name in (*self.after, *self.after_optional):
            if name == self.name:
                raise GraphError(f"{where} is declared after itself; drop it from after=.")


def _check_names(where: str, field: str, names: object) -> None:
    if isinstance(names, str):
        raise GraphError(f"{where}: {field}={names!r} is a string; give a tuple of names: {field}=({names!r},).")
    if not isinstance(names, tuple):
        raise GraphError(f"{where}: {field}={names!r}; give a tuple of names.")
    for name in names:
        if not isinstance(name, str):
            raise GraphError(f"{where}: {field}= holds {name!r}; give names (strings).")
