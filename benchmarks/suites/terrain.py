"""Suite terrain: how right the ground is, and what that costs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ... import Camera, Planet, Renderer, load_scene, qualities, view, views
from ...engine.space import CameraState
from ..measure import coverage, ground, motion, positions, positions_quadtree, relief, sea
from ..session import Bench, Session
from ..target import Target, at_least, at_most
from ..timing import time_variants
    "backends": terrain_backends.backends,
    "popping": terrain_backends.popping_in_flight,
    "holes": terrain_backends.holes_in_the_disc,
