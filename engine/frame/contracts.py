"""What the providers of shader contracts read on the GPU.

A contract's text comes from the shader library (`provide`); the textures that this text samples come from here. A pass
whose shaders include a contract adds `contract_reads(world)` to what it reads and calls what
`bind_contracts(world, io)` returns before it draws. Without providers both are empty.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from ..world import World

if TYPE_CHECKING:
    from ..graph import PassIO

__all__ = ["ContractSource", "bind_contracts", "contract_reads", "provide_contracts", "withdraw_contracts"]

_KEY = "shader_contracts"


class ContractSource(Protocol):
    """A system that provides contracts."""

    def contract_reads(self) -> tuple[str, ...]:
        """Resources of the frame graph that its contracts sample."""
        ...

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """Look everything up for one pass; what is returned binds it, each frame."""
        ...


def provide_contracts(world: World, owner: str, source: ContractSource) -> None:
    """From now on passes read what this source's contracts need."""
    world.set_resource(_KEY, {**(world.try_resource(_KEY) or {}), owner: source})


def withdraw_contracts(world: World, owner: str) -> None:
    """The opposite of provide_contracts."""
    left = {name: source for name, source in (world.try_resource(_KEY) or {}).items() if name != owner}
    world.set_resource(_KEY, left)


def contract_reads(world: World, but: str = "") -> tuple[str, ...]:
    """Names for reads= of a pass whose shaders include contracts. but: a provider whose passes do without its own."""
    return tuple(name for source in _sources(world, but) for name in source.contract_reads())


def _sources(world: World, but: str) -> list[ContractSource]:
    found: dict[str, ContractSource] = world.try_resource(_KEY) or {}
    return [source for name, source in found.items() if name != but]


def bind_contracts(world: World, io: PassIO, but: str = "") -> Callable[[], None]:
    """Binds what contracts sample; call the result before each draw or dispatch. but: as for contract_reads."""
    binds = [source.bind_contract(io) for source in _sources(world, but)]
    if len(binds) == 1:
        return binds[0]

    def run() -> None:
        for bind in binds:
            bind()

    return run
