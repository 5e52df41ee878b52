"""Functions of numbers, read from their Python source, and what is made of them: their GLSL and their derivatives.

A function is a list of statements `name = expression` and a returned expression, of its parameters, `k.constant`,
numbers (also by name), + - * /, `** 0.5`, and calls of functions of one variable: `f(t)`, or `f(k, t)` of constants as
well, whose derivatives are called `f_slope`. `a, b = other(k, ...)` stands for the statements of `other`, which have
the same names. Operations keep their order, so all that is made gives the same bits as the source.

Derivatives are adjoint: from the last statement back to the first, `by_name` is the result's derivative by that name.
One number for each statement, whichever way the inputs vary.
"""

from __future__ import annotations

import ast
import linecache
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

__all__ = ["Function", "Statements"]

_ONE = ast.Constant(1.0)
_SIGNS: dict[type[ast.operator], tuple[str, int]] = {
    ast.Add: ("+", 1), ast.Sub: ("-", 1), ast.Mult: ("*", 2), ast.Div: ("/", 2),
}  # fmt: skip

Lines = list[tuple[str, ast.expr]]


@dataclass(frozen=True)
class Function:
    """`inputs`: the parameters after k. `lines`: (name, expression) in their order. `results`: name -> expression.
    `seen`: names that derivatives read in place of others."""

    name: str
    inputs: tuple[str, ...]
    lines: Lines
    results: dict[str, ast.expr]
    seen: Mapping[str, str] = field(default_factory=dict)

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
        read, kept = set().union(*map(_names, results.values())), []
        for name, expression in reversed(self.lines + lines):
            if name in read:
                kept.insert(0, (name, expression))
                read |= _names(expression)
        name = f"{self.name}_slope{'s' * (len(self.inputs) > 1)}"
        return Function(name, (*self.inputs, *seen.values()), kept, results, seen)

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
        node, lines = self._nodes[name], []
        for line in node.body:
            match line:
                case ast.Expr(ast.Constant()):
                    pass
                case ast.Assign([ast.Name(target)], value):
                    lines.append((target, value))
                case ast.Assign([ast.Tuple()], ast.Call(ast.Name(other))):
                    lines += self[other].lines
                case ast.Return(ast.expr() as value) if len(lines) == len(dict(lines)):
                    return Function(name, tuple(a.arg for a in node.args.args[1:]), lines, {"value": value})
                case _:
                    raise ValueError(f"{name}, line {line.lineno}: {ast.unparse(line)} is not a new name = expression")
        raise ValueError(f"{name} returns nothing")

    def python(self, f: Function) -> Any:
        """f as a function of k and the inputs: of one result its value, else a tuple."""
        results = ", ".join(map(ast.unparse, f.results.values()))
        lines = [f.read(name, ast.unparse(value)) for name, value in f.lines]
        body = "\n    ".join([f"def {f.name}(k, {', '.join(f.inputs)}):", *lines, f"return {results}\n"])
        file = f"<made: {f.name}>"
        linecache.cache[file] = (len(body), None, body.splitlines(True), file)  # for tracebacks
        exec(compile(body, file, "exec"), self._known)
        return self._known[f.name]

    def glsl(self, f: Function, real: str) -> str:
        """f as terrain_<name> in float or double. surface_slopes returns a struct TerrainSurfaceSlopes of results."""
        results = ", ".join(self._glsl(value, real) for value in f.results.values())
        kind, struct = real, ""
        if len(f.results) > 1:
            kind = f"Terrain{f.name.title().replace('_', '')}"
            struct, results = f"struct {kind} {{\n    {real} {', '.join(f.results)};\n}};\n\n", f"{kind}({results})"
        head = ", ".join(["TerrainConstants k", *(f"{real} {name}" for name in f.inputs)])
        lines = [f"{real} {f.read(name, self._glsl(value, real))};" for name, value in f.lines]
        body = "\n    ".join([f"{kind} terrain_{f.name}({head}) {{", *lines, f"return {results};"])
        return f"{struct}{body}\n}}\n"

    def _glsl(self, node: ast.expr, real: str, above: int = 0) -> str:
        """above: how tightly the operator around it binds; a right operand of the same has parentheses."""
        names = [n for n in ast.walk(node) if isinstance(n, ast.Name | ast.Attribute | ast.Call)]
        if all(isinstance(n, ast.Name) and isinstance(self._known.get(n.id), float) for n in names):
            number = float(eval(ast.unparse(node), self._known))
            text = str(np.float32(number)) if real == "float" else f"{number!r}LF"
            return f"({text})" if number < 0.0 < above else text
        match node:
            case ast.Name(name):
                return name
            case ast.Attribute(_, name):
                return f"k.{name}" if real == "float" else f"{real}(k.{name})"
            case ast.UnaryOp(ast.USub(), value):
                return f"(-{self._glsl(value, real, 3)})"
            case ast.Call(ast.Name(name), values):
                return f"terrain_{name}({', '.join(self._glsl(value, real) for value in values)})"
            case ast.BinOp(left, ast.Pow(), ast.Constant(0.5)):
                return f"sqrt({self._glsl(left, real)})"
            case ast.BinOp(left, sign, right) if type(sign) in _SIGNS:
                text, binds = _SIGNS[type(sign)]
                both = f"{self._glsl(left, real, binds - 1)} {text} {self._glsl(right, real, binds)}"
                return f"({both})" if binds <= above else both
        raise ValueError(f"no GLSL for {ast.unparse(node)}")


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
