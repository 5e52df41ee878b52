"""The sea: one surface at sea level on the cells of the lattice."""

from .system import OceanSystem

__all__ = ["OceanSystem"]
