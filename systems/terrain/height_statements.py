"""Functions of numbers, read from their Python source, and what is made of them: their GLSL and their derivatives.

A function is a list of statements `name = expression` and a returned expression, or names of statements, of its
parameters, `k.constant`, numbers (also by name), + - * /, `** 0.5`, the functions below, and calls of functions of one
variable: `f(t)`, or `f(k, t)` of constants as well, whose derivatives are called `f_slope`. `a, b = other(k, ...)`
stands for the statements of `other`, which have the same names. Operations keep their order, so all that is made gives
the same bits as the source.

Shaders have them in float, or in pairs of floats (common/pair.glsl), where operators are calls. `name: Single =
expression` is float there, too: an operation of two pairs is made of pairs and then rounded, of a pair and anything
else in float.

Derivatives are adjoint: from the last statement back to the first, `by_name` is the result's derivative by that name.
One number for each statement, whichever way the inputs vary. Changes go forward: statement by statement, how much it
changes when the inputs do; functions `f` that are called are called `f_change`, with the same and with the change of
the one that changes. A derivative is a change's factor where the change is small: both have the same rules.
"""

from __future__ import annotations

import ast
import linecache
import pickle
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeAlias

import numpy as np

__all__ = ["Function", "Single", "Statements", "absolute", "at_least", "at_most", "clamp", "sign"]

Single: TypeAlias = Any


def clamp(t: Any, low: float, high: float) -> Any:
    if isinstance(t, float):
        return low if t < low else high if t > high else t
    return np.minimum(np.maximum(t, low), high)


def at_least(t: Any, low: float) -> Any:
    if isinstance(t, float):
        return t if t > low else low
    return np.maximum(t, low)


def at_most(t: Any, high: float) -> Any:
    return np.minimum(t, high)


absolute, sign = np.abs, np.sign
_BUILT_IN = {"clamp": "clamp", "at_least": "max", "at_most": "min", "absolute": "abs", "sign": "sign"}

_PAIRS = {"clamp": "pair_clamp", "at_least": "pair_max", "at_most": "pair_min", "absolute": "pair_abs"}
_PAIR_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "pair_add", ast.Sub: "pair_sub", ast.Mult: "pair_mul", ast.Div: "pair_div",
}  # fmt: skip

_ONE = ast.Constant(1.0)
_SIGNS: dict[type[ast.operator], tuple[str, int]] = {
    ast.Add: ("+", 1), ast.Sub: ("-", 1), ast.Mult: ("*", 2), ast.Div: ("/", 2),
}  # fmt: skip

Lines = list[tuple[str, ast.expr]]


@dataclass(frozen=True)
class Function:
    """`constants`: the type of k, "" without. `inputs`: the parameters after it. `lines`: (name, expression) in their
    order. `results`: name -> expression. `singles`: names of what is float. `seen`: names that derivatives read instead
    of others."""

    name: str
    constants: str
    inputs: tuple[str, ...]
    lines: Lines
    results: dict[str, ast.expr]
    singles: frozenset[str] = frozenset()
    seen: Mapping[str, str] = field(default_factory=dict)

    def only(self, name: str, results: Iterable[str]) -> Function:
        """A function of that name with some of the results, and the lines that they need."""
        wanted = {result: self.results[result] for result in results}
        return replace(self, name=name, results=wanted, lines=_needed(self.lines, wanted))

    def slopes(self, seen: Mapping[str, str], shown: Iterable[str] = ()) -> Function:
        """<name>_slopes of the inputs and of what is `seen`: the value, its derivatives by the inputs and the
        statements that are `shown`. Of one input <name>_slope, its derivative alone."""
        (value,) = self.results.values()
        lines: Lines = []
        later = [("", value, _names(value))]
        for name, expression in [*reversed(self.lines), *((name, _ONE) for name in self.inputs)]:
            total: ast.expr | None = None
            for user, uses, names in later:
                if name not in names:
                    continue
                for slope in _Changes({name}, finite=False).of(uses).values():
                    total = _sum(total, _product(ast.Name(f"by_{user}"), slope) if user else slope)
            lines.append((f"by_{name}", total or ast.Constant(0.0)))
            later.insert(0, (name, expression, _names(expression)))
        results: dict[str, ast.expr] = {f"by_{name}": ast.Name(f"by_{name}") for name in self.inputs}
        if len(results) > 1:
            results = {"value": value, **results, **{name: ast.Name(name) for name in shown}}
        name, kept = f"{self.name}_slope{'s' * (len(self.inputs) > 1)}", _needed(self.lines + lines, results)
        return Function(name, self.constants, (*self.inputs, *seen.values()), kept, results, seen=seen)

    def change(self, varied: Iterable[str] = (), results: Iterable[str] = ()) -> Function:
        """<name>_change of the inputs and of what is added to those that are `varied` (all), d_<input>: how much the
        value changes, or the `results`: names of statements, of their changes d_<name> and new values new_<name>. No
        step subtracts numbers that are nearly the same, so its error is relative to the change."""
        inputs = tuple(varied) or self.inputs
        changes = _Changes(set(inputs))
        lines: Lines = [(f"new_{name}", ast.Name(name)) for name in inputs]
        for name, expression in self.lines:
            lines.append((name, expression))
            if terms := changes.of(expression):
                changes.varied.add(name)
                lines += [(f"d_{name}", _whole(terms)), (f"new_{name}", changes.there(expression))]
        wanted: dict[str, ast.expr] = {name: ast.Name(name) for name in results}
        if not wanted:
            (value,) = self.results.values()
            wanted = {"value": _whole(changes.of(value))}
        known = {name for name, _ in _needed(lines, wanted)}.union(f"d_{name}" for name in inputs)
        for i, (name, _) in enumerate(lines):
            old = name.removeprefix("new_")
            if old != name and f"d_{old}" in known:
                lines[i] = name, ast.BinOp(ast.Name(old), ast.Add(), ast.Name(f"d_{old}"))
        added = (f"d_{name}" for name in inputs)
        return Function(f"{self.name}_change", self.constants, (*self.inputs, *added), _needed(lines, wanted), wanted)

    def read(self, name: str, text: str) -> str:
        """The text of the line of that name, which reads what is seen if it is a derivative."""
        for given, other in self.seen.items() if name.startswith("by_") else ():
            text = re.sub(rf"\b{given}\b", other, text)
        return f"{name} = {text}"


class Statements:
    """The functions of a module's source. `known`: the module's names, whose numbers are taken and which functions made
    here join."""

    def __init__(self, source: str, known: dict[str, Any]) -> None:
        self._nodes = {node.name: node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)}
        self._known = known

    def __getitem__(self, name: str) -> Function:
        """ValueError names a line that is no statement."""
        node, lines, singles = self._nodes[name], [], set()
        first, *others = node.args.args
        of_k = first.arg == "k" and first.annotation is not None
        constants = ast.unparse(first.annotation) if of_k and first.annotation else ""
        inputs = tuple(a.arg for a in (others if of_k else node.args.args))
        for line in node.body:
            match line:
                case ast.Expr(ast.Constant()):
                    pass
                case ast.Assign([ast.Name(target)], value):
                    lines.append((target, value))
                case ast.AnnAssign(ast.Name(target), ast.Name("Single"), ast.expr() as value):
                    lines.append((target, value))
                    singles.add(target)
                case ast.Assign([ast.Tuple()], ast.Call(ast.Name(other))):
                    lines += self[other].lines
                    singles |= self[other].singles
                case ast.Return(ast.expr() as value) if len({*inputs, *dict(lines)}) == len(inputs) + len(lines):
                    several = value.elts if isinstance(value, ast.Tuple) else []
                    results: dict[str, ast.expr] = {n.id: n for n in several if isinstance(n, ast.Name)}
                    results = results or {"value": value}
                    return Function(name, constants, inputs, lines, results, frozenset(singles))
                case _:
                    raise ValueError(f"{name}, line {line.lineno}: {ast.unparse(line)} is not a new name = expression")
        raise ValueError(f"{name} returns nothing")

    @property
    def names(self) -> list[str]:
        """Of functions that are statements, in their order."""
        return [name for name, node in self._nodes.items() if node.args.args]

    def python(self, f: Function) -> Any:
        """f as a function of k and the inputs: of one result its value, else a tuple."""
        results = ", ".join(map(ast.unparse, f.results.values()))
        lines = [f.read(name, ast.unparse(value)) for name, value in f.lines]
        head = ", ".join([*("k" for _ in (f.constants,) if f.constants), *f.inputs])
        body = "\n    ".join([f"def {f.name}({head}):", *lines, f"return {results}\n"])
        file = f"<made: {f.name}>"
        linecache.cache[file] = (len(body), None, body.splitlines(True), file)  # for tracebacks
        exec(compile(body, file, "exec"), self._known)
        return self._known[f.name]

    def scalar(self, f: Function) -> str:
        """f as Python for single numbers, to be compiled: k is a tuple of its fields, and roots are taken by `sqrt`."""
        writer = _Scalar(self._known, f)
        lines = [f.read(name, writer.of(value)) for name, value in f.lines]
        results = ", ".join(map(writer.of, f.results.values()))
        head = ", ".join([*("k" for _ in (f.constants,) if f.constants), *f.inputs])
        return "\n    ".join([f"def {f.name}({head}):", *lines, f"return {results}\n"])

    def glsl(self, f: Function, real: str) -> str:
        """f as terrain_<name> of float or Pair. Several results are a struct, such as TerrainSurfaceSlopes, or
        TerrainSurfaceSlopesPair."""
        text = _Glsl(self._known, f.singles, real)
        results = ", ".join(text.of(value, text.type_of(name)) for name, value in f.results.items())
        kind, struct = real, ""
        if len(f.results) > 1:
            kind = f"Terrain{f.name.title().replace('_', '')}{'Pair' * (real == 'Pair')}"
            members = "".join(f"    {text.type_of(name)} {name};\n" for name in f.results)
            struct, results = f"struct {kind} {{\n{members}}};\n\n", f"{kind}({results})"
        head = [f"{f.constants} k"] * bool(f.constants) + [f"{real} {name}" for name in f.inputs]
        lines = [f"{text.type_of(name)} {f.read(name, text.of(value, text.type_of(name)))};" for name, value in f.lines]
        body = "\n    ".join([f"{kind} terrain_{f.name}({', '.join(head)}) {{", *lines, f"return {results};"])
        return f"{struct}{body}\n}}\n"


class _Scalar(ast.NodeTransformer):
    """Writes expressions of single numbers. Numbers stand in place of their names."""

    def __init__(self, known: Mapping[str, Any], f: Function) -> None:
        self._known, self._own = known, {*f.inputs, *dict(f.lines)}
        kind = known[f.constants] if f.constants else None
        self._places = {field.name: i for i, field in enumerate(fields(kind))} if kind else {}

    def of(self, node: ast.expr) -> str:
        return ast.unparse(self.visit(_copied(node)))

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return ast.Subscript(node.value, ast.Constant(self._places[node.attr]))

    def visit_Name(self, node: ast.Name) -> ast.expr:
        number = None if node.id in self._own else self._known.get(node.id)
        return ast.Constant(number) if isinstance(number, float) else node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        if isinstance(node.op, ast.Pow):
            return ast.Call(ast.Name("sqrt"), [self.visit(node.left)], [])
        return self.generic_visit(node)  # pyright: ignore[reportReturnType]


@dataclass(frozen=True)
class _Glsl:
    """Writes expressions. `real`: float or Pair, the type of all names but `singles`."""

    known: Mapping[str, Any]
    singles: frozenset[str]
    real: str

    def type_of(self, name: str) -> str:
        return "float" if name in self.singles else self.real

    def _is_number(self, node: ast.AST) -> bool:
        if isinstance(node, ast.Name):
            return isinstance(self.known.get(node.id), float)
        if isinstance(node, ast.Attribute | ast.Call):
            return False
        return all(map(self._is_number, ast.iter_child_nodes(node)))  # up to the first that isn't

    def of(self, node: ast.expr, wanted: str, above: int = 0) -> str:
        """wanted: the type. above: how tightly the operator around it binds; a right operand of the same has
        parentheses."""
        if wanted == "Pair":
            text, kind = self.pair(node)
            return text if kind == "Pair" else f"pair({text})"
        if self._is_number(node):
            number = self.number(node)
            return f"({np.float32(number)})" if number < 0.0 < above else str(np.float32(number))
        if self.real == "Pair" and self._kinds(node) == {"Pair"} and _is_of_names(node):
            return f"{self.pair(node)[0]}.high"
        match node:
            case ast.Name(name):
                return name
            case ast.Attribute(_, name):
                return f"k.{name}"
            case ast.UnaryOp(ast.USub(), value):
                return f"(-{self.of(value, wanted, 3)})"
            case ast.Call(ast.Name(name), values):
                call = _BUILT_IN.get(name, f"terrain_{name}")
                return f"{call}({', '.join(self.of(value, wanted) for value in values)})"
            case ast.BinOp(left, ast.Pow(), ast.Constant(0.5)):
                return f"sqrt({self.of(left, wanted)})"
            case ast.BinOp(left, sign, right) if type(sign) in _SIGNS:
                text, binds = _SIGNS[type(sign)]
                both = f"{self.of(left, wanted, binds - 1)} {text} {self.of(right, wanted, binds)}"
                return f"({both})" if binds <= above else both
        raise ValueError(f"no GLSL for {ast.unparse(node)}")

    def _kinds(self, node: ast.expr) -> set[str]:
        return {self.type_of(name) for name in _names(node) - {"k"} - self.known.keys()}

    def number(self, node: ast.expr) -> float:
        if isinstance(node, ast.Constant):
            return float(node.value)  # pyright: ignore[reportArgumentType]
        return float(self.known[node.id]) if isinstance(node, ast.Name) else self._computed(node)

    def _computed(self, node: ast.expr) -> float:
        return float(eval(ast.unparse(node), dict(self.known)))

    def pair(self, node: ast.expr) -> tuple[str, str]:
        """The expression in pairs, and its type: what is a float is left one, for calls that take both."""
        if self._is_number(node):
            number = self.number(node)
            high = np.float32(number)
            low = np.float32(number - float(high))
            return (f"Pair({high}, {low})", "Pair") if low else (str(high), "float")
        if self._kinds(node) == {"float"} or isinstance(node, ast.Attribute):
            return self.of(node, "float", 3), "float"
        match node:
            case ast.Name(name):
                return name, "Pair"
            case ast.UnaryOp(ast.USub(), value):
                text, kind = self.pair(value)
                return (f"pair_neg({text})", kind) if kind == "Pair" else (f"(-{text})", kind)
            case ast.Call(ast.Name(name), [first, *others]) if name in _PAIRS:
                bounds = (f", {self.of(bound, 'float')}" for bound in others)
                return f"{_PAIRS[name]}({self.of(first, 'Pair')}{''.join(bounds)})", "Pair"
            case ast.Call(ast.Name(name), values):
                kinds = ("float" if ast.unparse(value) == "k" else "Pair" for value in values)
                given = ", ".join(map(self.of, values, kinds))
                return f"terrain_{name}({given})", "Pair"
            case ast.BinOp(left, ast.Pow(), ast.Constant(0.5)):
                return f"pair_sqrt({self.of(left, 'Pair')})", "Pair"
            case ast.BinOp(left, operator, right):
                (a, of_a), (b, of_b) = self.pair(left), self.pair(right)
                for text, of_text, other in ((a, of_a, right), (b, of_b, left)):
                    power = self.number(other) if of_text == "Pair" and self._is_number(other) else 0.0
                    if isinstance(operator, ast.Mult) and abs(np.frexp(power)[0]) == 0.5:
                        return f"pair_scaled({text}, {np.float32(power)})", "Pair"
                return f"{_PAIR_OPERATORS[type(operator)]}({a}, {b})", "Pair"
        raise ValueError(f"no GLSL of pairs for {ast.unparse(node)}")


def _is_of_names(node: ast.expr) -> bool:
    return not any(isinstance(n, ast.Constant | ast.Attribute | ast.Call) for n in ast.walk(node))


def _needed(lines: Lines, results: Mapping[str, ast.expr]) -> Lines:
    """The lines that the results read, directly or through others."""
    read: set[str] = set().union(*map(_names, results.values()))
    kept: Lines = []
    for name, expression in reversed(lines):
        if name in read:
            kept.insert(0, (name, expression))
            read |= _names(expression)
    return kept


# -- changes and derivatives of expressions ----------------------------------------------------------------------------

Terms = dict[str, ast.expr]
"""A change as a sum: what changes, as text, and its factor."""


@dataclass(frozen=True)
class _Changes:
    """How expressions change where names x that are `varied` do by d_x, to new_x. Not `finite`: in the limit of small
    changes, where the factor of d_x is the derivative."""

    varied: set[str]
    finite: bool = True

    def of(self, node: ast.expr) -> Terms:
        match node:
            case ast.Name(name):
                return {f"d_{name}": _ONE} if name in self.varied else {}
            case ast.Constant() | ast.Attribute():
                return {}
            case ast.UnaryOp(ast.USub(), value):
                return _negated(self.of(value))
            case ast.Call(ast.Name(name), values):
                match [terms for terms in map(self.of, values) if terms]:
                    case []:
                        return {}
                    case [terms] if self.finite:
                        return {ast.unparse(ast.Call(ast.Name(f"{name}_change"), [*values, _whole(terms)], [])): _ONE}
                    case [terms]:
                        slope = ast.Call(ast.Name(f"{name}_slope"), values, [])
                        return _scaled(terms, lambda factor: _product(slope, factor))
            case ast.BinOp(left, ast.Add(), right):
                return _joined(self.of(left), self.of(right), self.finite)
            case ast.BinOp(left, ast.Sub(), right):
                return _joined(self.of(left), _negated(self.of(right)), self.finite)
            case ast.BinOp(left, ast.Mult(), right):
                there = self.there(right)
                of_left = _scaled(self.of(left), lambda factor: _product(factor, there))
                of_right = _scaled(self.of(right), lambda factor: _product(left, factor))
                return _joined(of_left, of_right, self.finite)
            case ast.BinOp(left, ast.Div(), right):
                below = _scaled(self.of(right), lambda factor: _minus(_product(node, factor)))
                there, both = self.there(right), _joined(self.of(left), below, self.finite)
                return _scaled(both, lambda factor: ast.BinOp(factor, ast.Div(), there))
            case ast.BinOp(left, ast.Pow(), ast.Constant(0.5)):
                twice = ast.BinOp(node, ast.Add(), self.there(node))
                return _scaled(self.of(left), lambda factor: ast.BinOp(factor, ast.Div(), twice))
        raise ValueError(f"no change of {ast.unparse(node)}")

    def there(self, node: ast.expr) -> ast.expr:
        """The expression of the new values."""
        if not self.finite or not self.varied & _names(node):
            return node
        varied = self.varied

        class New(ast.NodeTransformer):
            def visit_Name(self, node: ast.Name) -> ast.Name:
                return ast.Name(f"new_{node.id}" if node.id in varied else node.id)

        return New().visit(_copied(node))


def _whole(terms: Terms) -> ast.expr:
    total: ast.expr | None = None
    for what, factor in terms.items():
        total = _sum(total, _product(factor, ast.parse(what, mode="eval").body))
    return total or ast.Constant(0.0)


def _joined(a: Terms, b: Terms, grouped: bool) -> Terms:
    return a | {what: (_grouped if grouped and what in a else _sum)(a.get(what), factor) for what, factor in b.items()}


def _grouped(a: ast.expr | None, b: ast.expr) -> ast.expr:
    """The sum, of products with the same first factor as one product."""
    match a, b.operand if isinstance(b, ast.UnaryOp) else b:
        case ast.BinOp(first, ast.Mult(), left), ast.BinOp(other, ast.Mult(), right):
            if ast.unparse(first) == ast.unparse(other):
                return _product(first, _sum(left, _minus(right) if isinstance(b, ast.UnaryOp) else right))
    return _sum(a, b)


def _negated(terms: Terms) -> Terms:
    return {what: _minus(factor) for what, factor in terms.items()}


def _scaled(terms: Terms, by: Callable[[ast.expr], ast.expr]) -> Terms:
    """The terms with other factors; several together have one."""
    together = {ast.unparse(_whole(terms)): _ONE} if len(terms) > 1 else terms
    return {what: by(factor) for what, factor in together.items()}


def _sum(a: ast.expr | None, b: ast.expr) -> ast.expr:
    if a is None:
        return b
    if isinstance(b, ast.UnaryOp):
        return ast.BinOp(a, ast.Sub(), b.operand)
    return ast.BinOp(a, ast.Add(), b)


def _minus(a: ast.expr) -> ast.expr:
    return a.operand if isinstance(a, ast.UnaryOp) else ast.UnaryOp(ast.USub(), a)


def _product(a: ast.expr, b: ast.expr) -> ast.expr:
    if isinstance(a, ast.UnaryOp):
        return _minus(_product(a.operand, b))
    if isinstance(b, ast.UnaryOp):
        return _minus(_product(a, b.operand))
    if isinstance(a, ast.BinOp) and a.left is _ONE and isinstance(a.op, ast.Div):
        return ast.BinOp(b, ast.Div(), a.right)
    return b if a is _ONE else a if b is _ONE else ast.BinOp(a, ast.Mult(), b)


def _copied(node: ast.expr) -> ast.expr:
    return pickle.loads(pickle.dumps(node))  # a third of copy.deepcopy's time


def _names(node: ast.expr) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
