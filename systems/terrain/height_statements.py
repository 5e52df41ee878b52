"""Functions of numbers, read from their Python source, and what is made of them: their GLSL and their derivatives.

A function is a list of statements `name = expression` and a returned expression, or names of statements, of its
parameters, `k.constant`, numbers (also by name), + - * /, `** 0.5`, the functions below, and calls of functions of one
variable: `f(t)`, or `f(k, t)` of constants as well, whose derivatives are called `f_slope`. `a, b = other(k, ...)`
stands for the statements of `other`, which have the same names. Operations keep their order, so all that is made gives
the same bits as the source.

`name: Single = expression` is float in shaders that are else in double: there an operation of two doubles is made in
double and then rounded, of a double and anything else in float.

Derivatives are adjoint: from the last statement back to the first, `by_name` is the result's derivative by that name.
One number for each statement, whichever way the inputs vary. Changes go forward: statement by statement, how much it
changes when the inputs do; functions `f` that are called need an `f_change(t, d)` in the shader.
"""

from __future__ import annotations

import ast
import copy
import linecache
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
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
                if name in names:
                    slope = _slope(uses, name)
                    total = _sum(total, _product(ast.Name(f"by_{user}"), slope) if user else slope)
            lines.append((f"by_{name}", total or ast.Constant(0.0)))
            later.insert(0, (name, expression, _names(expression)))
        results: dict[str, ast.expr] = {f"by_{name}": ast.Name(f"by_{name}") for name in self.inputs}
        if len(results) > 1:
            results = {"value": value, **results, **{name: ast.Name(name) for name in shown}}
        name, kept = f"{self.name}_slope{'s' * (len(self.inputs) > 1)}", _needed(self.lines + lines, results)
        return Function(name, self.constants, (*self.inputs, *seen.values()), kept, results, seen=seen)

    def change(self) -> Function:
        """<name>_change of the inputs and of what is added to each, d_<input>: the value's change. No step subtracts
        numbers that are nearly the same, so its error is relative to the change."""
        (value,) = self.results.values()
        varied = {*self.inputs, *dict(self.lines)}
        lines: Lines = [*self.lines]
        for name, expression in [*((name, None) for name in self.inputs), *self.lines]:
            if expression is not None:
                lines.append((f"d_{name}", _known(_change(expression, varied))))
            lines.append((f"new_{name}", _known(_sum(ast.Name(name), ast.Name(f"d_{name}")))))
        results = {"value": _known(_change(value, varied))}
        inputs = (*self.inputs, *(f"d_{name}" for name in self.inputs))
        return Function(f"{self.name}_change", self.constants, inputs, _needed(lines, results), results)

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
                case ast.Return(ast.expr() as value) if len(lines) == len(dict(lines)):
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
        return [name for name in self._nodes if name != "shader"]

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

    def glsl(self, f: Function, real: str) -> str:
        """f as terrain_<name> in float or double. Several results are a struct, such as TerrainSurfaceSlopes, or
        TerrainSurfaceSlopesDouble."""
        text = _Glsl(self._known, f.singles, real)
        results = ", ".join(text.of(value, text.type_of(name)) for name, value in f.results.items())
        kind, struct = real, ""
        if len(f.results) > 1:
            kind = f"Terrain{f.name.title().replace('_', '')}{'Double' * (real == 'double')}"
            members = "".join(f"    {text.type_of(name)} {name};\n" for name in f.results)
            struct, results = f"struct {kind} {{\n{members}}};\n\n", f"{kind}({results})"
        head = [f"{f.constants} k"] * bool(f.constants) + [f"{real} {name}" for name in f.inputs]
        lines = [f"{text.type_of(name)} {f.read(name, text.of(value, text.type_of(name)))};" for name, value in f.lines]
        body = "\n    ".join([f"{kind} terrain_{f.name}({', '.join(head)}) {{", *lines, f"return {results};"])
        return f"{struct}{body}\n}}\n"


@dataclass(frozen=True)
class _Glsl:
    """Writes expressions. `real`: float or double, the type of all names but `singles`."""

    known: Mapping[str, Any]
    singles: frozenset[str]
    real: str

    def type_of(self, name: str) -> str:
        return "float" if name in self.singles else self.real

    def _is_number(self, node: ast.expr) -> bool:
        names = [n for n in ast.walk(node) if isinstance(n, ast.Name | ast.Attribute | ast.Call)]
        return all(isinstance(n, ast.Name) and isinstance(self.known.get(n.id), float) for n in names)

    def of(self, node: ast.expr, wanted: str, above: int = 0) -> str:
        """wanted: the type. above: how tightly the operator around it binds; a right operand of the same has
        parentheses."""
        if self._is_number(node):
            number = float(eval(ast.unparse(node), dict(self.known)))
            text = str(np.float32(number)) if wanted == "float" else f"{number!r}LF"
            return f"({text})" if number < 0.0 < above else text
        kinds = {self.type_of(name) for name in _names(node) - {"k"} - self.known.keys()}
        if kinds == {"float"} != {wanted} or (kinds == {"double"} != {wanted} and _is_of_names(node)):
            return f"{wanted}({self.of(node, next(iter(kinds)))})"
        match node:
            case ast.Name(name):
                return name
            case ast.Attribute(_, name):
                return f"k.{name}" if wanted == "float" else f"{wanted}(k.{name})"
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


# -- derivatives of expressions: None is 0 ---------------------------------------------------------------------------


def _slope(node: ast.expr, by: str) -> ast.expr | None:
    match node:
        case ast.Name(name):
            return _ONE if name == by else None
        case ast.Constant() | ast.Attribute():
            return None
        case ast.UnaryOp(ast.USub(), value):
            return _minus(_slope(value, by))
        case ast.Call(ast.Name(name), [*_, value]):
            return _product(ast.Call(ast.Name(f"{name}_slope"), node.args, []), _slope(value, by))
        case ast.BinOp(left, ast.Add(), right):
            return _sum(_slope(left, by), _slope(right, by))
        case ast.BinOp(left, ast.Sub(), right):
            return _sum(_slope(left, by), _minus(_slope(right, by)))
        case ast.BinOp(left, ast.Mult(), right):
            return _sum(_product(_slope(left, by), right), _product(left, _slope(right, by)))
        case ast.BinOp(left, ast.Div(), right):
            change = _sum(_slope(left, by), _minus(_product(node, _slope(right, by))))
            return None if change is None else ast.BinOp(change, ast.Div(), right)
        case ast.BinOp(left, ast.Pow(), ast.Constant(0.5)):
            return _product(ast.BinOp(ast.Constant(0.5), ast.Div(), node), _slope(left, by))
    raise ValueError(f"no derivative of {ast.unparse(node)}")


# -- changes of expressions: of a name x by d_x to new_x; None is 0 ---------------------------------------------------


def _change(node: ast.expr, varied: set[str]) -> ast.expr | None:
    if not _names(node) & varied:
        return None
    match node:
        case ast.Name(name):
            return ast.Name(f"d_{name}")
        case ast.UnaryOp(ast.USub(), value):
            return _minus(_change(value, varied))
        case ast.Call(ast.Name(name), [*k, value]):
            return ast.Call(ast.Name(f"{name}_change"), [*k, value, _known(_change(value, varied))], [])
        case ast.BinOp(left, ast.Add(), right):
            return _sum(_change(left, varied), _change(right, varied))
        case ast.BinOp(left, ast.Sub(), right):
            return _sum(_change(left, varied), _minus(_change(right, varied)))
        case ast.BinOp(left, ast.Mult(), right):
            new = _new(right, varied)
            return _sum(_product(_change(left, varied), new), _product(left, _change(right, varied)))
        case ast.BinOp(left, ast.Div(), right):
            change = _sum(_change(left, varied), _minus(_product(node, _change(right, varied))))
            return None if change is None else ast.BinOp(change, ast.Div(), _new(right, varied))
        case ast.BinOp(left, ast.Pow(), ast.Constant(0.5)):
            both = ast.BinOp(node, ast.Add(), _new(node, varied))
            return ast.BinOp(_known(_change(left, varied)), ast.Div(), both)
    raise ValueError(f"no change of {ast.unparse(node)}")


def _new(node: ast.expr, varied: set[str]) -> ast.expr:
    """The expression of the new values."""

    class New(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.Name:
            return ast.Name(f"new_{node.id}") if node.id in varied else node

    return New().visit(copy.deepcopy(node))


# -- both --------------------------------------------------------------------------------------------------------------


def _known(node: ast.expr | None) -> ast.expr:
    return ast.Constant(0.0) if node is None else node


def _sum(a: ast.expr | None, b: ast.expr | None) -> ast.expr | None:
    if a is None or b is None:
        return a if b is None else b
    if isinstance(b, ast.UnaryOp):
        return ast.BinOp(a, ast.Sub(), b.operand)
    return ast.BinOp(a, ast.Add(), b)


def _minus(a: ast.expr | None) -> ast.expr | None:
    return None if a is None else a.operand if isinstance(a, ast.UnaryOp) else ast.UnaryOp(ast.USub(), a)


def _product(a: ast.expr | None, b: ast.expr | None) -> ast.expr | None:
    if a is None or b is None:
        return None
    if isinstance(a, ast.UnaryOp):
        return _minus(_product(a.operand, b))
    if isinstance(b, ast.UnaryOp):
        return _minus(_product(a, b.operand))
    return b if a is _ONE else a if b is _ONE else ast.BinOp(a, ast.Mult(), b)


def _names(node: ast.expr) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
