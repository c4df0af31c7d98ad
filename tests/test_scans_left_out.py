"""One bad scan does not stop the others."""

import pytest

from mien.errors import BadInput
from mien.scans.left_out import LeftOut, enough, kept


def test_what_is_there_and_what_is_not():
    bad = LeftOut("smile", "no surface")
    assert kept([1, bad, 2]) == ([1, 2], (bad,))
    assert kept([1], strict=True) == ([1], ())
    with pytest.raises(BadInput, match="smile: no surface"):
        kept([1, bad], strict=True)
    assert str(bad) == "left out: smile: no surface"


def test_too_few_are_refused_with_the_reasons():
    enough(2, 2, ())
    with pytest.raises(BadInput, match=r"1 scan.s. .* 2 are needed; left out: smile: no surface"):
        enough(1, 2, (LeftOut("smile", "no surface"),))
