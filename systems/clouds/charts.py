"""Which maps of weather are held, drawn ahead and shown: two at a time, mixed; never a hole, never a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from .weather import STEP_S, moment_of

__all__ = ["Chart", "ChartDrawing", "Charts"]

FADE_FRAMES = 30
"""In which what was drawn late takes the place of what stood in for it."""
_AHEAD = 0.85
"""Share of the time from one map to the next in which the one after is drawn."""
_CLOSE_STEPS = 0.05
"""So long after the moment of the only map that is there, the next is there too: until then they hardly differ."""
_FAR_STEPS = 1.5
"""A map whose moment is farther away than this shows other weather: not even a stand-in."""


@dataclass(eq=False)
class Chart:
    """One map's place on the GPU. number: of its moment, in steps; None: nothing. drawn: tiles; complete: may be shown.
    coarse: drawn in one go for a moment between the whole numbers."""

    slot: int
    number: float | None = None
    drawn: int = 0
    complete: bool = False
    coarse: bool = False

    def is_of(self, number: int) -> bool:
        """Whether it shows the map of this number as it is meant to be."""
        return self.complete and not self.coarse and self.number == number


class ChartDrawing(Protocol):
    """Who draws."""

    @property
    def tiles(self) -> int:
        """Of a whole map."""
        ...

    def draw(self, chart: Chart, most: int | None) -> None:
        """Go on drawing: at most so many tiles, and no longer than a frame has time for; None: all the rest."""
        ...

    def draw_coarse(self, chart: Chart) -> None:
        """All of it at once, in little time."""
        ...


class Charts:
    """Three maps: two are shown, mixed by `share`, and the third is drawn meanwhile.

    Weather that goes on finds the next map drawn, tile by tile, before its time. After a jump of time (or of the
    weather itself) a coarse map stands in at once; fine ones are drawn in what time frames have for it, and fade in.
    cuts: how often what is shown has changed at once.
    """

    def __init__(self, drawing: ChartDrawing) -> None:
        self._drawing = drawing
        self.all = tuple(Chart(slot) for slot in range(3))
        self.first = self.second = self.all[0]
        self.share = 0.0
        self.cuts = 0
        self._end: float | None = None
        """Of the share, while it fades; None: it follows the time."""
        self._now: float | None = None
        """Of the last frame that missed a map, in steps."""
        self._ahead, self._ahead_from = -1, 0.0
        """Which map is drawn ahead of its time, and the share that was shown when that began."""

    @property
    def steady(self) -> bool:
        """Whether what is shown is what the time asks for."""
        return self._end is None and self.first.complete

    def forget(self) -> None:
        """The weather is another."""
        for chart in self.all:
            chart.number, chart.complete = None, False
        self._end = None

    def exact(self, time_s: float) -> None:
        """Show what this moment asks for, whatever that takes."""
        goal = moment_of(time_s)
        numbers = goal.maps if goal.share > 0.0 else (goal.first,)
        keep: list[Chart] = []
        for number in numbers:
            chart = self._of(number) or self._under_way(number) or self._spare(keep, numbers)
            if not chart.is_of(number):
                self._begin(chart, number)
                self._drawing.draw(chart, None)
            keep.append(chart)
        self._show(keep[0], keep[-1], goal.share, None)

    def running(self, time_s: float) -> None:
        """One frame of many."""
        moment = moment_of(time_s)
        first, second = self._of(moment.first), self._of(moment.first + 1) if moment.share > 0.0 else None
        if moment.share == 0.0:
            second = first
        if first is None or second is None:
            self._catch_up(time_s / STEP_S, moment.first)
            self._now = time_s / STEP_S
            return
        if self._end is None and self.first.complete:
            self._show(first, second, moment.share, None)
            ahead = moment.first + 2 if moment.share > 0.0 else moment.first + 1
            self._work_on(ahead, round(self._drawing.tiles * self._due(ahead, moment.share)))
        elif (self.first, self.second) == (first, second):
            self._fade(moment.share, done=None)
        elif self._going:
            self._fade(self._end or 0.0)
        elif self._alone is first:
            self._show(first, second, 0.0, moment.share)
        elif self._alone is second:
            self._show(first, second, 1.0, moment.share)
        else:
            self._show(self._alone, second, 0.0, 1.0)

    # -- what is shown -----------------------------------------------------------------------------------------------

    @property
    def _going(self) -> bool:
        """Whether one map fades into another."""
        return self._end is not None and self.share != self._end and self.first is not self.second

    @property
    def _alone(self) -> Chart:
        """The one map that is shown once the fade is over."""
        return self.second if self._end == 1.0 else self.first

    def _show(self, first: Chart, second: Chart, share: float, end: float | None) -> None:
        self.first, self.second, self.share, self._end = first, second, share, end

    def _fade(self, end: float, done: float | None = 0.0) -> None:
        """One step towards `end`. done: what `_end` is once it is there; 0: still not what the time asks for."""
        step = 1.0 / FADE_FRAMES
        self.share += min(max(end - self.share, -step), step)
        self._end = end
        if self.share == end:
            self._end = None if done is None else end

    def _catch_up(self, now: float, number: int) -> None:
        """A map of this moment is missing: work on it, and show meanwhile what is nearest."""
        if self._end not in (0.0, 1.0):
            self._end = 1.0 if self.share >= 0.5 else 0.0
        stays = self._alone
        if stays.number is None or not stays.complete or abs(stays.number - now) > _FAR_STEPS:
            stays = next(chart for chart in self.all if not chart.is_of(number) and not chart.is_of(number + 1))
            stays.number, stays.drawn, stays.coarse = now, 0, True
            self._drawing.draw_coarse(stays)
            stays.complete = True
            self.cuts += 1
            self._show(stays, stays, 0.0, 0.0)
        if self._going:
            self._fade(self._end)
        wanted = number if stays.is_of(number + 1) else number + 1
        # No haste where what is shown is what it was a moment ago; but a picture whose time stands still is soon done.
        haste = stays.coarse or stays.number is None or now == self._now
        near = 1.0 if haste else min(abs(now - stays.number) / _CLOSE_STEPS, 1.0)
        self._work_on(wanted, round(self._drawing.tiles * near))
        drawn = self._of(wanted)
        if drawn is not None and not self._going and not (stays.is_of(number) or stays.is_of(number + 1)):
            self._show(stays, drawn, 0.0, 1.0)

    # -- work --------------------------------------------------------------------------------------------------------

    def _of(self, number: int) -> Chart | None:
        return next((chart for chart in self.all if chart.is_of(number)), None)

    def _under_way(self, number: int) -> Chart | None:
        return next((c for c in self.all if c.number == number and not c.coarse and not c.complete), None)

    def _spare(self, keep: list[Chart], wanted: tuple[int, ...] = ()) -> Chart:
        """One that is neither in `keep` nor holds what is wanted."""
        return next(c for c in self.all if c not in keep and not any(c.is_of(number) for number in wanted))

    def _due(self, number: int, share: float) -> float:
        """How much of a map that is drawn ahead ought to be there. Evenly over what is left of its time: pictures that
        begin between two maps do not hurry after the whole of the third."""
        if number != self._ahead:
            self._ahead, self._ahead_from = number, share
        left = _AHEAD - self._ahead_from
        return 1.0 if share >= _AHEAD else max(share - self._ahead_from, 0.0) / left if left > 0.0 else 1.0

    def _begin(self, chart: Chart, number: int) -> None:
        if chart.number != number or chart.coarse or chart.complete:
            chart.number, chart.drawn, chart.complete, chart.coarse = number, 0, False, False

    def _work_on(self, number: int, due: int) -> None:
        """Draw until so many tiles of the map are there, within the frame's time."""
        if self._of(number) is not None:
            return
        chart = self._under_way(number) or self._spare([self.first, self.second])
        if due <= 0:
            return
        self._begin(chart, number)
        if due > chart.drawn:
            self._drawing.draw(chart, due - chart.drawn)
