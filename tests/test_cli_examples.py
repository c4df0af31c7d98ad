"""Examples use verbs and flags that exist."""

import re

import pytest

from mien.cli.examples import EXAMPLES
from mien.cli.main import PIPELINE, app


@pytest.mark.parametrize("verb", list(PIPELINE))
def test_flags_exist(verb):
    names = {"--json"}
    page = app[verb]
    pages = [page, *(page[name] for name in page if not name.startswith("-"))]
    for each in pages:
        names |= {name for argument in each.assemble_argument_collection() for name in argument.names}
    for command, _ in EXAMPLES[verb]:
        assert set(re.findall(r"(?<= )--?[a-z][a-z-]*", command)) <= names, command
