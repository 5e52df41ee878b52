"""What the user changed, as steps that can be undone and done again. Plain Python: no ImGui, no scene.

A step is a list of edits that belong together: all that one drag of a slider did, or a whole preset. Values are those
of the fields themselves, so that undo brings back every bit.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

__all__ = ["Edit", "History", "Step"]

_LONGEST = 500


@dataclass(frozen=True)
class Edit:
    """One field of one part before and after. field "": the part itself was added (old None) or taken off (new None);
    old and new are then components."""

    part: str
    field: str
    old: Any
    new: Any

    def reversed(self) -> Edit:
        return Edit(self.part, self.field, self.new, self.old)


@dataclass
class Step:
    """Edits that are undone together, in the order in which they were made. label: what the user did."""

    edits: list[Edit] = field(default_factory=list)
    label: str = ""


class History:
    """Steps behind and ahead of now. `record` adds edits to the open step; `seal` ends it, and so does another label.

    length: how many steps are kept; older ones are forgotten.
    """

    def __init__(self, length: int = _LONGEST) -> None:
        if length < 1:
            raise ValueError(f"a history of {length} steps can undo nothing; give it at least 1")
        self._length = length
        self._done: list[Step] = []
        self._undone: list[Step] = []
        self.open = False

    def record(self, edits: Iterable[Edit], label: str) -> None:
        """Take in what has just been changed.

        While the step is open, edits of the same field become one, from its first value to its last, and a field that
        is back where it began leaves the step. So dragging a slider makes one step, and there and back none.
        """
        made = [edit for edit in edits if edit.field == "" or edit.old != edit.new]
        if not made:
            return
        self._undone.clear()
        if not (self.open and self._done and self._done[-1].label == label):
            self._done.append(Step(label=label))
            del self._done[: -self._length]
        self.open = True
        step = self._done[-1]
        for edit in made:
            self._merge(step.edits, edit)
        if not step.edits:
            self._done.pop()
            self.open = False

    @staticmethod
    def _merge(edits: list[Edit], edit: Edit) -> None:
        if edit.field:
            for place, known in enumerate(edits):
                if (known.part, known.field) == (edit.part, edit.field):
                    if known.old == edit.new:
                        del edits[place]
                    else:
                        edits[place] = Edit(edit.part, edit.field, known.old, edit.new)
                    return
        edits.append(edit)

    def seal(self) -> None:
        """The widget was let go: what comes next is a step of its own."""
        self.open = False

    @property
    def undo_label(self) -> str:
        """What `undo` would take back; "" for nothing."""
        return self._done[-1].label if self._done else ""

    @property
    def redo_label(self) -> str:
        """What `redo` would do again; "" for nothing."""
        return self._undone[-1].label if self._undone else ""

    def __len__(self) -> int:
        """Steps that can be undone."""
        return len(self._done)

    def undo(self) -> list[Edit]:
        """The edits that take back the last step, in the order to apply them; none left: an empty list."""
        self.open = False
        if not self._done:
            return []
        step = self._done.pop()
        self._undone.append(step)
        return [edit.reversed() for edit in reversed(step.edits)]

    def redo(self) -> list[Edit]:
        """The edits of the step that was undone last; none left: an empty list."""
        self.open = False
        if not self._undone:
            return []
        step = self._undone.pop()
        self._done.append(step)
        return list(step.edits)

    def forget_last(self) -> None:
        """Drop the last step for good: what it did was refused."""
        if self._done:
            self._done.pop()
        self.open = False
