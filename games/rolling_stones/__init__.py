"""Stones that roll down a mountain side: a physics engine in local frames on a whole planet. On the public API only."""
