"""A pytest plugin that switches one step off: `$MIEN_MUTANT` says which, as `tools/mutants.py` lists them."""

import gc
import importlib
import inspect
import os
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from functools import wraps
from typing import Any

import numpy as np


def pytest_configure() -> None:
    """Patch before any test module is imported."""
    if line := os.environ.get("MIEN_MUTANT"):
        switch_off(line)


def switch_off(line: str) -> None:
    """`module:function = expression`, the same of a method, or `module:Class.field = value`; see `switched` below."""
    place, _, off = (part.strip() for part in line.partition(" = "))
    module_name, _, name = place.partition(":")
    module = importlib.import_module(f"mien.{module_name}")
    if "." in name:
        owner, member = name.split(".")
        kind = getattr(module, owner)
        if inspect.isfunction(vars(kind).get(member)):
            setattr(kind, member, switched(getattr(kind, member), off))
        else:
            set_field(kind, member, eval(off))
        return
    original = getattr(module, name)
    new = switched(original, off)
    for other in list(sys.modules.values()):
        if getattr(other, "__name__", "").startswith("mien."):
            for key, value in list(vars(other).items()):
                if value is original:
                    setattr(other, key, new)


def switched(original: Callable[..., Any], off: str) -> Callable[..., Any]:
    """The function with its result replaced: in `off`, `a` holds its arguments by name, `r` is its own result."""
    code, signature = compile(off, "mutant", "eval"), inspect.signature(original)
    needs_result = "r" in code.co_names

    @wraps(original)
    def stand_in(*args: Any, **kwargs: Any) -> Any:
        bound = signature.bind(*args, **kwargs)
        bound.apply_defaults()
        result = original(*args, **kwargs) if needs_result else None
        return eval(code, {"a": dict(bound.arguments), "r": result, "np": np, "replace": replace})

    return stand_in


def set_field(kind: type, name: str, value: object) -> None:
    """The default of a config's field, also in those that are made already."""
    default = next(field.default for field in fields(kind) if field.name == name)
    made = kind.__init__

    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        made(self, *args, **kwargs)
        if getattr(self, name) == default:
            object.__setattr__(self, name, value)

    kind.__init__ = init
    setattr(kind, name, value)
    for thing in gc.get_objects():
        if type(thing) is kind and getattr(thing, name) == default:
            object.__setattr__(thing, name, value)
