"""Options of verbs: configs as flags that overlay an instance, and options that would do nothing refused."""

import ast
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from cyclopts import Parameter
from cyclopts.utils import default_name_transform

from ..errors import BadInput

JOIN = "__"
"""Between the names of nested fields in the Python name of a flag."""

_GIVEN: ContextVar[frozenset[str]] = ContextVar("given", default=frozenset())


def verb(function: Callable[..., None]) -> Callable[..., None]:
    """A verb for the command line: each field of a config is a flag, `~` is opened in paths, what was given is known.

    A config is a parameter annotated `Parameter(name="*")` whose default is a dataclass. Its flags overlay that
    default, field by field, however deep.
    """
    parameters = inspect.signature(function).parameters
    hints = get_type_hints(function, include_extras=True)
    configs = {name: p.default for name, p in parameters.items() if is_dataclass(p.default)}
    flat = [flag for name, p in parameters.items() for flag in _flags(name, p, hints[name])]

    def called(*args: Any, **kwargs: Any) -> None:
        bases = {name: kwargs.pop(name, config) for name, config in configs.items()}
        given = signature.bind(*args, **kwargs).arguments
        known = _GIVEN.set(frozenset(given))
        try:
            return function(**overlaid(bases, given))
        finally:
            _GIVEN.reset(known)

    signature = inspect.Signature(flat)
    called.__name__, called.__doc__, called.__module__ = function.__name__, function.__doc__, function.__module__
    called.__annotations__ = {p.name: p.annotation for p in flat}
    setattr(called, "__signature__", signature)  # noqa: B010  (a function has none in its type)
    setattr(called, "configs", configs)  # noqa: B010
    return called


def overlaid(configs: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a verb: what was given, and each config with the flags that were given laid over it."""
    arguments = {}
    for name, value in given.items():
        if name.split(JOIN)[0] not in configs:
            arguments[name] = _opened(value)
    for name, config in configs.items():
        arguments[name] = _overlay(config, name, given)
    return arguments


def refuse_unused(mode: str, *names: str) -> None:
    """Refuse options that were given to the running verb and that do nothing in this mode.

    `names` are the verb's parameters; a config, or a part of one as `config.solve`, stands for all flags below it.

    Raises:
        BadInput: one was given.
    """
    for given in sorted(_GIVEN.get()):
        path = given.replace(JOIN, ".")
        if any(path == name or path.startswith(f"{name}.") for name in names):
            raise BadInput(f"{flag_name(given)} does nothing {mode}; leave it out")


def use_only(mode: str, options: Iterable[str], *used: str) -> None:
    """Refuse those of a verb's `options` that were given and are not `used` in this mode.

    Raises:
        BadInput: one was given.
    """
    refuse_unused(mode, *(name for name in options if name not in used))


def flag_name(parameter: str) -> str:
    """A parameter's flag: `save_attach` -> `--save-attach`, `config__solve__rounds` -> `--solve.rounds`."""
    first, *nested = parameter.split(JOIN)
    return "--" + ".".join(default_name_transform(part) for part in (nested or [first]))


def _flags(name: str, parameter: inspect.Parameter, hint: Any) -> Iterator[inspect.Parameter]:
    """The parameter itself, or one for every field of the config that is its default."""
    if not is_dataclass(parameter.default):
        yield parameter.replace(annotation=hint)
        return
    for path, kind, value, told in leaves(parameter.default, name):
        shown = Parameter(
            name=[flag_name(path)], help=told, consume_multiple=True, negative_iterable=(), negative_none=()
        )
        yield inspect.Parameter(path, inspect.Parameter.KEYWORD_ONLY, default=value, annotation=Annotated[kind, shown])


def leaves(config: Any, name: str) -> Iterator[tuple[str, Any, Any, str]]:
    """Every field below a config that is no config itself: joined name, type, value, docstring."""
    kinds, docs = get_type_hints(type(config), include_extras=True), field_docs(type(config))
    for field in fields(config):
        value = getattr(config, field.name)
        path = f"{name}{JOIN}{field.name}"
        if is_dataclass(value):
            yield from leaves(value, path)
        else:
            yield path, kinds[field.name], value, docs.get(field.name, "")


def _overlay(config: Any, name: str, given: Mapping[str, Any]) -> Any:
    changed = {}
    for field in fields(config):
        path, value = f"{name}{JOIN}{field.name}", getattr(config, field.name)
        if is_dataclass(value):
            changed[field.name] = _overlay(value, path, given)
        elif path in given:
            changed[field.name] = given[path]
    return replace(config, **changed)


def _opened(value: Any) -> Any:
    """A path with `~` opened, also in text that may be a path."""
    if isinstance(value, Path):
        return value.expanduser()
    if isinstance(value, str) and value.startswith("~/"):
        return str(Path(value).expanduser())
    return value


@cache
def field_docs(kind: type) -> Mapping[str, str]:
    """The string below each field of a class, on one line."""
    module = inspect.getmodule(kind)
    classes = _classes(inspect.getsource(module)) if module else {}
    body: Sequence[ast.stmt] = classes[kind.__name__].body if kind.__name__ in classes else ()
    return dict(_documented(body))


@cache
def _classes(source: str) -> dict[str, ast.ClassDef]:
    return {node.name: node for node in ast.parse(source).body if isinstance(node, ast.ClassDef)}


def _documented(body: Sequence[ast.stmt]) -> Iterator[tuple[str, str]]:
    for field, below in pairwise(body):
        text = ast.get_docstring(ast.Module([below], []), clean=False) if isinstance(field, ast.AnnAssign) else None
        if text and isinstance(field.target, ast.Name):
            yield field.target.id, " ".join(text.split())
