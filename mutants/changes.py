"""The single changes that can be made in a file.

What is changed is what runs: comparisons, and / or, signs, arithmetic, numbers, conditions, results, minima and maxima,
the order of arguments, calls made for their effect. Left alone are what only people or checkers read (docstrings,
annotations, texts, what is raised, ``__all__``), ``strict=`` of ``zip``, and numbers below 1e-5, which guard against
rounding and whose size nobody can feel.
"""

from __future__ import annotations

import ast
import copy
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["Change", "changed", "changes", "sample"]

_COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
_PAIRS = (
    ("min", "max"),
    ("minimum", "maximum"),
    ("nanmin", "nanmax"),
    ("fmin", "fmax"),
    ("argmin", "argmax"),
    ("floor", "ceil"),
    ("any", "all"),
    ("sin", "cos"),
)
_OTHER_NAME = {a: b for pair in _PAIRS for a, b in (pair, pair[::-1])}
_TYPES_AS_ARGUMENTS = {"isinstance", "issubclass", "cast", "TypeVar", "Literal", "getattr", "hasattr"}
# Whichever argument stands first, these give the same.
_EITHER_WAY = {"hypot", "logaddexp", "array_equal", "samestat", "both", "either", "differ"}
_LEFT_ALONE = (ast.Import, ast.ImportFrom, ast.Raise, ast.JoinedStr, ast.Assert, ast.Global)
_SMALLEST = 1e-5
_STATEMENTS = {"statement", "loop"}


@dataclass(frozen=True)
class Change:
    """One change.

    Parameters
    ----------
    kind : str
        What sort of change: "comparison", "sign", "number" ...
    scope : str
        The outermost function, or method with its class, that is changed; "" for the module's own statements.
    line : int
        First line, from 1.
    was, now : str
        Source of the expression or statement before and after, in normal form.
    start, end : int
        The bytes that are replaced.
    site : int
        How many equal expressions stand before this one in the same scope.
    """

    kind: str
    scope: str
    line: int
    was: str
    now: str
    start: int
    end: int
    site: int

    def place(self, *more: object) -> str:
        """Return a name of the place which stays the same when the code moves to another line or file."""
        return _digest(self.scope, self.was, self.site, *more)


def changes(source: str) -> list[Change]:
    """Return every change that can be made in a file."""
    visitor = _Visitor(source)
    visitor.body(ast.parse(source))
    return visitor.found


def changed(source: str, change: Change) -> str:
    """Return the source with one change made; every other line stays where it is."""
    raw = source.encode()
    new = change.now if change.kind in _STATEMENTS else f"({change.now}"
    new += "\n" * raw[change.start : change.end].count(b"\n")
    new += "" if change.kind in _STATEMENTS else ")"
    return (raw[: change.start] + new.encode() + raw[change.end :]).decode()


def sample(everything: dict[str, list[Change]], number: int, seed: int) -> list[tuple[str, Change]]:
    """Draw changes, each place alike and no place twice, so that a draw stays as it is when code elsewhere changes."""
    places: dict[str, list[tuple[str, Change]]] = {}
    for file, found in everything.items():
        for change in found:
            places.setdefault(_digest(seed, change.place(change.start, file)), []).append((file, change))
    ordered = sorted(places.values(), key=lambda here: here[0][1].place(seed))
    return [min(here, key=lambda each: each[1].place(seed, each[1].now)) for here in ordered[:number]]


class _Visitor:
    def __init__(self, source: str) -> None:
        self.found: list[Change] = []
        self._starts = [0]
        for line in source.encode().splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))
        self._scope: list[str] = []
        self._outermost = ""
        self._seen: dict[tuple[str, str, int], int] = {}
        self._count: dict[tuple[str, str], int] = {}

    def body(self, node: ast.AST) -> None:
        for child in ast.iter_child_nodes(node):
            self._visit(child)

    def _visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            self._function(node)
        elif isinstance(node, ast.ClassDef):
            self._inside(node, node.body)
        elif isinstance(node, _LEFT_ALONE) or self._is_read_only(node):
            return
        elif isinstance(node, ast.AnnAssign):
            if node.value is not None and "TypeAlias" not in ast.unparse(node.annotation):
                self._visit(node.value)
        elif isinstance(node, ast.Call) and _callee(node) in _TYPES_AS_ARGUMENTS:
            for argument in node.args[:1]:
                self._visit(argument)
        else:
            for kind, other in _others(node):
                self._add(kind, node, other)
            for test in _tests(node):
                self._add("condition", test, ast.UnaryOp(ast.Not(), test))
            self.body(node)

    def _is_read_only(self, node: ast.AST) -> bool:
        """Return whether only people and checkers read what stands here."""
        match node:
            case ast.Assign(value=ast.BinOp(op=ast.BitOr())) if not self._scope:
                return True  # a union of types
            case ast.Assign():
                return _names_all(node)
            case ast.If():
                return "TYPE_CHECKING" in ast.unparse(node.test)
            case ast.Call():
                return _callee(node).endswith(("Error", "Warning")) or _callee(node) == "warn"
            case ast.keyword():
                return node.arg in {"strict", "encoding", "help", "dtype"}
        return False

    def _function(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        if any("overload" in ast.unparse(d) for d in node.decorator_list):
            return
        defaults = [*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)]
        self._inside(node, [*defaults, *node.body])

    def _inside(self, node: ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef, inner: list[ast.AST]) -> None:
        outermost = self._outermost
        self._scope.append(node.name)
        if not outermost and not isinstance(node, ast.ClassDef):
            self._outermost = ".".join(self._scope)
        for child in inner:
            self._visit(child)
        self._scope.pop()
        self._outermost = outermost

    def _add(self, kind: str, node: ast.AST, other: ast.AST) -> None:
        assert isinstance(node, ast.expr | ast.stmt)
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        was, now = ast.unparse(node), ast.unparse(other)
        if was == now:
            return
        start = self._starts[node.lineno - 1] + node.col_offset
        end = self._starts[node.end_lineno - 1] + node.end_col_offset
        place = (self._outermost, was, start)
        if place not in self._seen:
            self._seen[place] = self._count.get(place[:2], 0)
            self._count[place[:2]] = self._seen[place] + 1
        self.found.append(Change(kind, self._outermost, node.lineno, was, now, start, end, self._seen[place]))


def _others(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield what may stand in a node's stead."""
    match node:
        case ast.Compare():
            for k, operator in enumerate(node.ops):
                for other in _COMPARISONS[type(operator)]:
                    new = copy.deepcopy(node)
                    new.ops[k] = other()
                    yield "comparison", new
        case ast.BoolOp():
            yield "and / or", ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
        case ast.BinOp() if type(node.op) in _ARITHMETIC and not (_is_text(node.left) or _is_text(node.right)):
            yield "arithmetic", ast.BinOp(node.left, _ARITHMETIC[type(node.op)](), node.right)
        case ast.UnaryOp(op=ast.USub() | ast.Not() | ast.Invert()):
            yield "sign" if isinstance(node.op, ast.USub) else "not", node.operand
        case ast.Constant(value=bool(value)):
            yield "truth", ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield "number", ast.Constant(value + 1)
            yield "number", _number(value - 1)
        case ast.Constant(value=float(value)) if value == 0 or _SMALLEST <= abs(value) < float("inf"):
            yield "number", ast.Constant(2 * value if value else 1.0)
            yield "number", ast.Constant(value / 2 if value else 0.5)
        case ast.IfExp():
            yield "condition", ast.IfExp(node.test, node.orelse, node.body)
        case ast.Call():
            yield from _other_calls(node)
        case ast.AugAssign() if type(node.op) in _ARITHMETIC and not _is_text(node.value):
            yield "statement", ast.AugAssign(node.target, _ARITHMETIC[type(node.op)](), node.value)
        case ast.Expr(value=ast.Call()):
            yield "statement", ast.Pass()
        case ast.Break():
            yield "loop", ast.Continue()
        case ast.Continue():
            yield "loop", ast.Break()
        case ast.Return(value=ast.Tuple(elts=[first, second, *rest])):
            yield "statement", ast.Return(ast.Tuple([second, first, *rest], ast.Load()))
        case ast.Return(value=ast.expr()) if not _is_constant(node.value):
            yield "statement", ast.Return(ast.Constant(None))


def _tests(node: ast.AST) -> list[ast.expr]:
    """Return the conditions that a node asks, those left out that a changed comparison turns about already."""
    asked = [node.test] if isinstance(node, ast.If) else node.ifs if isinstance(node, ast.comprehension) else []
    return [test for test in asked if not isinstance(test, ast.UnaryOp | ast.BoolOp)]


def _other_calls(node: ast.Call) -> Iterator[tuple[str, ast.AST]]:
    name = _callee(node)
    if name in _OTHER_NAME:
        new = copy.deepcopy(node)
        if isinstance(new.func, ast.Name):
            new.func.id = _OTHER_NAME[name]
        elif isinstance(new.func, ast.Attribute):
            new.func.attr = _OTHER_NAME[name]
        yield "minimum / maximum", new
    elif len(node.args) >= 2 and name not in _EITHER_WAY and not any(isinstance(a, ast.Starred) for a in node.args[:2]):
        new = copy.deepcopy(node)
        new.args[:2] = [new.args[1], new.args[0]]
        yield "arguments", new


def _number(value: int) -> ast.expr:
    return ast.Constant(value) if value >= 0 else ast.UnaryOp(ast.USub(), ast.Constant(-value))


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))


def _is_constant(node: ast.AST | None) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _names_all(node: ast.Assign) -> bool:
    return any(isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets)


def _callee(node: ast.Call) -> str:
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()
