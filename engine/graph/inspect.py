"""The graph in words and as a drawing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from .backend import BarrierKind
from .checked import Checked
from .names import qualified
from .order import describe
from .report import PassReport
from .resources import TextureSpec

_BARRIERS = {int(BarrierKind.TEXTURE): "textures", int(BarrierKind.BUFFER): "buffers"}


class Running(Protocol):
    """What a plan adds to its graph: sizes, bytes and the last frame."""

    @property
    def passes(self) -> Sequence[PassReport]: ...
    def texels(self, resource: str) -> tuple[int, ...]: ...
    def bytes_of(self, name: str) -> int: ...


def barriers(analysis: Checked) -> str:
    """Every storage barrier in running order, with the hazards that it closes; several lines."""
    alive, placed = analysis.alive, [*analysis.barriers.before, analysis.barriers.at_end]
    lines = []
    for place, kinds in enumerate(placed):
        if kinds:
            of = " and ".join(text for bit, text in _BARRIERS.items() if kinds & bit)
            before = repr(alive[place]) if place < len(alive) else "whoever reads the exports"
            lines.append(f"before {before}: a barrier for {of}")
            lines += [f"    {text}" for text in _hazards(analysis, place)]
    return "\n".join(lines) or "no pass stores from a compute shader: no barrier"


def _hazards(analysis: Checked, place: int) -> list[str]:
    alive = analysis.alive
    return [
        f"{h.resource!r} was {'stored' if h.stored else 'last used'} by {alive[h.earlier]!r}"
        + ("" if h.stored else ", before this pass stores over it")
        if h.earlier < len(alive)
        else f"{h.resource!r} was read as an export, before this pass stores over it"
        for h in analysis.barriers.because.get(place, [])
    ]


def explain(analysis: Checked, pass_name: str, plan: Running | None = None) -> str:
    """Several lines on one pass; with a plan also sizes, bytes and the last frame. Raises GraphError if unknown."""
    i = analysis.find(pass_name)
    model, culling = analysis.model, analysis.culling
    decl = model.passes[i]
    title = f"pass {decl.name!r} ({', '.join(filter(None, (decl.system and f'system {decl.system}', decl.kind)))})"
    lines = [f"{title}: {decl.help}" if decl.help else title]
    if i in culling.why_culled:
        lines.append(f"  culled: {culling.why_culled[i]}")
    else:
        place = culling.alive.index(i)
        lines.append(f"  runs as {place + 1} of {len(culling.alive)}, because {culling.why_alive[i]}")
        if place in analysis.barriers.because:
            lines += [f"  behind a storage barrier: {text}" for text in _hazards(analysis, place)]
    owners = [f"{what} {n}" for what, n in (("view", decl.scope.view), ("planet", decl.scope.planet)) if n is not None]
    if len({other.scope for other in model.passes}) > 1:
        lines.append(f"  of {', '.join(owners) or 'all views and planets'}")
    if decl.stage:
        lines.append(f"  writes in stage {decl.stage!r}")
    if decl.when is not None:
        lines.append("  only in frames in which its when() says yes")
    if decl.only_while is not None:
        alone = "" if i in analysis.together else ", were it not read outside of its group"
        lines.append(f"  skipped with its group in frames in which only_while() says no{alone}")

    for verb, names in (
        ("creates", [spec.name for spec in decl.creates]),
        ("writes", decl.writes),
        ("reads", model.reads[i]),
        ("last frame's", decl.history),
    ):
        lines += [f"  {verb} {_resource(analysis, name, plan)}" for name in names]
    lines += [
        f"  without {n!r}, which nobody creates (optional)" for n in decl.reads_optional if n not in model.readers
    ]
    lines += [f"  order: {describe(model, e)}" for e in analysis.order.edges.values() if i in (e.before, e.after)]
    if plan is not None and i in culling.why_alive:
        report = next(r for r in plan.passes if r.name == decl.name)
        if report.ran:
            gpu = "" if report.gpu_ms is None else f", {report.gpu_ms:.3f} ms GPU"
            lines.append(f"  last frame: {report.cpu_ms:.3f} ms CPU{gpu}")
        else:
            lines.append(f"  last frame: skipped, {report.skipped_why}")
    return "\n".join(lines)


def _resource(analysis: Checked, name: str, plan: Running | None) -> str:
    spec = analysis.model.specs.get(name)
    if spec is None:
        return f"{name!r}: imported {analysis.model.imports[name].kind}"
    if isinstance(spec, TextureSpec):
        if plan is not None:
            size = " x ".join(str(n) for n in plan.texels(name))
        else:
            size = f"{spec.size} of the view" if spec.relative else " x ".join(str(n) for n in spec.resolve((1, 1)))
        text = f"{name!r}: {spec.lifetime} texture {spec.format}, {size}"
    else:
        text = f"{name!r}: {spec.lifetime} buffer, {spec.size_bytes} bytes"
    if name not in analysis.lifetimes.span:
        return f"{text}, not allocated"
    if plan is not None and isinstance(spec, TextureSpec):
        text += f", {plan.bytes_of(name)} bytes"
    for tenants in analysis.lifetimes.shared:
        others = [repr(n) for n in tenants if n != name]
        if name in tenants and others:
            text += f", shares its memory with {', '.join(others)}"
    return text


def to_mermaid(analysis: Checked) -> str:
    """A mermaid flowchart. Boxes: passes, grouped by system (and view or planet); rounded: imports and exports;
    arrows: the resource that flows; dotted arrows: last frame's content, or what a culled pass would have used; dashed
    boxes: culled passes."""
    model, order, culling = analysis.model, analysis.order, analysis.culling
    lines = ["flowchart LR"]
    systems: dict[str, list[int]] = {}
    for i in order.sequence:
        decl = model.passes[i]
        box = decl.system and qualified(decl.system, decl.scope.view, decl.scope.planet)
        systems.setdefault(box, []).append(i)
    for n, (system, members) in enumerate(systems.items()):
        if system:
            lines.append(f'    subgraph s{n}["{_text(system)}"]')
        for i in members:
            kind = "" if model.passes[i].kind == "raster" else f"<br/>({model.passes[i].kind})"
            lines.append(f'        p{i}["{_text(model.name(i))}{kind}"]')
        if system:
            lines.append("    end")

    # What systems lend flows from nowhere.
    imports = [name for name, spec in model.imports.items() if spec.lent is None]
    ends = {name: n for n, name in enumerate((*imports, *(e for e in model.exports if e not in imports)))}
    drawn: set[str] = set()
    arrows: dict[tuple[str, str, bool], list[str]] = {}

    def arrow(source: str, target: str, dotted: bool, label: str) -> None:
        arrows.setdefault((source, target, dotted), []).append(_text(label))
        drawn.update((source, target))

    for i in order.sequence:
        for name in (*model.reads[i], *model.passes[i].writes):
            makers = order.seen[i, name]
            dotted = i in culling.why_culled or (bool(makers) and makers[-1] in culling.why_culled)
            # A reader takes from the last maker that runs; a culled one in between is not on the way.
            living = [m for m in makers if m in culling.why_alive] if i in culling.why_alive else makers
            if living:
                arrow(f"p{living[-1]}", f"p{i}", dotted, name)
            elif name in model.reads[i] and name in ends:
                # The first writer of an import has no arrow in: it would only mirror the one out.
                arrow(f"e{ends[name]}", f"p{i}", dotted, name)
        for name in model.passes[i].history:
            last = max(model.makers(name), key=order.position.__getitem__)
            arrow(f"p{last}", f"p{i}", True, f"last frame: {name}")
    for name in model.exports:
        makers = sorted(model.makers(name), key=order.position.__getitem__)
        if makers:
            arrow(f"p{makers[-1]}", f"e{ends[name]}", False, name)
        else:
            drawn.add(f"e{ends[name]}")

    lines += [f'    e{n}(["{_text(name)}"])' for name, n in ends.items() if f"e{n}" in drawn]
    for (source, target, dotted), labels in arrows.items():
        line = "-.->" if dotted else "-->"
        lines.append(f'    {source} {line}|"{"<br/>".join(dict.fromkeys(labels))}"| {target}')
    if culling.why_culled:
        lines.append("    classDef culled stroke-dasharray: 5 5, color:#888")
        lines.append(f"    class {','.join(f'p{i}' for i in culling.why_culled)} culled")
    return "\n".join(lines) + "\n"


def _text(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;").replace(">", "&gt;")
