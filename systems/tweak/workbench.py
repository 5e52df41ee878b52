"""The state behind the panels: what there is, what differs, undo, two states to compare, TOML. No ImGui in it.

The workbench doesn't know scenes. It works on a `Store`, which says which parts (components) there are by heading and
can add one or take one off.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

from ...engine.settings import plain_table, rules_of
from .history import Edit, History

__all__ = ["Shelf", "Store", "Workbench"]

Shelf = Mapping[str, Any]
"""Copies of components by heading: a state that can be gone back to."""


class Store(Protocol):
    """Where the parts are."""

    def parts(self) -> Mapping[str, Any]:
        """The components that there are now, by heading."""
        ...

    def find(self, heading: str) -> Any:
        """A component that edits name and `parts` doesn't have, such as one of many objects'; None for none."""
        ...

    def put(self, heading: str, part: Any) -> None:
        """Add a component, or replace the one of that heading."""

    def take(self, heading: str) -> None:
        """Take a component off."""


class Workbench:
    """Parts with a memory. base: what "reset" goes back to and what marks are against; at first, what there was.

    check: says what does not fit together after a change, "" for nothing; such a change is taken back at once.
    slot: "A" or "B", which of two states is worked on.
    """

    def __init__(self, store: Store, check: Callable[[], str] = lambda: "") -> None:
        self.store = store
        self.history = History()
        self.check = check
        self.base: Shelf = self.copy()
        self.slot = "A"
        self._other: Shelf | None = None

    # -- states ------------------------------------------------------------------------------------------------------

    def copy(self) -> dict[str, Any]:
        """All parts as they are now."""
        return {heading: dataclasses.replace(part) for heading, part in self.store.parts().items()}

    def differences(self) -> dict[str, dict[str, tuple[Any, Any]]]:
        """{heading: {field: (base, now)}} of what differs from the base; a part that is on one side only has the field
        "" with (component or None) on both."""
        now, found = self.store.parts(), {}
        for heading in dict.fromkeys((*self.base, *now)):
            mine, was = now.get(heading), self.base.get(heading)
            if mine is None or was is None:
                found[heading] = {"": (was, mine)}
                continue
            fields = {
                name: (getattr(was, name), getattr(mine, name))
                for name in rules_of(type(mine))
                if getattr(was, name) != getattr(mine, name)
            }
            if fields:
                found[heading] = fields
        return found

    def toml_tables(self, only_changed: bool = True) -> dict[str, dict[str, Any]]:
        """{heading: {field: value}} as TOML takes it; what is None is left out. only_changed: against the base."""
        tables = {heading: plain_table(part) for heading, part in self.store.parts().items()}
        if not only_changed:
            return tables
        changed = self.differences()
        return {
            heading: {
                name: value for name, value in table.items() if "" in changed[heading] or name in changed[heading]
            }
            for heading, table in tables.items()
            if heading in changed
        }

    # -- changes -----------------------------------------------------------------------------------------------------

    def made(self, heading: str, changes: Iterable[tuple[str, Any, Any]], label: str = "") -> str:
        """Record changes (field, old, new) that a widget has made already. Returns what does not fit, "" for nothing;
        then they have been taken back."""
        edits = [Edit(heading, *change) for change in changes]
        if not edits:
            return ""
        wrong = self.check()
        if wrong:
            self._apply([edit.reversed() for edit in reversed(edits)])
            return wrong
        self.history.record(edits, label or f"{heading}.{edits[0].field}")
        return ""

    def to(self, state: Shelf, label: str, headings: Iterable[str] | None = None) -> str:
        """Go to a state as one step. headings: only these parts. Returns what does not fit, "" for nothing; then
        nothing has changed."""
        return self.do(self._way_to(state, None if headings is None else set(headings)), label)

    def do(self, edits: Iterable[Edit], label: str) -> str:
        """Make these edits as one step. Returns what does not fit, "" for nothing; then nothing has changed."""
        edits = list(edits)
        self.history.seal()
        self._apply(edits)
        wrong = self.check()
        if wrong:
            self._apply([edit.reversed() for edit in reversed(edits)])
            return wrong
        self.history.record(edits, label)
        self.history.seal()
        return ""

    def reset(self, *headings: str) -> str:
        """Back to the base, all parts or these."""
        return self.to(self.base, "reset" if not headings else f"reset {', '.join(headings)}", headings or None)

    def add(self, heading: str, part: Any) -> str:
        """Add a part as a step of its own."""
        return self.to({**self.copy(), heading: part}, f"add {heading}")

    def remove(self, heading: str) -> str:
        """Take a part off as a step of its own."""
        return self.to({name: part for name, part in self.copy().items() if name != heading}, f"remove {heading}")

    def undo(self) -> str:
        """Take the last step back; its label, or ""."""
        label = self.history.undo_label
        self._apply(self.history.undo())
        return label

    def redo(self) -> str:
        """Do the step again that was undone last; its label, or ""."""
        label = self.history.redo_label
        self._apply(self.history.redo())
        return label

    # -- A and B -----------------------------------------------------------------------------------------------------

    @property
    def comparing(self) -> bool:
        """Whether the other slot holds anything yet."""
        return self._other is not None

    def switch(self) -> str:
        """Leave this state in its slot and go to the other one; at first both are the same. A step like any other."""
        mine = self.copy()
        if self._other is not None:
            wrong = self.to(self._other, f"show {'B' if self.slot == 'A' else 'A'}")
            if wrong:
                return wrong
        self._other, self.slot = mine, "B" if self.slot == "A" else "A"
        return ""

    def drop_other(self) -> None:
        """Forget the other slot: there is one state again, called A."""
        self._other, self.slot = None, "A"

    # -- how ---------------------------------------------------------------------------------------------------------

    def _way_to(self, state: Shelf, only: set[str] | None) -> list[Edit]:
        now = self.store.parts()
        edits: list[Edit] = []
        for heading in dict.fromkeys((*now, *state)):
            if only is not None and heading not in only:
                continue
            mine, wanted = now.get(heading), state.get(heading)
            if mine is None or wanted is None:
                edits.append(Edit(heading, "", _copied(mine), _copied(wanted)))
                continue
            for name in rules_of(type(mine)):
                before, after = getattr(mine, name), getattr(wanted, name)
                if before != after:
                    edits.append(Edit(heading, name, before, after))
        return edits

    def _apply(self, edits: Iterable[Edit]) -> None:
        edits = list(edits)
        for edit in edits:
            if edit.field == "":
                if edit.new is None:
                    self.store.take(edit.part)
                else:
                    self.store.put(edit.part, _copied(edit.new))
        parts = self.store.parts()
        # Fields that exclude each other: setting one makes the other None, so what is to be None comes first.
        for edit in sorted((e for e in edits if e.field), key=lambda e: e.new is not None):
            part = parts.get(edit.part)
            if part is None:
                part = self.store.find(edit.part)
            if part is not None:
                setattr(part, edit.field, edit.new)


def _copied(part: Any) -> Any:
    return None if part is None else dataclasses.replace(part)
