"""In which order the passes run, and which version of a resource a reader sees.

Firm edges: after=, the stages of a resource's writers, and creator before each reader and writer of its resource. Then,
for each reader of a resource and each other writer of it: if firm edges lead from the reader to the writer, the reader
comes first and sees the earlier version; else the writer comes first. The writers of a resource must then lie on one
line; those of different views or planets, which cannot name each other, take turns as they were declared.
"""

from __future__ import annotations

import heapq
import itertools
from dataclasses import dataclass

from .errors import GraphError
from .model import GraphModel
from .stages import RANK


@dataclass(frozen=True, slots=True)
class Edge:
    """`before` runs before `after`; kind: "after", "stage", "creates", "writes", "reads", "turns"; resource: None
    for "after"."""

    before: int
    after: int
    kind: str
    resource: str | None


@dataclass(slots=True)
class Order:
    """sequence: all passes in running order; position: its inverse; seen[(pass, resource)]: the passes that made the
    version of the resource that the pass reads or modifies, in running order (creator first)."""

    sequence: list[int]
    position: list[int]
    seen: dict[tuple[int, str], list[int]]
    edges: dict[tuple[int, int], Edge]


def order_passes(model: GraphModel) -> Order:
    """Stable topological order: the pass declared first goes first wherever the rules leave it open.

    Raises GraphError for cycles, reads before any write, and writers of one resource in no order.
    """
    edges: dict[tuple[int, int], Edge] = {}

    def add(before: int, after: int, kind: str, resource: str | None) -> None:
        edges.setdefault((before, after), Edge(before, after, kind, resource))

    for i in range(len(model.passes)):
        for before in model.after[i]:
            add(before, i, "after", None)
    for name, writers in model.writers.items():
        staged = [(RANK[stage], i) for i in writers if (stage := model.passes[i].stage)]
        for (before, i), (after, j) in itertools.permutations(staged, 2):
            if before < after:
                add(i, j, "stage", name)
    for name, creator in model.creator.items():
        for i in (*model.writers[name], *model.readers[name]):
            add(creator, i, "creates", name)
    firm = _reachable(len(model.passes), edges, _sort(model, edges))

    for name, writers in model.writers.items():
        for reader in model.readers[name]:
            for writer in writers:
                if firm[reader] >> writer & 1:
                    add(reader, writer, "reads", name)
                else:
                    add(writer, reader, "writes", name)
    sequence = _sort(model, edges)
    position = [0] * len(sequence)
    for place, i in enumerate(sequence):
        position[i] = place
    reach = _reachable(len(sequence), edges, sequence)

    seen: dict[tuple[int, str], list[int]] = {}
    for name, writers in model.writers.items():
        line = sorted(writers, key=position.__getitem__)
        loose = [pair for pair in itertools.pairwise(line) if not reach[pair[0]] >> pair[1] & 1]
        # Two that are next to each other and of different views or planets may hide a pair that isn't.
        for earlier, later in itertools.combinations(line, 2) if loose else ():
            if reach[earlier] >> later & 1:
                continue
            if _apart(model, earlier, later):
                if (earlier, later) in loose:
                    add(earlier, later, "turns", name)
                continue
            raise _loose_error(model, name, earlier, later)
        makers = sorted(model.makers(name), key=position.__getitem__)
        for i in (*writers, *model.readers[name]):
            seen[i, name] = [m for m in makers if position[m] < position[i]]
    return Order(sequence, position, seen, edges)


def _loose_error(model: GraphModel, resource: str, earlier: int, later: int) -> GraphError:
    a, b = model.name(earlier), model.name(later)
    one, other = model.passes[earlier].stage, model.passes[later].stage
    if one and one == other:
        where, stage = f", in stage {one!r}", f"give it a stage other than {one!r}"
    elif one or other:
        where, stage = "", f"give it a stage, too, as {a if one else b!r} has ({one or other!r})"
    else:
        where, stage = "", "give it a stage (stage= of both)"
    return GraphError(
        f"passes {a!r} and {b!r} both write {resource!r}{where} and nothing says which comes first: declare {b!r} with"
        f" after=({a!r},), or the other way round (after_optional= if that pass may be absent), or {stage}."
    )


def _apart(model: GraphModel, a: int, b: int) -> bool:
    """Whether two passes are of different views or of different planets."""
    one, other = model.passes[a].scope, model.passes[b].scope
    views, planets = {one.view, other.view} - {None}, {one.planet, other.planet} - {None}
    return len(views) > 1 or len(planets) > 1


def _sort(model: GraphModel, edges: dict[tuple[int, int], Edge]) -> list[int]:
    count = len(model.passes)
    following: list[list[int]] = [[] for _ in range(count)]
    waiting = [0] * count
    for before, after in edges:
        following[before].append(after)
        waiting[after] += 1
    ready = [i for i in range(count) if waiting[i] == 0]
    sequence: list[int] = []
    while ready:
        i = heapq.heappop(ready)
        sequence.append(i)
        for j in following[i]:
            waiting[j] -= 1
            if waiting[j] == 0:
                heapq.heappush(ready, j)
    if len(sequence) < count:
        raise _cycle_error(model, _find_cycle(edges, [i for i in range(count) if waiting[i] > 0]))
    return sequence


def _reachable(count: int, edges: dict[tuple[int, int], Edge], sequence: list[int]) -> list[int]:
    """For each pass the set of passes behind it, as bits of an int."""
    following: list[list[int]] = [[] for _ in range(count)]
    for before, after in edges:
        following[before].append(after)
    reach = [0] * count
    for i in reversed(sequence):
        for j in following[i]:
            reach[i] |= reach[j] | 1 << j
    return reach


def _find_cycle(edges: dict[tuple[int, int], Edge], stuck: list[int]) -> list[Edge]:
    """One cycle among passes that all wait for another stuck one: walk backwards until a pass repeats."""
    stuck_set = set(stuck)
    waits_for: dict[int, Edge] = {}
    for (before, after), edge in edges.items():
        if before in stuck_set and after in stuck_set:
            waits_for.setdefault(after, edge)
    path: list[Edge] = []
    visited: dict[int, int] = {}
    i = stuck[0]
    while i not in visited:
        visited[i] = len(path)
        path.append(waits_for[i])
        i = waits_for[i].before
    return path[visited[i] :][::-1]


def _cycle_error(model: GraphModel, cycle: list[Edge]) -> GraphError:
    data = [edge for edge in cycle if edge.kind != "after"]
    if len(data) == 1 and data[0].kind == "creates":
        edge = data[0]
        assert edge.resource is not None
        reader, creator = model.name(edge.after), model.name(edge.before)
        verb = "writes" if edge.after in model.writers[edge.resource] else "reads"
        return GraphError(
            f"pass {reader!r} {verb} {edge.resource!r} before any pass has written it: pass {creator!r} creates it, but"
            f" is declared to run after {reader!r} ({_chain(model, cycle)}). Drop that after=; or, if last frame's"
            f" content is meant, give {edge.resource!r} lifetime='history' and name it in history= of {reader!r}."
        )
    hints = [
        f"If {model.name(e.after)!r} is to see {e.resource!r} before {model.name(e.before)!r} changes it, declare"
        f" {model.name(e.before)!r} with after=({model.name(e.after)!r},)."
        for e in cycle
        if e.kind == "writes"
    ]
    if any(edge.kind == "stage" for edge in cycle):
        hints.append("Give one of the writers another stage, or drop the after= that goes against it.")
    hints.append("Else drop one of these, or read last frame's content with history=.")
    return GraphError(f"the passes wait for each other in a circle: {_chain(model, cycle)}. {' '.join(hints)}")


def _chain(model: GraphModel, cycle: list[Edge]) -> str:
    return "; ".join(describe(model, edge) for edge in cycle)


def describe(model: GraphModel, edge: Edge) -> str:
    """One edge in words."""
    before, after = model.name(edge.before), model.name(edge.after)
    if edge.kind == "after":
        return f"{after!r} is declared after {before!r}"
    if edge.kind == "stage":
        one, other = model.passes[edge.before].stage, model.passes[edge.after].stage
        return f"{after!r} writes {edge.resource!r} after {before!r} by its stage ({one!r} before {other!r})"
    if edge.kind == "creates":
        verb = "writes" if edge.resource in model.passes[edge.after].writes else "reads"
        return f"{after!r} {verb} {edge.resource!r}, which {before!r} creates"
    if edge.kind == "writes":
        return f"{after!r} reads {edge.resource!r}, which {before!r} writes"
    if edge.kind == "turns":
        return f"{after!r} writes {edge.resource!r} in its turn after {before!r}, of another view or planet"
    return f"{after!r} writes {edge.resource!r}, which {before!r} reads first"
