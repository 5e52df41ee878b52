"""Suite frame: whole frames at 640 x 360."""

from __future__ import annotations

from collections.abc import Mapping

from ... import view, views
from ..knobs import PAIRS, QUALITY_PAIRS, QUALITY_VIEW
from ..machine import resident_bytes
from ..measure import frames
from ..measure.knobs import KnobCost, KnobMeter
from ..session import Bench, Session
from ..target import at_most

SIZE, QUICK_SIZE = (640, 360), (320, 180)
QUALITIES = ("low", "medium", "high")
TABLE_VIEWS = ("near", "high", "orbit")
PROMISED_MS = 50.0


def _total(session: Session) -> None:
    """Milliseconds a frame: camera turning, still, and the proxy snapping."""
    for quality in QUALITIES:
        with session.renderer("earth", SIZE, quality) as renderer:
            names = TABLE_VIEWS if session.quick else views(renderer.scene.planet)
            for name in names:
                found = frames.time_frames(renderer, view(name), session.runs(15, 5))
                promised = quality == "medium" and name in TABLE_VIEWS
                statistics = renderer.stats
                session.row(
                    quality, name, SIZE, found.turning, target=at_most(PROMISED_MS, "ms") if promised else None,
                    target_on="ms", still_ms=found.still.ms, snap_ms=found.snapping.ms,
                    update_ms=found.python_ms, cells=statistics["cells"], triangles=statistics["triangles"],
                )  # fmt: skip


def _passes(session: Session) -> None:
    """Milliseconds by pass, each waited for: the parts add up to more than the whole."""
    for quality in ("medium",) if session.quick else QUALITIES:
        with session.renderer("earth", SIZE, quality) as renderer:
            for name in TABLE_VIEWS:
                for pass_name, timing in frames.time_passes(renderer, view(name), session.runs(9, 4)).items():
                    session.row(f"{quality}: {pass_name}", name, SIZE, timing)


def _skipping(session: Session) -> None:
    """What runs again although nothing has changed, and what is drawn of a planet out of view."""
    with session.renderer("earth", SIZE, "medium") as renderer:
        for name in TABLE_VIEWS:
            found = frames.skipping(renderer, view(name))
            session.row(
                "selected or made again", name, error=len(found.ran_again), target=at_most(0),
                which=", ".join(found.ran_again), passes=found.passes, skipped=found.skipped,
            )  # fmt: skip
            session.row("uploads of an unchanged frame", name, error=found.uploads, target=at_most(0))
            session.row("triangles drawn out of view", name, error=found.drawn_out_of_view, target=at_most(0))


def _memory(session: Session) -> None:
    """Memory of the GPU's objects and of the process."""
    for quality in QUALITIES:
        with session.renderer("earth", SIZE, quality) as renderer:
            for name in TABLE_VIEWS:
                renderer.render(view(name))
            counts = {kind: 0 for kind in ("texture", "buffer")}
            for kinds in renderer.gpu.counts().values():
                for kind in counts:
                    counts[kind] += kinds.get(kind, 0)
            session.row(quality, size=SIZE, error=renderer.graph.memory_bytes() / 2**20, error_unit="MiB in the graph",
                        resident_mib=resident_bytes() / 2**20, textures=counts["texture"],
                        buffers=counts["buffer"])  # fmt: skip


def _knobs(session: Session) -> None:
    """What each knob costs and what it shows: both pictures of its pair. Quick: small, without colours, which cost
    nothing, and without quality knobs."""
    size, runs = QUICK_SIZE if session.quick else SIZE, session.runs(9, 3)

    def row(key: str, planet: str, name: str, found: KnobCost) -> None:
        session.row(
            key, name if planet == "earth" else f"{planet}: {name}", size, found.on, error=found.mean_flip,
            error_unit="FLIP", off_ms=found.off.ms, on_over_off=found.ratio, apart=found.apart,
            worst_flip=found.worst_flip, on=str(found.on_value), off=str(found.off_value),
        )  # fmt: skip

    session.release()
    with KnobMeter(size) as meter:
        for key, pair in PAIRS.items():
            if not (session.quick and key.endswith("_albedo")):
                row(key, pair.planet, pair.view, meter.knob(key, pair, runs))
        for key, values in () if session.quick else QUALITY_PAIRS.items():
            row(f"quality {key}", *QUALITY_VIEW, meter.quality_knob(key, values, QUALITY_VIEW, runs))


BENCHES: Mapping[str, Bench] = {
    "total": _total,
    "passes": _passes,
    "skipping": _skipping,
    "memory": _memory,
    "knobs": _knobs,
}
