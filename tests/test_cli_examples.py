"""Examples are command lines that the verbs take."""

import shlex

import pytest

from mien.cli.examples import EXAMPLES
from mien.cli.main import PIPELINE, app


@pytest.mark.parametrize("verb", list(PIPELINE))
def test_verbs_take_them(verb):
    for command, what in EXAMPLES[verb]:
        assert what
        program, *words = shlex.split(command)
        assert (program, words[0]) == ("mien", verb)
        words = [word for word in words if word != "--json"]
        app.parse_args(words, exit_on_error=False, print_error=False)
