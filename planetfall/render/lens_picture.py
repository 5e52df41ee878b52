"""The picture of a camera whose lens bends straight lines: pinhole pictures of the same place, resampled.

The first of them is drawn as the picture's own view, so that exposure, passes and the frame graph are there to be asked
for; further ones are views of the renderer (`add_view`), each with its own history. All have the first one's exposure.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..components import Composite
from ..engine.settings import with_overrides
from ..errors import CameraError, SettingError
from .lens_faces import FacePixels, LensFaces, faces_of
from .lens_light import LensLight
from .lens_target import LensTarget
from .resample import distances, light, nearest

if TYPE_CHECKING:
    import moderngl

    from ..camera.camera import Camera
    from ..camera.intrinsics import Intrinsics
    from ..components import Sun
    from ..engine.gpu import Gpu
    from ..engine.space import CameraState
    from ..engine.wavelengths import Nanometres
    from ..scene.scene import Scene
    from .host_space import HostDepth

__all__ = ["FacePicture", "FaceView", "LensPicture"]

Arrays = dict[str, NDArray[Any]]
Progress = Callable[[float], None] | None
_GEOMETRY = ("distance", "position", "depth")


class FacePicture(Protocol):
    """What takes a face: a Picture."""

    @property
    def exposure(self) -> float | None: ...
    @property
    def wavelengths_nm(self) -> Nanometres: ...
    def render(
        self, camera: Camera, time_s: float | None, sun: Sun | None, outputs: Sequence[str], dt_s: float | None
    ) -> Arrays: ...
    def settle(
        self, camera: Camera, time_s: float | None, sun: Sun | None, timeout_s: float | None, progress: Progress
    ) -> None: ...
    def camera_state(self, camera: Camera) -> CameraState: ...


class FaceView(FacePicture, Protocol):
    """One that is released by itself: a RenderView."""

    def release(self) -> None: ...


class LensOwner(Protocol):
    """The renderer."""

    settings: dict[str, Any]
    scene: Scene

    def add_view(self, size: tuple[int, int]) -> FaceView: ...


class LensPicture:
    """For one Picture. owner: its renderer."""

    def __init__(self, picture: FacePicture, owner: LensOwner) -> None:
        self._picture, self._owner = picture, owner
        self._views: list[FaceView] = []
        self._target: LensTarget | None = None
        self._held: tuple[Camera, LensFaces, list[Camera]] | None = None

    def render(
        self,
        camera: Camera,
        time_s: float | None,
        sun: Sun | None,
        outputs: Sequence[str],
        dt_s: float | None,
        pixel: int | None = None,
    ) -> Arrays:
        """As Picture.render. Where the lens has no ray: black; distance, depth and position NaN, all else 0.
        SettingError for flow.

        pixel: the flat index of one that has a ray; then only the face that shows it is drawn.
        """
        lens = _lens(camera)
        if "flow" in outputs:
            raise SettingError(
                "outputs: flow is in pixels of a pinhole; expected a camera without intrinsics or with those of "
                f"one, found model {lens.model!r}. Project `position` with the camera before by lens.project instead"
            )
        parts, cameras = self._faces(camera, lens)
        # The way along a ray is what positions are made of.
        names = dict.fromkeys("distance" if name in _GEOMETRY else name for name in outputs if name != "color")
        colors = self._light(lens) if "color" in outputs else None
        asked = tuple(dict.fromkeys((*names, *(colors.outputs if colors else ()))))
        found: Arrays = {}
        for part, picture, face in self._taken(parts.faces, cameras, colors is not None):
            if pixel is not None and not (face.pixels == pixel).any():
                continue
            arrays = picture.render(part, time_s, sun, asked, dt_s)
            if colors is not None:
                colors.add(face, arrays, self._picture.exposure or 0.0)
            for name in names:
                values = _resampled(name, arrays[name], face)
                if name not in found:
                    whole = np.zeros((lens.width * lens.height, *values.shape[1:]), values.dtype)
                    found[name] = np.full_like(whole, np.nan) if name == "distance" else whole
                found[name][face.pixels] = values
        found = {name: values.reshape(lens.height, lens.width, *values.shape[1:]) for name, values in found.items()}
        if colors is not None:
            found["color"] = colors.picture(parts.seen)
        if "position" in outputs:
            state = self._picture.camera_state(cameras[0])
            axes = parts.faces[0].face.axes.T @ state.axes * np.array([[1.0], [-1.0], [1.0]])
            with np.errstate(invalid="ignore"):
                position = (parts.rays @ axes) * found["distance"][..., None]
            found["position"] = np.where(np.isfinite(position), position, np.nan).astype(np.float32)
        if "depth" in outputs:
            found["depth"] = (found["distance"] * parts.rays[..., 2]).astype(np.float32)
        if "distance" in found:
            found["distance"] = found["distance"].astype(np.float32)
        return {name: found[name] for name in outputs}

    def settle(
        self,
        camera: Camera,
        time_s: float | None,
        sun: Sun | None,
        timeout_s: float | None,
        progress: Progress,
    ) -> None:
        """As Picture.settle, one face after the other."""
        parts, cameras = self._faces(camera, _lens(camera))
        count = len(cameras)
        until = None if timeout_s is None else time.monotonic() + timeout_s
        for number, (part, picture, _) in enumerate(self._taken(parts.faces, cameras, exposed=True)):
            left = None if until is None else max(until - time.monotonic(), 0.0)
            picture.settle(part, time_s, sun, left, _share(progress, number, count))

    def _light(self, lens: Intrinsics) -> LensLight:
        own = self._owner.scene.environment.get(Composite) or Composite()
        composite = with_overrides(own, "composite", self._owner.settings)
        return LensLight(lens, composite, self._picture.wavelengths_nm)

    def _faces(self, camera: Camera, lens: Intrinsics) -> tuple[LensFaces, list[Camera]]:
        """The faces and their cameras: the same objects for the same camera, which are resolved once."""
        if self._held is None or self._held[0] is not camera:
            parts = faces_of(lens)
            self._held = camera, parts, [camera.face(part.face) for part in parts.faces]
        return self._held[1], self._held[2]

    def _taken(
        self, faces: Sequence[FacePixels], cameras: Sequence[Camera], exposed: bool
    ) -> Iterator[tuple[Camera, FacePicture, FacePixels]]:
        """(camera, picture that takes it, face) for each: ask for the next when one has been rendered."""
        for number, (part, face) in enumerate(zip(cameras, faces, strict=True)):
            if number == 0:
                yield part, self._picture, face
                continue
            camera = part
            if exposed and part.ev100 is None:
                ev100 = self._picture.exposure
                camera = part if ev100 is None else part.exposed(ev100)
            while len(self._views) < number:
                self._views.append(self._owner.add_view(face.face.size))
            yield camera, self._views[number - 1], face

    def check_depth(self, camera: Camera, depth: HostDepth | None) -> None:
        """CameraError for a depth buffer that is to be shared."""
        if depth is not None:
            raise CameraError(
                "render_to: depth: what a lens bends fits no depth buffer; expected a camera without intrinsics or with"
                f" those of a pinhole, found model {_lens(camera).model!r}"
            )

    def draw(self, gpu: Gpu, color: NDArray[np.uint8], framebuffer: moderngl.Framebuffer) -> None:
        """A picture into the viewport of a host's framebuffer. The context is current."""
        self._target = self._target or LensTarget(gpu)
        self._target.draw(color, framebuffer)

    def release(self) -> None:
        """Free the further views and what `draw` needs. The context is current."""
        for view in self._views:
            view.release()
        self._views.clear()
        if self._target is not None:
            self._target.release()
            self._target = None


def _lens(camera: Camera) -> Intrinsics:
    lens = camera.optics.lens
    assert lens is not None
    return lens


def _resampled(name: str, values: NDArray[Any], face: FacePixels) -> NDArray[Any]:
    """An output at the pixels of the lens (N, ...)."""
    if name == "radiance":
        return light(values, face)
    return distances(values, face) if name == "distance" else nearest(values, face)


def _share(progress: Progress, number: int, count: int) -> Progress:
    if progress is None:
        return None
    return lambda share: progress((number + share) / count)
