"""Debug views: any resource of the frame graph by name, normals, depth, surfaces, levels of detail, HDR."""

from .system import DebugSystem, show_debug_view
from .views import NAMED_VIEWS

__all__ = ["NAMED_VIEWS", "DebugSystem", "show_debug_view"]
