"""Options of verbs: configs as flags that overlay an instance, and options that would do nothing refused."""

import ast
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from cyclopts import Parameter, Token, convert
from cyclopts.utils import default_name_transform

from ..errors import BadInput

JOIN = "__"
"""Between the names of nested fields in the Python name of a flag."""

SIGNED = ("yaw_deg", "pitch_deg", "video_offset")
"""Options that may be below 0."""

_GIVEN: ContextVar[frozenset[str]] = ContextVar("given", default=frozenset())


def verb(function: Callable[..., None]) -> Callable[..., None]:
    """A verb for the command line: each field of a config is a flag, `~` is opened in paths, what was given is known.

    A config is a parameter annotated `Parameter(name="*")` whose default is a dataclass. Its flags overlay that
    default, field by field, however deep.
    """
    parameters = inspect.signature(function).parameters
    hints = get_type_hints(function, include_extras=True)
    configs = {}
    flat = []
    for name, parameter in parameters.items():
        if is_dataclass(parameter.default):
            configs[name] = parameter.default
        flat += _flags(name, parameter, hints[name])

    def called(*args: Any, **kwargs: Any) -> None:
        bases = {}
        for name, config in configs.items():
            bases[name] = kwargs.pop(name, config)
        given = signature.bind(*args, **kwargs).arguments
        arguments = overlaid(bases, given)
        known = _GIVEN.set(frozenset(given))
        try:
            function(**arguments)
        finally:
            _GIVEN.reset(known)

    signature = inspect.Signature(flat)
    called.__name__ = function.__name__
    called.__doc__ = function.__doc__
    called.__module__ = function.__module__
    called.__annotations__ = {p.name: p.annotation for p in flat}
    setattr(called, "__signature__", signature)  # noqa: B010  (a function has none in its type)
    setattr(called, "configs", configs)  # noqa: B010
    return called


def overlaid(configs: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a verb: what was given, and each config with the flags that were given laid over it."""
    arguments = {}
    for name, value in given.items():
        first, *_ = name.split(JOIN)
        if first not in configs:
            _refuse_nan(name, value)
            _refuse_endless(name, value)
            _refuse_negative(name, value, 0)
            arguments[name] = _opened(value)
    for name, config in configs.items():
        arguments[name] = _overlay(config, name, given)
    return arguments


def _refuse_nan(name: str, value: Any) -> None:
    if any(number != number for number in _numbers(value)):
        raise BadInput(f"{flag_name(name)}: nan is no number that it can take")


def _refuse_endless(name: str, value: Any) -> None:
    """Infinity switches some settings of steps off; no option of a verb has a use for it."""
    if any(abs(number) == float("inf") for number in _numbers(value)):
        raise BadInput(f"{flag_name(name)}: {value} has no end; give a number")


def _refuse_negative(name: str, value: Any, default: Any) -> None:
    """Numbers are lengths, shares, weights and counts but for `SIGNED`, and fields that are below 0 by default."""
    if name.split(JOIN)[-1] in SIGNED:
        return
    if min(_numbers(default), default=0) >= 0 > min(_numbers(value), default=0):
        raise BadInput(f"{flag_name(name)}: {min(_numbers(value)):g} is below 0; give 0 or more")


def _numbers(value: Any) -> list[float]:
    values = value if isinstance(value, list | tuple) else [value]
    return [each for each in values if isinstance(each, int | float)]


def refuse_unused(mode: str, *names: str) -> None:
    """Refuse options that were given to the running verb and that do nothing in this mode.

    `names` are the verb's parameters; a config, or a part of one as `config.solve`, stands for all flags below it.

    Raises:
        BadInput: one was given.
    """
    for given in sorted(_GIVEN.get()):
        path = given.replace(JOIN, ".")
        if any(_stands_for(name, path) for name in names):
            flag = flag_name(given)
            raise BadInput(f"{flag} does nothing {mode}; leave it out")


def refuse_outside(name: str, value: float | None, low: float, high: float) -> None:
    """Refuse a number that no work should be begun with; None is none.

    Raises:
        BadInput: below `low` or above `high`.
    """
    if value is not None and not low <= value <= high:
        raise BadInput(f"{flag_name(name)}: {value:g} lies outside {low:g} to {high:g}")


def _stands_for(name: str, path: str) -> bool:
    """Whether a name is a flag's path, or a config that it lies below."""
    return path == name or path.startswith(f"{name}.")


def use_only(mode: str, options: Iterable[str], *used: str) -> None:
    """Refuse those of a verb's `options` that were given and are not `used` in this mode.

    Raises:
        BadInput: one was given.
    """
    others = [name for name in options if name not in used]
    refuse_unused(mode, *others)


def flag_name(parameter: str) -> str:
    """A parameter's flag: `save_attach` -> `--save-attach`, `config__solve__rounds` -> `--solve.rounds`."""
    first, *nested = parameter.split(JOIN)
    parts = nested or [first]
    spelled = map(default_name_transform, parts)
    return "--" + ".".join(spelled)


def is_internal(path: str) -> bool:
    """Whether a flag, by its Python name, is a setting of some step inside: a field of a config within a config."""
    return path.count(JOIN) > 1


def show_internals(called: Callable[..., None], show: bool = True) -> None:
    """Let a verb's help show every flag, or again those alone that a user needs."""
    shown = []
    for parameter in inspect.signature(called).parameters.values():
        annotation = parameter.annotation
        if is_internal(parameter.name):
            [mark] = annotation.__metadata__
            visible = Parameter.combine(mark, Parameter(show=show))
            annotation = Annotated[annotation.__origin__, visible]
        shown.append(parameter.replace(annotation=annotation))
    setattr(called, "__signature__", inspect.Signature(shown))  # noqa: B010
    called.__annotations__ = {p.name: p.annotation for p in shown}


def _flags(name: str, parameter: inspect.Parameter, hint: Any) -> Iterator[inspect.Parameter]:
    """The parameter itself, or one for every field of the config that is its default."""
    if not is_dataclass(parameter.default):
        whole = is_whole(get_args(hint)[0] if get_origin(hint) is Annotated else hint)
        annotation = Annotated[hint, Parameter(converter=_whole_numbers)] if whole else hint
        yield parameter.replace(annotation=annotation)
        return
    for path, kind, value, told in leaves(parameter.default, name):
        shown = Parameter(
            name=[flag_name(path)],
            help=told,
            show=not is_internal(path),
            consume_multiple=True,
            negative_iterable=(),
            negative_none=(),
            converter=_whole_numbers if is_whole(kind) else None,
        )
        yield inspect.Parameter(
            path,
            inspect.Parameter.KEYWORD_ONLY,
            default=value,
            annotation=Annotated[kind, shown],
        )


def is_whole(kind: Any) -> bool:
    """Whether a type asks for whole numbers."""
    return kind is int or any(is_whole(part) for part in get_args(kind) if get_origin(kind) is not Literal)


def _whole_numbers(kind: Any, tokens: Sequence[Token]) -> Any:
    """As without a converter, but numbers that are not whole are refused: cyclopts rounds them."""
    for token in tokens:
        try:
            broken = float(token.value) % 1 != 0
        except ValueError:
            continue
        if broken:
            raise ValueError(f'"{token.value}" is no whole number')
    return convert(kind, tokens)


def leaves(config: Any, name: str) -> Iterator[tuple[str, Any, Any, str]]:
    """Every field below a config that is no config itself: joined name, type, value, docstring."""
    kinds = get_type_hints(type(config), include_extras=True)
    docs = field_docs(type(config))
    for field in fields(config):
        value = getattr(config, field.name)
        path = f"{name}{JOIN}{field.name}"
        if is_dataclass(value):
            yield from leaves(value, path)
        else:
            told = docs.get(field.name, "")
            yield path, kinds[field.name], value, told


def _overlay(config: Any, name: str, given: Mapping[str, Any]) -> Any:
    changed = {}
    for field in fields(config):
        path = f"{name}{JOIN}{field.name}"
        value = getattr(config, field.name)
        if is_dataclass(value):
            changed[field.name] = _overlay(value, path, given)
        elif path in given:
            _refuse_nan(path, given[path])
            if not is_internal(path) and value != float("inf"):
                _refuse_endless(path, given[path])
            _refuse_negative(path, given[path], value)
            changed[field.name] = _opened(given[path])
    return replace(config, **changed)


def _opened(value: Any) -> Any:
    """A path with `~` opened, also in text that may be a path, and in lists of them."""
    if isinstance(value, list):
        return [_opened(item) for item in value]
    if isinstance(value, Path):
        return value.expanduser()
    if isinstance(value, str) and value.startswith("~/"):
        opened = Path(value).expanduser()
        return str(opened)
    return value


@cache
def field_docs(kind: type) -> Mapping[str, str]:
    """The string below each field of a class, on one line."""
    module = inspect.getmodule(kind)
    if module is None:
        return {}
    text = inspect.getsource(module)
    found = _classes(text).get(kind.__name__)
    if found is None:
        return {}
    return dict(_documented(found.body))


@cache
def _classes(source: str) -> dict[str, ast.ClassDef]:
    found = {}
    for node in ast.parse(source).body:
        if isinstance(node, ast.ClassDef):
            found[node.name] = node
    return found


def _documented(body: Sequence[ast.stmt]) -> Iterator[tuple[str, str]]:
    for field, below in pairwise(body):
        if not isinstance(field, ast.AnnAssign) or not isinstance(field.target, ast.Name):
            continue
        alone = ast.Module([below], [])
        text = ast.get_docstring(alone, clean=False)
        if text:
            words = text.split()
            yield field.target.id, " ".join(words)
