"""Methods: one at a time, with its shader contracts and GL objects; one that cannot be made leaves what was there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest

from planetfall.engine.frame import Views
from planetfall.engine.methods import Method, Methods


class _Shaders:
    def __init__(self) -> None:
        self.provided: dict[str, str] = {}

    def withdraw(self, owner: str) -> None:
        self.provided.clear()

    def provide(self, contract: str, file: str, owner: str) -> None:
        self.provided[contract] = file


class _Scope:
    owner = "air"

    def __init__(self, gpu: Any = None) -> None:
        self.gpu, self.released = self if gpu is None else gpu, 0
        self.shaders = _Shaders()

    def beside(self, owner: str) -> _Scope:
        return _Scope(self.gpu)

    def release(self) -> None:
        self.released += 1


class _Ours(Method):
    contracts: ClassVar[Mapping[str, str]] = {"air": "ours.glsl", "sky": "sky.glsl"}

    def update(self, frame: Any) -> None: ...
    def declare(self, builder: Any, view: Any) -> None: ...


class _Paper(_Ours):
    contracts: ClassVar[Mapping[str, str]] = {"air": "paper.glsl"}


def test_another_method_takes_the_place_of_the_one_before_with_all_it_kept() -> None:
    scope: Any = _Scope()
    views = Views()
    methods: Methods[Method] = Methods(scope, views)
    assert methods.use(_Ours, _Ours) and not methods.use(_Ours, _Ours)
    ours, seen = methods.now, {}
    views[0].state(ours, lambda: seen)
    assert methods.changed() and not methods.changed()
    ours.structure += 1
    assert methods.changed() and not methods.changed()
    assert methods.use(_Paper, lambda gpu: seen.update(scope.shaders.provided) or _Paper(gpu))
    assert seen == {"air": "paper.glsl"}, "its shaders are compiled with its own contracts"
    assert scope.shaders.provided == seen and methods.changed()
    assert ours.gpu.released == 1 and views[0].found(ours) is None  # type: ignore[attr-defined]
    assert methods.use(_Paper, _Paper, 2018) and not methods.use(_Paper, _Paper, 2018)
    methods.release()
    assert not scope.shaders.provided
    assert methods.use(_Ours, _Ours), "a system may be set up again"


def test_a_method_that_cannot_be_made_leaves_the_one_before() -> None:
    scope: Any = _Scope()
    methods: Methods[Method] = Methods(scope, Views())
    methods.use(_Ours, _Ours)
    ours, made = methods.now, []

    def broken(gpu: Any) -> Method:
        made.append(gpu)
        raise RuntimeError("does not compile")

    with pytest.raises(RuntimeError, match="compile"):
        methods.use(_Paper, broken)
    assert methods.now is ours and ours.gpu.released == 0 and made[0].released == 1  # type: ignore[attr-defined]
    assert scope.shaders.provided == _Ours.contracts
    assert not methods.use(_Ours, _Ours)
