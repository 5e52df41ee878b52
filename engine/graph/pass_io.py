"""What a pass sees of the graph while it is bound."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, cast

from .errors import GraphError, did_you_mean
from .names import Names, Scope
from .resources import BufferSpec, CreatedSpec, ImportSpec, TextureSpec
from .sizes import ViewSizes

if TYPE_CHECKING:  # what the backend of engine/gpu makes; the graph itself knows no GL
    from moderngl import Buffer, Framebuffer, Texture


class Slot:
    """The place of an import: `.value` is what is lent, or what `Plan.bind_import` put there, read it each frame."""

    __slots__ = ("name", "value")

    def __init__(self, name: str, value: object = None) -> None:
        self.name = name
        self.value: Any = value


class Flag:
    """A bool behind a reference, so that prepared closures see changes: `.value`."""

    __slots__ = ("value",)

    def __init__(self, value: bool) -> None:
        self.value = value


class AllFlags:
    """`.value` is True when all of several flags are."""

    __slots__ = ("_flags",)

    def __init__(self, flags: Sequence[Flag]) -> None:
        self._flags = tuple(flags)

    @property
    def value(self) -> bool:
        """True when every flag is set."""
        return all(flag.value for flag in self._flags)


@dataclass(slots=True)
class ResourceTable:
    """Where a PassIO finds things in frames of one parity."""

    names: Names
    sizes: ViewSizes
    parity: int
    specs: dict[str, CreatedSpec]
    imports: dict[str, ImportSpec]
    slots: dict[str, Slot]
    current: dict[str, object]
    last_frame: dict[str, object]
    valid: dict[str, Flag]
    readers: dict[str, frozenset[str]]
    framebuffer: Callable[[tuple[object, ...], object | None], object]


class MayUse(Protocol):
    """What a PassIO asks of a declared pass: who it is, and the resources that it has named."""

    @property
    def name(self) -> str: ...
    @property
    def scope(self) -> Scope: ...
    @property
    def creates(self) -> tuple[CreatedSpec, ...]: ...
    @property
    def reads(self) -> tuple[str, ...]: ...
    @property
    def reads_optional(self) -> tuple[str, ...]: ...
    @property
    def writes(self) -> tuple[str, ...]: ...
    @property
    def history(self) -> tuple[str, ...]: ...


class PassIO:
    """Handed to bind(): every look-up of a pass, limited to what the pass has declared.

    Names mean what they mean in the scope that declared the pass: "gbuffer.depth" is its own view's. Objects stay the
    same until the next bind, so keep them in the returned closure. Errors are GraphErrors that name
    the pass, the resource and the remedy.
    """

    __slots__ = ("_decl", "_table")

    def __init__(self, decl: MayUse, table: ResourceTable) -> None:
        self._decl = decl
        self._table = table

    @property
    def pass_name(self) -> str:
        """Qualified name of the pass that is bound."""
        return self._decl.name

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels of the view that the pass belongs to; the plan's for a pass that views share."""
        return self._table.sizes.of_view(self._decl.scope.view)

    @property
    def parity(self) -> int:
        """0 or 1: which of the two objects of a history resource is this frame's in the closure being bound."""
        return self._table.parity

    def has(self, name: str) -> bool:
        """True when the resource or import exists in this graph; for names in reads_optional."""
        name = self._full(name)
        return name in self._table.current or name in self._table.imports

    def readers(self, name: str) -> frozenset[str]:
        """Who reads that resource in this graph: names of running passes without their view and planet, and "" where it
        is exported. For a pass that can leave out what nobody looks at."""
        return self._table.readers.get(self._full(name), frozenset())

    def texture(self, name: str) -> Texture:
        """This frame's texture of that name (created, read or written by this pass)."""
        return cast("Texture", self._object(name, TextureSpec, "texture"))

    def buffer(self, name: str) -> Buffer:
        """This frame's buffer of that name (created, read or written by this pass)."""
        return cast("Buffer", self._object(name, BufferSpec, "buffer"))

    def history(self, name: str) -> Any:
        """Last frame's texture or buffer of a history resource; undefined content while `history_valid` is False."""
        name = self._full(name)
        self._check_history(name)
        return self._table.last_frame[name]

    @property
    def history_valid(self) -> Flag | AllFlags:
        """`.value`, read each frame: all that this pass has in history= holds last frame's content."""
        if not self._decl.history:
            raise GraphError(
                f"pass {self._decl.name!r} asks for history_valid but has nothing in history=; add the resource there."
            )
        flags = [self._table.valid[name] for name in self._decl.history]
        return flags[0] if len(flags) == 1 else AllFlags(flags)

    def history_valid_for(self, name: str) -> Flag:
        """`.value`, read each frame: this one history resource holds last frame's content."""
        name = self._full(name)
        self._check_history(name)
        return self._table.valid[name]

    def imported(self, name: str) -> Slot:
        """The slot of an import: read `.value` each frame, the host may change it."""
        name = self._full(name)
        if name not in self._table.imports:
            if name in self._table.specs:
                raise GraphError(
                    f"pass {self._decl.name!r}: imported({name!r}) is no import, a pass creates it; use io.texture() or"
                    " io.buffer()."
                )
            hint = did_you_mean(name, self._table.imports)
            raise GraphError(
                f"pass {self._decl.name!r}: imported({name!r}) is unknown; declare it with builder.import_().{hint}"
            )
        self._check_declared(name)
        return self._table.slots[name]

    def framebuffer(self, colors: Sequence[str] = (), depth: str | None = None) -> Framebuffer:
        """A framebuffer on textures of this frame, owned by the graph and shared by equal requests.

        colors: created or written by this pass. depth: likewise, or only read (depth test without depth writes).
        """
        if isinstance(colors, str):
            raise GraphError(
                f"pass {self._decl.name!r}: framebuffer(colors={colors!r}) is a string; give a tuple: ({colors!r},)."
            )
        if not colors and depth is None:
            raise GraphError(f"pass {self._decl.name!r}: framebuffer() without attachments; name colors or depth.")
        colors, depth = tuple(map(self._full, colors)), None if depth is None else self._full(depth)
        writable = {*self._decl.writes, *(spec.name for spec in self._decl.creates)}
        for name in colors:
            if name not in writable and name in self._table.specs:
                raise GraphError(
                    f"pass {self._decl.name!r} attaches {name!r} as a colour but only reads it; add it to writes=."
                )
        names = [*colors, *((depth,) if depth is not None else ())]
        textures = [self.texture(name) for name in names]
        sizes = {name: self.resource_size(name) for name in names}
        if len(set(sizes.values())) > 1:
            raise GraphError(
                f"pass {self._decl.name!r}: attachments of different sizes: {sizes}; give their specs one size."
            )
        count = len(colors)
        made = self._table.framebuffer(tuple(textures[:count]), textures[count] if depth is not None else None)
        return cast("Framebuffer", made)

    def copy_source(self, name: str) -> Framebuffer:
        """A framebuffer to copy a texture from that this pass reads."""
        return cast("Framebuffer", self._table.framebuffer((self.texture(name),), None))

    def resource_size(self, name: str) -> tuple[int, ...]:
        """(w, h) or (w, h, d) texels of a texture, (bytes,) of a buffer; not known for imports."""
        name = self._full(name)
        spec = self._table.specs.get(name)
        if spec is None:
            raise self._unknown(name, "resource_size")
        if name not in self._decl.history:
            self._check_declared(name)
        return self._table.sizes.resolve(spec)

    def _full(self, name: str) -> str:
        try:
            return self._table.names.find(name, self._decl.scope)
        except GraphError as error:
            raise GraphError(f"pass {self._decl.name!r}: {error}") from None

    def _object(self, name: str, wanted: type, call: str) -> object:
        name = self._full(name)
        spec = self._table.specs.get(name)
        if spec is None:
            raise self._unknown(name, call)
        if not isinstance(spec, wanted):
            other = "buffer" if call == "texture" else "texture"
            raise GraphError(f"pass {self._decl.name!r}: {name!r} is a {other}; use io.{other}({name!r}).")
        self._check_declared(name)
        return self._table.current[name]

    def _unknown(self, name: str, call: str) -> GraphError:
        if name in self._table.imports:
            return GraphError(
                f"pass {self._decl.name!r}: {call}({name!r}) is an import and bound late; use"
                f" io.imported({name!r}).value in the closure."
            )
        hint = did_you_mean(name, self._table.specs)
        return GraphError(f"pass {self._decl.name!r}: {call}({name!r}) is unknown, no pass creates it.{hint}")

    def _check_declared(self, name: str) -> None:
        decl = self._decl
        if name in decl.reads or name in decl.writes or name in decl.reads_optional:
            return
        if any(spec.name == name for spec in decl.creates):
            return
        if name in decl.history:
            raise GraphError(
                f"pass {decl.name!r} has {name!r} only in history=; use io.history({name!r}) for last frame's content,"
                " or add it to reads= for this frame's."
            )
        raise GraphError(f"pass {decl.name!r} looks up {name!r} without declaring it; add it to reads= or writes=.")

    def _check_history(self, name: str) -> None:
        if name not in self._decl.history:
            raise GraphError(
                f"pass {self._decl.name!r} looks up the history of {name!r} without declaring it; add it to history=."
                + ("" if name in self._table.specs else did_you_mean(name, self._decl.history))
            )
