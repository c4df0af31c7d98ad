"""Flags overlay the config that is a verb's default; what was given and does nothing is refused."""

import inspect
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import pytest
from cyclopts import App, Parameter

from mien.cli.main import PIPELINE, app
from mien.cli.options import JOIN, field_docs, flag_name, leaves, overlaid, refuse_unused, verb
from mien.errors import BadInput


@dataclass(frozen=True)
class Inner:
    rounds: int = 2
    """Times
    round."""
    weight: float = 0.5
    on: bool = True
    steps: tuple[float, ...] = (1.0,)


@dataclass(frozen=True)
class Outer:
    inner: Inner = Inner(rounds=7, weight=-1.5, on=False, steps=(3.0, -2.0))
    name: str = "a"
    other: Inner = field(default=Inner(weight=9.0))


def called_with(*words: str):
    """What a verb with a config is called with."""
    seen = []

    @verb
    def act(
        place: Path = Path("x"), *, text: str = "", config: Annotated[Outer, Parameter(name="*")] = Outer(name="b")
    ) -> None:
        """Act."""
        refuse_unused("when we test", *(["place", "config.other"] if text == "strict" else []))
        seen.append((place, text, config))

    App(default_command=act, result_action="return_value")(list(words), exit_on_error=False, print_error=False)
    return seen[0]


def test_no_flags_give_the_instance_that_is_the_default():
    assert called_with() == (Path("x"), "", Outer(name="b"))


def test_one_flag_leaves_its_siblings_as_the_instance_has_them():
    config = called_with("--inner.rounds", "8")[2]
    assert config == Outer(inner=Inner(rounds=8, weight=-1.5, on=False, steps=(3.0, -2.0)), name="b")


def test_home_is_opened_in_paths_and_in_text_that_is_one():
    place, text, _ = called_with("~/take", "--text", "~/scan.ply")
    assert place == Path.home() / "take"
    assert text == str(Path.home() / "scan.ply")


@pytest.mark.parametrize(
    ("words", "flag"),
    [(["y"], "--place"), (["--other.rounds", "2"], "--other.rounds"), (["--other.steps", "1"], "--other.steps")],
)
def test_what_does_nothing_is_refused_even_at_its_default(words, flag):
    with pytest.raises(BadInput, match=f"^{flag} does nothing when we test; leave it out$"):
        called_with(*words, "--text", "strict")
    called_with(*words)


def test_what_does_something_is_not_refused():
    assert called_with("--inner.rounds", "3", "--text", "strict")[2].inner.rounds == 3


def test_names_and_docstrings_of_flags():
    assert flag_name("save_attach") == "--save-attach"
    assert flag_name(f"config{JOIN}inner{JOIN}still_mm") == "--inner.still-mm"
    assert field_docs(Inner) == {"rounds": "Times round."}


def words_for(flag: str, value) -> list[str]:
    """A command line's words that say a flag at a value."""
    if isinstance(value, bool):
        *above, name = flag.removeprefix("--").split(".")
        return [flag if value else "--" + ".".join([*above, f"no-{name}"])]
    if isinstance(value, tuple):
        return [flag, *(str(item) for item in value)]
    return [f"{flag}={value}"]


@pytest.mark.parametrize("name", list(PIPELINE))
def test_every_flag_of_every_verb_at_its_printed_default_changes_nothing(name):
    function = app[name].default_command
    if not function.configs:
        return
    flags = [leaf for config_name, config in function.configs.items() for leaf in leaves(config, config_name)]
    words = [name, *(["fit"] if name == "detail" else []), "take"]
    words += ["--output=x"] if "output" in inspect.signature(function).parameters else []
    for path, _, value, told in flags:
        assert told, f"{path} has no docstring"
        words += [] if value in (None, ()) else words_for(flag_name(path), value)
    _, bound, _ = app.parse_args(words, exit_on_error=False, print_error=False)
    for path, _, value, _ in flags:
        if value in (None, ()):
            continue
        assert path in bound.kwargs, path
        alone = {path: bound.kwargs[path]}
        assert overlaid(function.configs, alone) == function.configs, path
