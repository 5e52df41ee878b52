"""Methods side by side: renderers on one context whose frames take turns, so that a busy machine slows all alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any

from ... import Renderer, Scene, view
from ..session import Session
from ..timing import Timing, time_variants
from .frames import forget_proxy
from .motion import turned

__all__ = ["interleaved", "side_by_side", "snapping", "turning"]

Frame = Callable[[Renderer, Any, str], Callable[[], None]]


@contextmanager
def side_by_side(
    session: Session,
    methods: Mapping[str, Mapping[str, Any]],
    scene: Callable[[], Scene],
    size: tuple[int, int] = (640, 360),
    quality: str = "medium",
) -> Iterator[dict[str, Renderer]]:
    """A renderer for each method, from its overrides of the quality; scene: makes one for each."""
    first_name, *others = methods
    with session.renderer(scene(), size, quality, dict(methods[first_name])) as first, ExitStack() as stack:
        made = {first_name: first}
        for name in others:
            made[name] = Renderer(scene(), size, quality, dict(methods[name]), ctx=first.ctx, guard=False)
            stack.callback(made[name].release)
        yield made


def interleaved(renderers: Mapping[str, Renderer], place: str, runs: int, frame: Frame) -> dict[str, Timing]:
    """Times of such frames of a named view, each waited for."""
    targets = {name: r.ctx.simple_framebuffer(r.size) for name, r in renderers.items()}
    variants = {name: frame(r, targets[name], place) for name, r in renderers.items()}
    times = time_variants(variants, runs, 2, next(iter(renderers.values())).ctx.finish)
    for name, target in targets.items():
        renderers[name].gpu.leave(target)
        target.release()
    return times


def turning(renderer: Renderer, target: Any, place: str) -> Callable[[], None]:
    """The camera turns a little in each frame: what is seen is found anew, the mesh is held."""
    cameras = turned(renderer.camera_state(view(place)), 0.01, 4)

    def frame() -> None:
        cameras.append(cameras.pop(0))
        renderer.render_to(target, cameras[0])

    return frame


def snapping(renderer: Renderer, target: Any, place: str) -> Callable[[], None]:
    """The mesh is made anew in each frame."""
    camera = turned(renderer.camera_state(view(place)), 0.01, 1)[0]

    def frame() -> None:
        forget_proxy(renderer)
        renderer.render_to(target, camera)

    return frame
