"""What systems agree on, frame by frame: the frame, its view, and what is known of both.

Shared through modules of their own: the uniform blocks of a view (`block`), what shader contracts read (`contracts`),
what rests while its planet is not seen (`unseen`), the next snap of its proxy (`snapping`), other planets
behind its air (`backdrop`).
"""

from .frame import Frame, SunState, View, ViewInfo
from .proxy import Proxy
from .views import ViewParts, Views

__all__ = ["Frame", "Proxy", "SunState", "View", "ViewInfo", "ViewParts", "Views"]
