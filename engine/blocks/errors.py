"""What blocks and GL objects share of errors, without a GPU package."""

__all__ = ["FormatError", "GpuError"]


class GpuError(RuntimeError):
    """A GL object could not be made or used."""


class FormatError(GpuError, ValueError):
    """A texture, buffer or block was asked for in a form that does not exist or does not fit this GPU."""
