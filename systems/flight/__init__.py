"""Flight, on the CPU in f64: ship, walker, globe, flights to places and scripted paths. No GL and no window in here."""

from .bindings import Binding
from .controls import ACTIONS, CONTROLS_FILE, Controls, controls_or_defaults, load_controls
from .fly_to import FlyTo, pose_before, pose_over
from .ground import Ground
from .keys import flight_input, steering
from .load import PATHS_FILE, find_path, load_paths
from .orbit import OrbitFlight, OrbitInput, OrbitLimits
from .path import BoundPath, CruisePath, KeyFrame, KeyFramePath, Path, PathSun, Pose
from .pilot import MODES, Mode, Pilot, Steering
from .profile import GroundProfile, HeightLike
from .remap import LOOKING, TWO_SIDED, Catch, rebind, rivals
from .ship import FlightInput, ShipFlight, ShipLimits
from .walk import Obstacles, WalkFlight, WalkLimits

__all__ = [
    "ACTIONS",
    "CONTROLS_FILE",
    "LOOKING",
    "MODES",
    "PATHS_FILE",
    "TWO_SIDED",
    "Binding",
    "BoundPath",
    "Catch",
    "Controls",
    "CruisePath",
    "FlightInput",
    "FlyTo",
    "Ground",
    "GroundProfile",
    "HeightLike",
    "KeyFrame",
    "KeyFramePath",
    "Mode",
    "Obstacles",
    "OrbitFlight",
    "OrbitInput",
    "OrbitLimits",
    "Path",
    "PathSun",
    "Pilot",
    "Pose",
    "ShipFlight",
    "ShipLimits",
    "Steering",
    "WalkFlight",
    "WalkLimits",
    "controls_or_defaults",
    "find_path",
    "flight_input",
    "load_controls",
    "load_paths",
    "pose_before",
    "pose_over",
    "rebind",
    "rivals",
    "steering",
]
