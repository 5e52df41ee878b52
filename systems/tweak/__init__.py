"""tweak."""
