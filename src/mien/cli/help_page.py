"""A verb's help: what its docstring says, two examples, and the flags that a user needs; all of them on demand."""

import inspect

from cyclopts import App

from .examples import EXAMPLES
from .options import show_internals

ALL = "--help-all"


def with_help(app: App, verb: str, everything: bool) -> None:
    """Prepare a verb's page before it is printed."""
    page = app[verb]
    function = page.default_command
    if function is None:
        return
    page.help = described(function.__doc__ or "")
    page.help_epilogue = epilogue(verb, everything)
    show_internals(function, everything)


def described(docstring: str) -> str:
    """A docstring without its list of parameters."""
    text = inspect.cleandoc(docstring)
    text, *_ = text.split("\nParameters\n")
    return text.strip()


def epilogue(verb: str, everything: bool) -> str:
    """Examples, and where the rest is."""
    lines = [f"`{command}`: {what}" for command, what in EXAMPLES.get(verb, ())]
    if not everything:
        lines.append(f"Settings of the solvers: `mien {verb} {ALL}`.")
    return "\n\n".join(["Examples:", *lines])
