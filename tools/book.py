"""Gather the documentation's pages: `python tools/book.py FOLDER`. `make docs` then builds them.

Pages are docs/*.md as they stand, a page a verb from the command line's own help, a page an example from its docstring
and code, and a gallery of docs/pictures; the researcher's tutorial is a notebook too.
"""

import ast
import inspect
import json
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mien.cli.examples import EXAMPLES
from mien.cli.help_page import described
from mien.cli.main import PIPELINE, app
from mien.cli.options import is_internal, show_internals

ROOT = Path(__file__).resolve().parent.parent
PAGE = "python tools/page_pictures.py docs/pictures"
GALLERY = {
    "preview.png": ("A marker take, solved", "make demo"),
    "scans.png": ("Scans with their markers, registered, and how far the result is from the scan", "mien demo scans"),
    "blender.png": ("A performance in Blender 5, rendered by Cycles", "make test-clients"),
    "studio.png": ("The page: a face, its sliders, its curves with corrections", PAGE),
    "studio_compare.png": ("Two performances, coloured by how far apart they are", PAGE),
    "studio_markers.png": ("Markers, and where each sits on the skin", PAGE),
    "studio_map.png": ("A capture's map: its landmarks, one moved by hand", PAGE),
    "studio_scans.png": ("A point that is the same on two scans", PAGE),
    "rgbd.png": ("Colour, depth and the tracked face at moments of a film", "mien demo rgbd"),
}
"""Pictures of docs/pictures: what they show, and the command that makes them."""


def gather(folder: Path) -> list[Path]:
    """Write all pages into a folder; gives them."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder, ignore=shutil.ignore_patterns("*.yml"))
    (folder / "verbs").mkdir()
    (folder / "examples").mkdir()
    (folder / "index.md").write_text(front_page())
    (folder / "changelog.md").write_text((ROOT / "CHANGELOG.md").read_text())
    (folder / "gallery.md").write_text(gallery())
    tutorial = folder / "tutorials" / "researcher.md"
    tutorial.with_suffix(".ipynb").write_text(json.dumps(notebook(tutorial.read_text()), indent=1) + "\n")
    for verb in PIPELINE:
        (folder / "verbs" / f"{verb}.md").write_text(verb_page(verb))
    for path in sorted((ROOT / "examples").glob("*.py")):
        (folder / "examples" / f"{path.stem}.md").write_text(example_page(path))
    return sorted(folder.rglob("*.md"))


def front_page() -> str:
    """The README, its links turned to the book's pages."""
    text = (ROOT / "README.md").read_text()
    return text.replace("](docs/", "](").replace("](CHANGELOG.md)", "](changelog.md)")


def gallery() -> str:
    """Pictures, each with its command."""
    parts = ["# Gallery"]
    for name, (what, command) in GALLERY.items():
        parts.append(f"![{what}](pictures/{name})\n\n*{what}: `{command}`.*")
    return "\n\n".join(parts) + "\n"


def notebook(page: str) -> dict:
    """A page as a Jupyter notebook (nbformat 4.5): what is Python becomes code, all else text."""
    cells = []
    for i, part in enumerate(re.split(r"```python\n(.*?)```\n", page, flags=re.DOTALL)):
        kind = "code" if i % 2 else "markdown"
        own = {"execution_count": None, "outputs": []} if i % 2 else {}
        cells.append({"cell_type": kind, "id": f"cell-{i}", "metadata": {}, "source": part.strip("\n"), **own})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": {"kernelspec": kernel}, "cells": cells}


def example_page(path: Path) -> str:
    """An example: its docstring, then its code."""
    text = path.read_text()
    told = ast.get_docstring(ast.parse(text)) or ""
    title, _, more = told.partition("\n")
    code = text.split('"""', 2)[2].strip()
    run = f"`python examples/{path.name}` runs it."
    return f"# {title.rstrip('.')}\n\n{more.strip()}\n\n{run}\n\n```python\n{code}\n```\n"


def verb_page(verb: str) -> str:
    """A verb: its docstring, two examples, its flags, and the solvers' settings folded."""
    function = app[verb].default_command
    show_internals(function)
    flags = list(flags_of(verb))
    parts = [f"# mien {verb}", PIPELINE[verb], described(inspect.getdoc(function) or "")]
    parts.append("```\n" + "\n".join(f"{command:<60}# {what}" for command, what in EXAMPLES[verb]) + "\n```")
    shown = [flag for flag in flags if not flag.internal]
    parts.append(table(shown))
    inside = [flag for flag in flags if flag.internal]
    if inside:
        indented = "\n".join(f"    {line}" for line in table(inside).splitlines())
        parts.append(f'??? note "Settings of the solvers"\n\n{indented}')
    return "\n\n".join(parts) + "\n"


@dataclass(frozen=True)
class Flag:
    """A row of a verb's page."""

    names: str
    told: str
    default: str
    internal: bool


def flags_of(verb: str) -> Iterator[Flag]:
    """All that a verb takes."""
    for argument in app[verb].assemble_argument_collection(parse_docstring=True):
        field = argument.field_info
        default = "" if field.default in (field.empty, None) else str(field.default)
        told = (argument.parameter.help or "").replace("|", "\\|").replace("\n", " ")
        positional = field.kind is not field.KEYWORD_ONLY
        names = f"`{field.name.upper()}`" if positional else ", ".join(f"`{name}`" for name in argument.names)
        yield Flag(names, told, default, is_internal(field.name))


def table(flags: list[Flag]) -> str:
    """Flags as Markdown."""
    rows = [f"| {flag.names} | {flag.told} | {flag.default} |" for flag in flags]
    return "\n".join(["| flag | what | default |", "|---|---|---|", *rows])


if __name__ == "__main__":
    pages = gather(Path(sys.argv[1]))
    print(f"{len(pages)} pages")
