"""Device: one OpenGL context as the engine sees it, without the owners of objects on it."""

from __future__ import annotations

import contextlib
import logging
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Protocol

import moderngl

from . import gl as G
from .caps import Capabilities, check_version
from .compile_ahead import CompileAhead, compiles_ahead
from .limits import check_limits
from .preprocess import Defines
from .shaders import ShaderLibrary
from .software_threads import spread_threads
from .stale_uniforms import warn_of_stale_uniforms
from .state import State, reset_baseline
from .textures import AnyTexture, Data, TextureInfo
from .touching import CommandWatch
from .work import Work

__all__ = ["Device"]

log = logging.getLogger(__name__)


class Owner(Protocol):
    """Whose objects a device counts and releases: a GpuScope."""

    owner: str

    def counts(self) -> dict[str, int]: ...
    def bytes(self) -> int: ...
    def release(self) -> None: ...


class Device:
    """What scopes and their objects need of a `Gpu`, which has the arguments and fields in words."""

    def __init__(
        self,
        ctx: moderngl.Context,
        shader_roots: Iterable[Path | str],
        defines: Defines | None = None,
        compile_ahead: bool = False,
    ) -> None:
        check_version(ctx)
        self.ctx = ctx
        self.gl = G.GL(ctx)
        self.caps = Capabilities.read(ctx, self.gl)
        check_limits(self.gl, self.caps.renderer)
        self.work = Work()
        if self.caps.is_software:
            spread_threads()
            warn_of_stale_uniforms(self.caps.renderer)
        base = dict(defines or {})
        if not self.caps.has_clip_control:
            base["PF_FRAG_DEPTH"] = 1
            log.warning(
                "%s has no ARB_clip_control: depth is written by fragment shaders, which costs early depth tests",
                self.caps.renderer,
            )
        ahead = CompileAhead(self.gl) if compile_ahead and compiles_ahead(ctx, self.caps) else None
        self.shaders = ShaderLibrary(ctx, self.gl, shader_roots, base, self.work, ahead, late=compile_ahead)
        self.watch: CommandWatch | None = None
        """Hears what passes touch, for authors (validate.py)."""
        self._scopes: list[Owner] = []
        self._states: dict[tuple[tuple[str, Any], ...], State] = {}
        self._reset_baseline = reset_baseline(ctx, self.gl)
        self._frames: list[tuple[int, int]] = []
        self.default_state = self.state()

    # -- owners ------------------------------------------------------------------------------------------------------

    def count_in(self, scope: Owner) -> None:
        """Count and release this owner's objects with the others'."""
        self._scopes.append(scope)

    def forget(self, scope: Owner) -> None:
        if scope in self._scopes:
            self._scopes.remove(scope)

    def counts(self) -> dict[str, dict[str, int]]:
        """Live GL objects: owner -> kind -> number, without owners that have none.

        Kinds: texture, buffer, framebuffer, sampler, program, vertex_array, query (the timers of one plan). A program
        that several wrappers share counts for each of them.
        """
        totals: dict[str, Counter[str]] = {}
        for scope in self._scopes:
            found = scope.counts()
            if found:
                totals.setdefault(scope.owner, Counter()).update(found)
        return {owner: dict(kinds) for owner, kinds in sorted(totals.items())}

    def memory_bytes(self) -> dict[str, int]:
        """Bytes of textures and buffers by owner, without owners that have none; see GpuScope.bytes."""
        totals: Counter[str] = Counter()
        for scope in self._scopes:
            totals[scope.owner] += scope.bytes()
        return {owner: size for owner, size in sorted(totals.items()) if size}

    def release(self) -> None:
        """Release every scope. The context itself stays: it belongs to whoever made it."""
        for scope in list(self._scopes):
            scope.release()

    def leave(self, framebuffer: moderngl.Framebuffer) -> None:
        """Unbind a framebuffer that is about to go: moderngl would bind its name again later, which is a GL error."""
        if self.ctx.fbo is framebuffer:
            (self.ctx.screen or self.ctx.detect_framebuffer(0)).use()

    # -- frames and state --------------------------------------------------------------------------------------------

    def begin_frame(self) -> None:
        """Clip depth from 0 to 1, and a known state for all that passes do not set themselves. Nests."""
        if self.caps.has_clip_control:
            self._frames.append((self.gl.integer(G.CLIP_ORIGIN), self.gl.integer(G.CLIP_DEPTH_MODE)))
            self.gl.clip_control(G.LOWER_LEFT, G.ZERO_TO_ONE)
        self._reset_baseline()
        self.default_state.apply()

    def end_frame(self) -> None:
        """Default render state, and the clip control that begin_frame found."""
        self.default_state.apply()
        if self._frames:
            self.gl.clip_control(*self._frames.pop())

    @contextlib.contextmanager
    def frame(self) -> Iterator[None]:
        """begin_frame and end_frame around a block."""
        self.begin_frame()
        try:
            yield
        finally:
            self.end_frame()

    def state(
        self,
        depth_test: bool = False,
        depth_func: str = ">=",
        cull: str | None = None,
        blend: str | None = None,
        write_depth: bool = True,
        wireframe: bool = False,
        write_color: bool = True,
    ) -> State:
        """A prepared state; equal ones are the same object. apply() it after the framebuffer is bound.

        Depth is reversed: nearer is greater, so the usual test is ">=". cull: None, back, front. blend: None, alpha,
        premultiplied, additive, multiply. write_depth has no effect without depth_test (as in OpenGL): for depth
        writes without a test use depth_func="always".
        """
        options = {
            "depth_test": depth_test,
            "depth_func": depth_func,
            "cull": cull,
            "blend": blend,
            "write_depth": write_depth,
            "wireframe": wireframe,
            "write_color": write_color,
        }
        key = tuple(options.items())
        found = self._states.get(key)
        if found is None:
            found = self._states[key] = State(self.gl, **options)
        return found

    @contextlib.contextmanager
    def raster_state(
        self, depth: str = "greater", blend: str | None = None, cull: str | None = None, depth_write: bool = True
    ) -> Iterator[None]:
        """State for a block, defaults afterwards. depth: greater (nearer or equal), equal, none. Prefer state()."""
        tests = {"greater": ">=", "equal": "==", "none": None}
        if depth not in tests:
            raise ValueError(f"depth must be one of {', '.join(tests)}, found {depth!r}")
        test = tests[depth]
        self.state(test is not None, test or ">=", cull, blend, depth_write).apply()
        try:
            yield
        finally:
            self.default_state.apply()

    # -- small things ------------------------------------------------------------------------------------------------

    def upload(self, buffer: moderngl.Buffer, data: Data, offset: int = 0) -> None:
        """Write bytes or an array into a buffer, counted in work.uploads."""
        buffer.write(data, offset=offset)
        self.work.uploads += 1
        self.work.upload_bytes += len(data) if isinstance(data, (bytes, bytearray)) else data.nbytes

    def upload_part(self, texture: moderngl.Texture, data: bytes, part: tuple[int, int, int, int]) -> None:
        """Write texels into a part (column, row, width, height) of a texture, counted in work.uploads."""
        texture.write(data, viewport=part)
        self.work.uploads += 1
        self.work.upload_bytes += len(data)

    def clear(self, target: moderngl.Framebuffer, depth: float) -> None:
        """Fill the framebuffer of ours that is bound: zeros in all colours, integers too, and one depth. The state has
        to let both be written."""
        for place, texture in enumerate(target.color_attachments):
            self.gl.clear_color(place, texture.dtype[0] in "ui")
        if target.depth_attachment is not None:
            self.gl.clear_depth(depth)
        if self.watch is not None:
            self.watch.copied(None, target)

    def copy_color(self, source: moderngl.Framebuffer, target: moderngl.Framebuffer) -> bool:
        """Copy the colours of a framebuffer of ours into the viewport of the bound one, without a shader.

        False, and nothing is copied, where it takes a draw: another size, several samples or several colours.
        """
        x, y, *size = target.viewport
        if tuple(size) != source.size or self.gl.integer(G.SAMPLE_BUFFERS) or self.gl.integer(G.DRAW_BUFFER1):
            return False
        self.gl.blit_color(source.glo, source.size, (x, y))
        if self.watch is not None:
            self.watch.copied(source, target)
        return True

    def barrier(self) -> None:
        """Make all shader writes visible to all that follows. Inside a graph the plan does this."""
        if self.watch is not None:
            self.watch.barrier()
        self.ctx.memory_barrier()

    def apart(self) -> contextlib.AbstractContextManager[None]:
        """Around dispatches of which none reads what another stores: validation then asks for no barrier between."""
        return contextlib.nullcontext() if self.watch is None else self.watch.apart()

    def generate_mipmaps(self, texture: AnyTexture) -> None:
        """Fill levels 1 and up from level 0, keeping the filter (moderngl's build_mipmaps resets it)."""
        info = texture.extra
        texture.use(self.ctx.default_texture_unit)
        target = info.target if isinstance(info, TextureInfo) else G.TEXTURE_2D
        self.gl.generate_mipmap(target)

    def check_error(self, where: str) -> None:
        """Log any pending GL error, naming the place, and clear it."""
        error = self.ctx.error
        if error != "GL_NO_ERROR":
            log.error("OpenGL error %s after %s", error, where)
