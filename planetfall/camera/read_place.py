"""Latitude and longitude as maps print them."""

from __future__ import annotations

import re

from ..errors import CameraError

__all__ = ["read_place"]

_NUMBER = r"(\d+(?:\.\d+)?)"
_ANGLE = re.compile(
    rf"\s*([NSEW])?\s*([+-]?)\s*{_NUMBER}\s*(?:°|º|deg|d|\s|$|(?=[,;NSEW]))?"
    rf"\s*(?:{_NUMBER}\s*(?:'|′|’|m(?!\w))\s*)?(?:{_NUMBER}\s*(?:\"|″|”|''|s(?!\w))\s*)?(?(1)|([NSEW])?)\s*[,;]?",
    re.IGNORECASE,
)
_EXAMPLES = "46°33'25\"N 7°59'3\"E, 46.557 N 7.984 E, or 46.557, 7.984"


def read_place(text: str) -> tuple[float, float]:
    """(latitude, longitude) in degrees of a place as maps print it, such as "46°33'N 7°59'E" or "46.55, 7.98".

    Degrees with minutes and seconds or with a fraction; N, S, E and W before or behind, in either order, or
    signs: latitude first then. O is refused: it is east on German maps and west on French ones. CameraError says
    what was expected.
    """
    angles: list[tuple[float, str]] = []
    at = 0
    while at < len(text.rstrip()):
        match = _ANGLE.match(text, at)
        if match is None or match.end() == at:
            raise _unread(text)
        before, sign, degrees, minutes, seconds, behind = match.groups()
        if any(part is not None and float(part) >= 60.0 for part in (minutes, seconds)):
            raise _unread(text)
        if minutes is not None and "." in degrees:
            raise _unread(text)
        side = (before or behind or "").upper()
        value = float(degrees) + float(minutes or 0.0) / 60.0 + float(seconds or 0.0) / 3600.0
        if sign and side:
            raise _unread(text)
        angles.append((-value if sign == "-" or side in ("S", "W") else value, side))
        at = match.end()
    if len(angles) != 2:
        raise _unread(text)
    (first, side), (second, other) = angles
    if bool(side) != bool(other):
        raise _unread(text)
    if side in ("E", "W"):
        first, second, side, other = second, first, other, side
    if side and (side not in "NS" or other not in "EW"):
        raise _unread(text)
    if abs(first) > 90.0 or abs(second) > 360.0:
        raise CameraError(
            f"read_place: {text!r} is latitude {first:g}, longitude {second:g}; expected at most 90 and 360 degrees: "
            "the latitude comes first where no letters say which is which"
        )
    return first, second


def _unread(text: str) -> CameraError:
    return CameraError(f"read_place: {text!r} is no latitude and longitude; expected {_EXAMPLES}")
