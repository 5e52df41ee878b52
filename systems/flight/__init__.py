"""Flight, on the CPU in f64: a ship that a player steers, and scripted paths. No GL and no window in here."""

from .keys import CONTROLS, flight_input
from .load import PATHS_FILE, find_path, load_paths
from .path import BoundPath, CruisePath, KeyFrame, KeyFramePath, Path, PathSun, Pose
from .profile import GroundProfile, HeightLike
from .ship import FlightInput, ShipFlight, ShipLimits

__all__ = [
    "CONTROLS",
    "PATHS_FILE",
    "BoundPath",
    "CruisePath",
    "FlightInput",
    "GroundProfile",
    "HeightLike",
    "KeyFrame",
    "KeyFramePath",
    "Path",
    "PathSun",
    "Pose",
    "ShipFlight",
    "ShipLimits",
    "find_path",
    "flight_input",
    "load_paths",
]
