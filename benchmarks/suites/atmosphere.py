"""Suite atmosphere: errors of the air against the float64 reference, its run time, and what is skipped."""

from __future__ import annotations

from collections.abc import Mapping

from ... import AtmosphereProbe
from ..measure import air
from ..session import Bench, Session
from ..target import at_most

QUALITIES = ("low", "medium", "high", "ultra", "paper")
PROMISED = "high"


def _truths(session: Session, planet: str) -> dict[air.Quantity, air.Truth]:
    """The reference's answers: a minute or two for both planets."""
    found: dict[air.Quantity, air.Truth] = {}
    for quantity in air.KINDS:
        if quantity in ("total", "aerial total", "irradiance"):
            most = 30 if quantity == "irradiance" and not session.quick else session.runs(100, 20)
            found[quantity] = air.truth_of(planet, quantity, most, session.runs(32_768, 2048))
        else:
            found[quantity] = air.truth_of(planet, quantity, session.runs(2000, 300))
    return found


def _accuracy(session: Session) -> None:
    """The table of promises: every class of question, on Earth and on the small planet."""
    for planet, model in air.PLANETS.items():
        truths = _truths(session, planet)
        for quality in (PROMISED,) if session.quick else QUALITIES:
            with AtmosphereProbe(air.scene_of(model), quality=quality) as probe:
                found = {quantity: air.answers(probe, truth) for quantity, truth in truths.items()}
            for promise in air.PROMISES:
                errors = air.errors(truths[promise.quantity], found[promise.quantity], promise.groups)
                session.row(
                    f"{planet}, {quality}: {promise.name}",
                    error=errors.values[promise.statistic],
                    error_unit=promise.statistic,
                    target=at_most(promise.limit) if quality == PROMISED else None,
                    anchor=promise.anchor if planet == "earth" and promise.anchor > 0.0 else None,
                    worst=errors.values["wrel max" if promise.statistic.startswith("w") else "rel max"],
                    bad=errors.values["bad"],
                    noise=errors.noise_p95,
                    answers=errors.count,
                )
            session.row(
                f"{planet}, {quality}: night side from space glows",
                error=air.glow(truths["single"], found["single"]),
                error_unit="of the day",
                target=at_most(1e-3) if quality == PROMISED else None,
                anchor=None,
            )


BENCHES: Mapping[str, Bench] = {"accuracy": _accuracy}
