"""The objects that a plan owns: made in one go, or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from .backend import GraphBackend
from .errors import GraphError
from .lifetimes import Key, Shared
from .resources import BufferSpec, CreatedSpec, Kind, TextureSpec
from .sizes import ViewSizes


class Storage:
    """Textures, buffers and framebuffers of one plan at one size of its views.

    objects: by key; new: the keys that were created now (the rest was taken over from `keep`). Raises GraphError for
    a size beyond the backend's limit, and whatever the backend raises (with a note naming the resource); then nothing
    that was created here is left.
    """

    def __init__(
        self,
        backend: GraphBackend,
        specs: Mapping[Key, CreatedSpec],
        view_sizes: ViewSizes,
        keep: Mapping[Key, object],
    ) -> None:
        self._backend = backend
        self._framebuffers: dict[tuple[int, ...], object] = {}
        self.objects: dict[Key, object] = {}
        self.new: list[Key] = []
        sizes = {key: view_sizes.resolve(spec) for key, spec in specs.items()}
        for key, spec in specs.items():
            limit = backend.max_texture_size
            if isinstance(spec, TextureSpec) and max(sizes[key]) > limit:
                raise GraphError(
                    f"texture {spec.name!r} would be {sizes[key]} texels for a view of {view_sizes.of(spec.name)}; this"
                    f" GPU's limit is {limit}. Render a smaller view, or give the texture a smaller size."
                )
        try:
            for key, spec in specs.items():
                if key in keep:
                    self.objects[key] = keep[key]
                    continue
                try:
                    obj = _create(backend, spec, sizes[key])
                except Exception as error:
                    error.add_note(f"while the frame graph created {spec.name!r}: {spec}, size {sizes[key]}")
                    raise
                self.objects[key] = obj
                self.new.append(key)
        except BaseException:
            self.discard()
            raise

    def framebuffer(self, colors: tuple[object, ...], depth: object | None) -> object:
        """A framebuffer on these textures; equal requests share one."""
        key = (*(id(texture) for texture in colors), 0 if depth is None else id(depth))
        if key not in self._framebuffers:
            self._framebuffers[key] = self._backend.framebuffer(colors, depth)
        return self._framebuffers[key]

    def discard(self) -> None:
        """Release the framebuffers and what was created here; what was kept stays with its earlier owner."""
        self._release_framebuffers()
        for key in self.new:
            self._backend.release(self.objects[key])
        self.objects = {}
        self.new = []

    def release(self, keep: Mapping[Key, object] | None = None) -> None:
        """Release everything but the objects in `keep`."""
        kept = {id(obj) for obj in (keep or {}).values()}
        self._release_framebuffers()
        for obj in self.objects.values():
            if id(obj) not in kept:
                self._backend.release(obj)
        self.objects = {}
        self.new = []

    def bytes_of(self, key: Key) -> int:
        """Bytes of one object."""
        return self._backend.bytes_of(self.objects[key])

    def memory_bytes(self) -> int:
        """Bytes of all textures and buffers."""
        return sum(self._backend.bytes_of(obj) for obj in self.objects.values())

    def _release_framebuffers(self) -> None:
        for framebuffer in self._framebuffers.values():
            self._backend.release(framebuffer)
        self._framebuffers = {}


def _create(backend: GraphBackend, spec: CreatedSpec, size: tuple[int, ...]) -> object:
    if isinstance(spec, BufferSpec):
        return backend.create_buffer(spec)
    return backend.create_texture(spec, size)


def take_over(
    old: Storage,
    old_specs: Mapping[Key, CreatedSpec],
    old_sizes: ViewSizes,
    specs: Mapping[Key, CreatedSpec],
    sizes: ViewSizes,
) -> dict[Key, object]:
    """Which of the old objects fit the new specs: same key for persistent and history, any of one kind for shared."""
    if old_specs is specs:  # a resize: everything stays what it was
        return {
            key: old.objects[key]
            for key, spec in specs.items()
            if key in old.objects and (not spec.relative or old_sizes.resolve(spec) == sizes.resolve(spec))
        }
    fits = {key: _kind(spec, old_sizes) for key, spec in old_specs.items() if key in old.objects}
    spare: dict[_Kind, list[object]] = {}
    for key, kind in fits.items():
        if isinstance(key, Shared):
            spare.setdefault(kind, []).append(old.objects[key])
    keep: dict[Key, object] = {}
    for key, spec in specs.items():
        kind = _kind(spec, sizes)
        if isinstance(key, Shared):
            candidates = spare.get(kind)
            if candidates:
                keep[key] = candidates.pop(0)
        elif fits.get(key) == kind:
            keep[key] = old.objects[key]
    return keep


class _Kind(NamedTuple):
    """What objects have to have in common to be taken over."""

    kind: Kind
    size: tuple[int, ...]


def _kind(spec: CreatedSpec, sizes: ViewSizes) -> _Kind:
    return _Kind(spec.pool_key(), sizes.resolve(spec))
