"""Capture: pictures, arrays, contact sheets and videos on disk. Every file is written beside and then renamed.

Pillow is imported by what uses it: it takes 5 MB, and a picture on the screen needs none of it.
"""

from .animation import write_gif
from .arrays import read_arrays, write_arrays
from .exr import read_exr_settings, write_exr
from .files import CaptureError, require_writable, written_beside
from .frames import NumberedFrames
from .jpeg import read_jpeg_settings, write_jpeg
from .png import read_png_settings, write_png
from .sheet import contact_sheet
from .video import VideoError, write_video

__all__ = [
    "CaptureError",
    "NumberedFrames",
    "VideoError",
    "contact_sheet",
    "read_arrays",
    "read_exr_settings",
    "read_jpeg_settings",
    "read_png_settings",
    "require_writable",
    "write_arrays",
    "write_exr",
    "write_gif",
    "write_jpeg",
    "write_png",
    "write_video",
    "written_beside",
]
