"""What a view may show of its planet: passes that have nothing to do without it are skipped all together."""

from __future__ import annotations

__all__ = ["Seen"]


class Seen:
    """Of one view: `frame.view.seen`. Passes give its methods as their only_while. Whoever places the camera tells it,
    before others are updated."""

    def __init__(self) -> None:
        self._planet = self._ground = True

    def tell(self, planet: bool, ground: bool) -> None:
        """Of this frame."""
        self._planet, self._ground = planet, planet and ground

    def planet(self) -> bool:
        """Whether the planet, its air and its clouds may be in the picture."""
        return self._planet

    def ground(self) -> bool:
        """The same of its ground and sea alone, for what only draws or shades them; never without the planet."""
        return self._ground
