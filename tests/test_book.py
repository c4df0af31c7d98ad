"""The book: a page a verb and an example, no link to nowhere, every page in its contents."""

import json
import re

import pytest

from mien.cli.main import PIPELINE
from test_house import ROOT, tool


@pytest.fixture(scope="module")
def book(tmp_path_factory):
    folder = tmp_path_factory.mktemp("book") / "pages"
    tool("book").gather(folder)
    return folder


def test_a_page_a_verb_and_an_example(book):
    for verb in PIPELINE:
        page = (book / "verbs" / f"{verb}.md").read_text()
        assert page.count(f"mien {verb}") >= 3
    solve = (book / "verbs" / "solve.md").read_text()
    assert "Settings of the solvers" in solve
    assert "| `TAKE` | The marker take. |" in solve
    for path in (ROOT / "examples").glob("*.py"):
        assert "```python" in (book / "examples" / f"{path.stem}.md").read_text()


def test_links_lead_somewhere(book):
    for page in book.rglob("*.md"):
        for link in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text()):
            if "://" not in link:
                assert (page.parent / link).exists(), f"{page.relative_to(book)}: {link}"


def test_the_contents_name_every_page(book):
    named = set(re.findall(r": ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.M))
    assert named == {str(page.relative_to(book)) for page in book.rglob("*.md")}


SHORT = "__import__('dataclasses').replace(staged.markers, positions=staged.markers.positions[:16])"
"""Half a second of the tutorial's take: the rest costs seconds and runs the same lines."""


def test_the_researchers_notebook_runs_from_top_to_bottom(book):
    told = json.loads((book / "tutorials" / "researcher.ipynb").read_text())
    code = [cell["source"] for cell in told["cells"] if cell["cell_type"] == "code"]
    assert len(code) == (book / "tutorials" / "researcher.md").read_text().count("```python")
    names: dict = {}
    for source in code:
        exec(source.replace("take = staged.markers  ", f"take = {SHORT}  "), names)
    assert names["take"].positions.shape == names["filled"].shape == (16, 60, 3)
