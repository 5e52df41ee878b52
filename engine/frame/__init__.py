"""One frame of one view: what a view is, and what systems keep for it."""

from .view import View, ViewParts, Views

__all__ = ["View", "ViewParts", "Views"]
