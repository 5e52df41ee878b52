"""Undo, differences, A and B, TOML: the memory behind the panels, without ImGui and without a GPU."""

from __future__ import annotations

import dataclasses
import random
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

import pytest
import tomli_w

from planetfall.components import knob
from planetfall.engine.settings import install
from planetfall.systems.tweak.history import Edit, History
from planetfall.systems.tweak.workbench import Workbench


@dataclass
class Sea:
    level_m: float = knob(0.0, -100.0, 100.0, "m", "Height")
    color: tuple[float, float, float] = knob((0.1, 0.2, 0.3), 0.0, 1.0, help="Colour")
    at_deg: float | None = knob(None, 0.0, 90.0, "deg", "One way", excludes=("at_m",))
    at_m: float | None = knob(None, 0.0, 90.0, "m", "Another way", excludes=("at_deg",))


@dataclass
class Air:
    thick: float = knob(1.0, 0.0, 10.0, help="How thick")


install(Sea)
install(Air)


class Box:
    """A store that is a dict."""

    def __init__(self) -> None:
        self.held: dict[str, Any] = {"Sea": Sea(at_m=5.0), "Air": Air()}

    def parts(self) -> dict[str, Any]:
        return dict(self.held)

    def find(self, heading: str) -> Any:
        return None

    def put(self, heading: str, part: Any) -> None:
        self.held[heading] = part

    def take(self, heading: str) -> None:
        del self.held[heading]


def turn(bench: Workbench, heading: str, field: str, value: Any) -> str:
    """What a widget does: assign, then tell."""
    part = bench.store.parts()[heading]
    names = (field, *(n for n in ("at_deg", "at_m") if field in ("at_deg", "at_m") and n != field))
    before = {name: getattr(part, name) for name in names}
    setattr(part, field, value)
    changes = [(name, before[name], getattr(part, name)) for name in names if getattr(part, name) != before[name]]
    return bench.made(heading, changes)


@pytest.fixture
def bench() -> Workbench:
    return Workbench(Box())


def test_a_drag_is_one_step(bench: Workbench) -> None:
    sea = bench.store.parts()["Sea"]
    for value in (0.1, 0.30000000000000004, 7.0):
        turn(bench, "Sea", "level_m", value)
    bench.history.seal()
    for value in (8.0, 9.0):
        turn(bench, "Sea", "level_m", value)
    bench.history.seal()
    assert len(bench.history) == 2
    assert bench.undo() == "Sea.level_m" and sea.level_m == 7.0
    assert bench.undo() == "Sea.level_m" and sea.level_m == 0.0
    assert bench.undo() == "" and sea.level_m == 0.0
    assert bench.redo() and bench.redo() and sea.level_m == 9.0
    assert bench.redo() == ""


def test_there_and_back_is_no_step(bench: Workbench) -> None:
    turn(bench, "Sea", "level_m", 3.0)
    turn(bench, "Sea", "level_m", 0.0)
    bench.history.seal()
    assert len(bench.history) == 0 and bench.history.undo_label == ""


def test_another_field_is_another_step_and_a_change_ends_what_could_be_done_again(bench: Workbench) -> None:
    turn(bench, "Sea", "level_m", 3.0)
    turn(bench, "Air", "thick", 2.0)
    assert len(bench.history) == 2
    bench.undo()
    assert bench.history.redo_label == "Air.thick"
    turn(bench, "Sea", "level_m", 4.0)
    assert bench.history.redo_label == ""


def test_fields_that_exclude_each_other_come_back_together(bench: Workbench) -> None:
    sea = bench.store.parts()["Sea"]
    turn(bench, "Sea", "at_deg", 45.0)
    assert (sea.at_deg, sea.at_m) == (45.0, None)
    bench.undo()
    assert (sea.at_deg, sea.at_m) == (None, 5.0)
    bench.redo()
    assert (sea.at_deg, sea.at_m) == (45.0, None)
    assert bench.reset() == ""
    assert (sea.at_deg, sea.at_m) == (None, 5.0)


def test_parts_that_are_added_and_taken_off(bench: Workbench) -> None:
    bench.store.parts()["Air"].thick = 4.0
    bench.remove("Air")
    assert "Air" not in bench.store.parts()
    assert bench.differences()["Air"][""][1] is None
    bench.undo()
    assert bench.store.parts()["Air"].thick == 4.0
    bench.redo()
    bench.add("Air", Air(7.0))
    assert bench.store.parts()["Air"].thick == 7.0
    turn(bench, "Air", "thick", 8.0)
    for _ in range(3):
        bench.undo()
    assert bench.store.parts()["Air"].thick == 4.0
    for _ in range(3):
        bench.redo()
    assert bench.store.parts()["Air"].thick == 8.0


def test_differences_reset_and_toml(bench: Workbench) -> None:
    assert bench.differences() == {} and bench.toml_tables() == {}
    turn(bench, "Sea", "level_m", 3.0)
    turn(bench, "Sea", "at_deg", 45.0)
    assert bench.differences() == {"Sea": {"level_m": (0.0, 3.0), "at_deg": (None, 45.0), "at_m": (5.0, None)}}
    assert bench.toml_tables() == {"Sea": {"level_m": 3.0, "at_deg": 45.0}}
    assert tomli_w.dumps(bench.toml_tables()) == "[Sea]\nlevel_m = 3.0\nat_deg = 45.0\n"
    assert bench.toml_tables(only_changed=False)["Air"] == {"thick": 1.0}
    bench.reset("Air")
    assert bench.differences()
    bench.reset()
    assert bench.differences() == {}
    bench.undo()
    assert bench.store.parts()["Sea"].level_m == 3.0


def test_a_and_b(bench: Workbench) -> None:
    sea = bench.store.parts()["Sea"]
    turn(bench, "Sea", "level_m", 1.0)
    bench.switch()
    assert bench.slot == "B" and bench.comparing and sea.level_m == 1.0
    turn(bench, "Sea", "level_m", 2.0)
    bench.remove("Air")
    bench.switch()
    assert bench.slot == "A" and sea.level_m == 1.0 and "Air" in bench.store.parts()
    bench.switch()
    assert bench.slot == "B" and sea.level_m == 2.0 and "Air" not in bench.store.parts()
    bench.drop_other()
    assert bench.slot == "A" and not bench.comparing and sea.level_m == 2.0


def test_what_does_not_fit_is_taken_back() -> None:
    store = Box()
    bench = Workbench(store, lambda: "too deep" if "Sea" in store.held and store.held["Sea"].level_m < -50 else "")
    turn(bench, "Sea", "level_m", -10.0)
    assert turn(bench, "Sea", "level_m", -60.0) == "too deep"
    assert store.held["Sea"].level_m == -10.0 and len(bench.history) == 1
    assert bench.to({"Sea": Sea(-70.0)}, "load") == "too deep"
    assert store.held["Sea"].level_m == -10.0 and "Air" in store.held and len(bench.history) == 1
    bench.undo()
    assert store.held["Sea"].level_m == 0.0


def test_a_history_has_an_end() -> None:
    history = History(3)
    for k in range(5):
        history.record([Edit("a", "x", k, k + 1)], "a.x")
        history.seal()
    assert len(history) == 3
    assert [history.undo()[0].new for _ in range(3)] == [4, 3, 2] and history.undo() == []
    with pytest.raises(ValueError, match="at least 1"):
        History(0)


def test_any_walk_can_be_undone_and_done_again_bit_for_bit() -> None:
    """Random changes, parts added and taken off, A and B: back to the beginning and forward again."""
    for seed in range(40):
        draw = random.Random(seed)
        bench = Workbench(Box())
        states = [bench.copy()]
        while len(states) < 25:
            kind = draw.randrange(6)
            here = bench.store.parts()
            if kind < 3 and "Sea" in here:
                turn(bench, "Sea", *draw.choice([("level_m", draw.uniform(-50, 50)), ("at_deg", draw.uniform(0, 90)),
                                                 ("at_m", draw.uniform(0, 90))]))  # fmt: skip
            elif kind == 3 and "Air" in here:
                bench.remove("Air")
            elif kind == 4 and "Air" not in here:
                bench.add("Air", Air(draw.uniform(0, 10)))
            elif kind == 5:
                bench.switch()
            bench.history.seal()
            if bench.copy() != states[-1]:
                states.append(bench.copy())
        assert len(bench.history) == len(states) - 1
        for state in reversed(states[:-1]):
            bench.undo()
            assert bench.copy() == state
        for state in states[1:]:
            bench.redo()
            assert bench.copy() == state


def test_states_are_copies(bench: Workbench) -> None:
    held = bench.copy()
    bench.store.parts()["Sea"].level_m = 50.0
    assert held["Sea"].level_m == 0.0 and bench.base["Sea"].level_m == 0.0
    assert dataclasses.replace(held["Sea"]) == held["Sea"]


def test_no_imgui_is_imported() -> None:
    """Neither by the memory of the panels nor by a renderer: only an interface that is drawn needs it."""
    code = (
        "import sys, planetfall as pf, planetfall.render.renderer, planetfall.app.window, planetfall.systems.tweak\n"
        "from planetfall.systems.tweak import Workbench\n"
        "print([m for m in sys.modules if m.startswith('imgui')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
