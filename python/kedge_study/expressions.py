"""Arithmetic in the text of a study: Python's operators and a few functions, nothing else."""
import ast
import difflib
import functools
import re

import numpy as np

from . import StudyError


def norm(*components):
    """Length of a vector given by its components."""
    return np.sqrt(sum(np.square(component) for component in components))


def _whole(function):
    """Rounds single numbers to whole ones, which a key such as "load steps" asks for, and arrays as NumPy does."""
    def rounded(value):
        result = function(value)
        return int(result) if np.ndim(result) == 0 else result
    return rounded


FUNCTIONS = {
    **{name: getattr(np, name) for name in (
        "sqrt", "exp", "log", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh", "radians", "degrees", "abs", "mean",
        "where", "interp", "cumsum", "maximum", "minimum", "hypot", "sign", "diff", "ptp", "unwrap")},
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "asinh": np.arcsinh,
    "round": _whole(np.round), "floor": _whole(np.floor), "ceil": _whole(np.ceil), "norm": norm, "len": len,
    "min": lambda *values: np.min(values[0] if len(values) == 1 else values),
    "max": lambda *values: np.max(values[0] if len(values) == 1 else values),
    "sum": lambda values: np.sum(values), "text": lambda value: f"{value:g}"}
CONSTANTS = {"pi": np.pi, "e": np.e}
_NODES = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.Name, ast.Constant,
          ast.Subscript, ast.Slice, ast.Tuple, ast.List, ast.Load, ast.operator, ast.unaryop, ast.boolop, ast.cmpop)


def evaluate(expression, names, where, **functions):
    """The value of an expression: a number stands for itself. names: values by name; functions: further ones; where:
    the place in the study, for messages."""
    if not isinstance(expression, str):
        return expression
    code, used = _compiled(expression.strip(), where)
    known = {**FUNCTIONS, **CONSTANTS, **functions, **names}
    for name in used:
        if name not in known:
            close = difflib.get_close_matches(name, known, 1)
            hint = f"; did you mean {close[0]}?" if close else f"; known here: {', '.join(names) or 'nothing'}"
            raise StudyError(f"{where}: \"{expression}\": unknown name {name}{hint}")
    try:
        value = eval(code, {"__builtins__": {}}, known)  # only the nodes above, so nothing but arithmetic
    except (ArithmeticError, ValueError, TypeError, IndexError) as error:
        raise StudyError(f"{where}: \"{expression}\": {error}") from error
    return value.item() if isinstance(value, np.generic) else value


@functools.lru_cache(maxsize=None)
def _compiled(expression, where):
    """Code of an expression, and the names that it uses."""
    try:
        tree = ast.parse(expression, mode="eval")
    except SyntaxError as error:
        raise StudyError(f"{where}: \"{expression}\" is not an expression ({error.msg})") from error
    for node in ast.walk(tree):
        if not isinstance(node, _NODES):
            raise StudyError(f"{where}: \"{expression}\" is more than arithmetic ({type(node).__name__})")
        if isinstance(node, ast.Call) and not (isinstance(node.func, ast.Name) and not node.keywords):
            raise StudyError(f"{where}: \"{expression}\": only named functions without keywords can be called")
    return compile(tree, where, "eval"), [node.id for node in ast.walk(tree) if isinstance(node, ast.Name)]


def plain(name):
    """The name of a column or an answer as expressions have it."""
    return re.sub(r"^(?=\d)", "_", re.sub(r"[^A-Za-z0-9_]", "_", name))


def names_in(expression, where):
    """The names that an expression uses."""
    return _compiled(expression.strip(), where)[1] if isinstance(expression, str) else []


def resolve(value, names, where, **functions):
    """A JSON value whose texts that begin with "=" are replaced by the value of the expression behind it."""
    if isinstance(value, str) and value.startswith("="):
        return evaluate(value[1:], names, where, **functions)
    if isinstance(value, list):
        return [resolve(entry, names, f"{where}[{index}]", **functions) for index, entry in enumerate(value)]
    if isinstance(value, dict):
        return {key: resolve(entry, names, f"{where}.{key}", **functions) for key, entry in value.items()}
    return value
