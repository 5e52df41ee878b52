"""Neutral input: what a window, a host or a test sends, whatever library it came from.

Events are small immutable values with lower-case key names ("w", "left_shift", "page_up", "f1", "numpad_0"). They feed
`InputState`, which games poll, and the user interface, which wants the events themselves. Positions are in window
units (not pixels on high-density screens), x to the right and y down from the top left corner.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

MouseButtonName = Literal["left", "right", "middle"]

PAD_AXES: tuple[str, ...] = ("left_x", "left_y", "right_x", "right_y", "left_trigger", "right_trigger")
"""Sticks are -1..1 with x to the right and y towards the player (down), triggers 0..1."""

PAD_BUTTONS: tuple[str, ...] = (
    "a", "b", "x", "y", "left_bumper", "right_bumper", "back", "start", "guide", "left_thumb", "right_thumb",
    "dpad_up", "dpad_right", "dpad_down", "dpad_left",
)  # fmt: skip
"""By the places of an Xbox gamepad: a is the lowest of the four, b the right one."""

KEYS: frozenset[str] = frozenset(
    [chr(c) for c in range(ord("a"), ord("z") + 1)]
    + [str(n) for n in range(10)]
    + [f"numpad_{n}" for n in range(10)]
    + [f"f{n}" for n in range(1, 13)]
    + [f"{side}_{key}" for side in ("left", "right") for key in ("shift", "ctrl", "alt", "super")]
    + [f"numpad_{key}" for key in ("add", "subtract", "multiply", "divide", "decimal", "enter", "equal")]
    + ["escape", "space", "enter", "tab", "backspace", "insert", "delete", "home", "end", "page_up", "page_down"]
    + ["left", "right", "up", "down", "caps_lock", "num_lock", "scroll_lock", "print_screen", "pause", "menu"]
    + ["comma", "minus", "period", "slash", "semicolon", "equal", "left_bracket", "right_bracket", "backslash"]
    + ["apostrophe", "grave"]
)
"""Every neutral key name."""


@dataclass(frozen=True, slots=True)
class KeyEvent:
    """A key went down or up. Repeats of a held key are not sent."""

    key: str
    pressed: bool


@dataclass(frozen=True, slots=True)
class MouseMove:
    """The pointer moved by (dx, dy) to (x, y). While the mouse is captured only dx and dy mean anything."""

    x: float
    y: float
    dx: float
    dy: float


@dataclass(frozen=True, slots=True)
class MouseButton:
    """A mouse button went down or up at (x, y)."""

    button: MouseButtonName
    pressed: bool
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Wheel:
    """The wheel turned; dy > 0 is away from the user."""

    dx: float
    dy: float


@dataclass(frozen=True, slots=True)
class Text:
    """Printable characters were typed."""

    text: str


@dataclass(frozen=True, slots=True)
class Focus:
    """The window gained or lost the keyboard."""

    focused: bool


@dataclass(frozen=True, slots=True)
class PointerLeft:
    """The pointer left the window."""


@dataclass(frozen=True, slots=True)
class Resize:
    """The framebuffer has a new size in pixels."""

    width: int
    height: int


@dataclass(frozen=True, slots=True)
class PadButton:
    """A button of the gamepad (one of PAD_BUTTONS) went down or up."""

    button: str
    pressed: bool


@dataclass(frozen=True, slots=True)
class PadAxis:
    """A stick or trigger of the gamepad (one of PAD_AXES) has another value, without any dead zone."""

    axis: str
    value: float


InputEvent = KeyEvent | MouseMove | MouseButton | Wheel | Text | Focus | PointerLeft | Resize | PadButton | PadAxis

_NONE: frozenset[str] = frozenset()


class InputState:
    """What is held now and what happened since the last `advance`.

    `keys_held`, `keys_pressed`, `keys_released` and the same with `buttons_` are sets of neutral names; `mouse_dx`,
    `mouse_dy`, `wheel` and `text` are sums over the frame; `pad_held`, `pad_pressed` and `pad_axis(name)` are the
    gamepad's. After `consume` the parts that the user interface took read
    as idle until the next `advance`, so that typing into a field does not fly the camera.
    """

    def __init__(self) -> None:
        self.events: tuple[InputEvent, ...] = ()
        self.mouse_x = 0.0
        self.mouse_y = 0.0
        self.focused = True
        self.resized = False
        self._keys: set[str] = set()
        self._buttons: set[str] = set()
        self._pad_held: set[str] = set()
        self._pad_axes: dict[str, float] = {}
        self._new_frame()

    def _new_frame(self) -> None:
        self._keys_pressed: set[str] = set()
        self._keys_released: set[str] = set()
        self._buttons_pressed: set[str] = set()
        self._buttons_released: set[str] = set()
        self._pad_pressed: set[str] = set()
        self._dx = self._dy = self._wheel = 0.0
        self._text = ""
        self.resized = False
        self._keyboard_taken = self._mouse_taken = self._pad_taken = False

    def advance(self, events: Iterable[InputEvent]) -> None:
        """Start a new frame with these events."""
        self._new_frame()
        self.events = tuple(events)
        for event in self.events:
            self._apply(event)

    def _apply(self, event: InputEvent) -> None:
        if isinstance(event, KeyEvent):
            if event.pressed:
                self._keys.add(event.key)
                self._keys_pressed.add(event.key)
            else:
                self._keys.discard(event.key)
                self._keys_released.add(event.key)
        elif isinstance(event, MouseMove):
            self.mouse_x, self.mouse_y = event.x, event.y
            self._dx += event.dx
            self._dy += event.dy
        elif isinstance(event, MouseButton):
            self.mouse_x, self.mouse_y = event.x, event.y
            if event.pressed:
                self._buttons.add(event.button)
                self._buttons_pressed.add(event.button)
            else:
                self._buttons.discard(event.button)
                self._buttons_released.add(event.button)
        elif isinstance(event, Wheel):
            self._wheel += event.dy
        elif isinstance(event, Text):
            self._text += event.text
        elif isinstance(event, Focus):
            self.focused = event.focused
            if not event.focused:  # the releases will go to another window: nothing may stay held
                self._keys_released |= self._keys
                self._buttons_released |= self._buttons
                self._keys.clear()
                self._buttons.clear()
                self._pad_held.clear()
                self._pad_axes.clear()
        elif isinstance(event, Resize):
            self.resized = True
        elif isinstance(event, PadAxis):
            self._pad_axes[event.axis] = event.value
        elif isinstance(event, PadButton):
            if event.pressed:
                self._pad_held.add(event.button)
                self._pad_pressed.add(event.button)
            else:
                self._pad_held.discard(event.button)

    def consume(self, *, keyboard: bool = False, mouse: bool = False, pad: bool = False) -> None:
        """Hide the keyboard, the mouse or the gamepad from whoever reads this state later in the frame.

        Releases stay visible: whoever saw the press must see the end of it.
        """
        self._keyboard_taken |= keyboard
        self._mouse_taken |= mouse
        self._pad_taken |= pad

    @property
    def keys_held(self) -> frozenset[str] | set[str]:
        return _NONE if self._keyboard_taken else self._keys

    @property
    def keys_pressed(self) -> frozenset[str] | set[str]:
        return _NONE if self._keyboard_taken else self._keys_pressed

    @property
    def keys_released(self) -> frozenset[str] | set[str]:
        return self._keys_released

    @property
    def buttons_held(self) -> frozenset[str] | set[str]:
        return _NONE if self._mouse_taken else self._buttons

    @property
    def buttons_pressed(self) -> frozenset[str] | set[str]:
        return _NONE if self._mouse_taken else self._buttons_pressed

    @property
    def buttons_released(self) -> frozenset[str] | set[str]:
        return self._buttons_released

    @property
    def mouse_dx(self) -> float:
        return 0.0 if self._mouse_taken else self._dx

    @property
    def mouse_dy(self) -> float:
        return 0.0 if self._mouse_taken else self._dy

    @property
    def wheel(self) -> float:
        return 0.0 if self._mouse_taken else self._wheel

    @property
    def text(self) -> str:
        return "" if self._keyboard_taken else self._text

    @property
    def pad_held(self) -> frozenset[str] | set[str]:
        return _NONE if self._pad_taken else self._pad_held

    @property
    def pad_pressed(self) -> frozenset[str] | set[str]:
        return _NONE if self._pad_taken else self._pad_pressed

    def axis(self, negative: str, positive: str) -> float:
        """-1, 0 or 1 from two keys, e.g. axis("a", "d")."""
        held = self.keys_held
        return float(positive in held) - float(negative in held)

    def pad_axis(self, name: str) -> float:
        """A stick (-1..1) or trigger (0..1) of the gamepad; 0 where there is none."""
        return 0.0 if self._pad_taken else self._pad_axes.get(name, 0.0)
