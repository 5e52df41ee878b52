"""What suns of views, flights and command lines have of their scene's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..scene.scene import Scene

__all__ = ["light_of"]


def light_of(scene: Scene) -> dict[str, Any]:
    """Strength and disc of its sun, for a Sun that stands elsewhere."""
    return {name: getattr(scene.sun, name) for name in ("irradiance", "angular_radius_rad")}
