"""The camera proxy: the held, snapped stand-in for the camera that every level of detail depends on."""

from .system import ProxySystem

__all__ = ["ProxySystem"]
