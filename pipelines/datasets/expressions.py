"""Expressions of a plan: "$0.5 * speed_rpm" as a value of a scene, "speed_rpm * torque_N_m < 1.5e5" as a constraint.

Numbers, texts, names of variables, + - * / // % **, comparisons, and, or, not, and the functions of FUNCTIONS; nothing
else of Python is understood, so a plan of someone else can be tried without harm.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

MOST_CHARACTERS = 500
LARGEST_POWER = 1000.0  # exponent: whole numbers grow without end
_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: lambda base, exponent: math.pow(base, exponent),
}
_UNARY: dict[type, Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Not: operator.not_}
_COMPARED: dict[type, Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "min": min,
    "max": max,
    "round": round,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
}


class ExpressionError(ValueError):
    """A text is no expression, names what is unknown, or has no value."""


class Expression:
    """A text that was read; `names` are the variables in it.

    Raises
    ------
    ExpressionError : it is none
    """

    def __init__(self, text: str) -> None:
        if len(text) > MOST_CHARACTERS:
            raise ExpressionError(f"has {len(text)} characters, limit {MOST_CHARACTERS}; shorten it")
        try:
            self._tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise ExpressionError(
                "is not a valid expression; use numbers, names of variables and + - * / < > and or not"
            ) from error
        self.text = text
        found: dict[str, None] = {}
        _check(self._tree, found)
        self.names = tuple(found)

    def value(self, values: Mapping[str, Any]) -> Any:
        """Its value with those of the variables; ExpressionError if it has none."""
        try:
            return _value(self._tree, values)
        except (ArithmeticError, TypeError, ValueError) as error:
            raise ExpressionError(f"{self.text!r} has no value ({error})") from error


def _check(node: ast.AST, names: dict[str, None]) -> None:
    """Gather the names of an expression; ExpressionError for what is not understood."""
    if isinstance(node, ast.Constant):
        if not isinstance(node.value, bool | int | float | str):
            raise ExpressionError(f"{node.value!r} is neither a number nor a text")
        return
    if isinstance(node, ast.Name):
        names[node.id] = None
        return
    known = (
        (isinstance(node, ast.BinOp) and type(node.op) in _BINARY)
        or (isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY)
        or (isinstance(node, ast.Compare) and all(type(op) in _COMPARED for op in node.ops))
        or isinstance(node, ast.BoolOp)
        or (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in FUNCTIONS
            and not node.keywords
        )
    )
    if not known:
        raise ExpressionError(f"{ast.unparse(node)!r} is not allowed; allowed functions: {', '.join(FUNCTIONS)}")
    for child in node.args if isinstance(node, ast.Call) else ast.iter_child_nodes(node):
        if isinstance(child, ast.expr):
            _check(child, names)


def _value(node: Any, values: Mapping[str, Any]) -> Any:
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        if node.id not in values:
            raise ExpressionError(f"{node.id!r} is not a variable; allowed: {', '.join(values) or 'none'}")
        return values[node.id]
    if isinstance(node, ast.BinOp):
        left, right = _value(node.left, values), _value(node.right, values)
        if isinstance(node.op, ast.Pow) and abs(right) > LARGEST_POWER:
            raise ExpressionError(f"the exponent {right:g} is above the limit {LARGEST_POWER:g}")
        if isinstance(left, str) or isinstance(right, str):
            raise TypeError("texts can only be compared")
        return _BINARY[type(node.op)](left, right)
    if isinstance(node, ast.UnaryOp):
        return _UNARY[type(node.op)](_value(node.operand, values))
    if isinstance(node, ast.BoolOp):
        parts = (bool(_value(part, values)) for part in node.values)
        return all(parts) if isinstance(node.op, ast.And) else any(parts)
    if isinstance(node, ast.Compare):
        chain = [_value(part, values) for part in (node.left, *node.comparators)]
        pairs = zip(node.ops, chain, chain[1:], strict=False)
        return all(_COMPARED[type(op)](left, right) for op, left, right in pairs)
    return FUNCTIONS[node.func.id](*(_value(argument, values) for argument in node.args))
