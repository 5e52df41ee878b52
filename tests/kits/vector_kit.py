"""Vector maps made up for tests: GeoJSON files of a few shapes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["feature", "line", "polygon", "ring", "write_map"]


def ring(longitude: float, latitude: float, east: float, north: float, count: int = 80, bumps: float = 0.0) -> list:
    """A closed ring about a place, degrees to its sides; bumps: how far it is from an ellipse."""
    turn = 2.0 * np.pi * np.arange(count + 1) / count
    far = 1.0 + bumps * np.sin(5.0 * turn)
    found = np.stack([longitude + east * far * np.cos(turn), latitude + north * far * np.sin(turn)], axis=1)
    found[-1] = found[0]
    return found.tolist()


def polygon(*rings: list) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": list(rings)}


def line(*points: tuple[float, float]) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": [list(p) for p in points]}


def feature(geometry: dict[str, Any] | None, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def write_map(path: Path, *features: dict[str, Any]) -> str:
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}), encoding="utf-8")
    return str(path)
