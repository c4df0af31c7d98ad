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
    bad = LeftOut("smile", "no surface")
    with pytest.raises(BadInput, match=r"^1 scan of .* it takes 2; left out: smile: no surface$"):
        enough(1, 2, (bad,))
    with pytest.raises(BadInput, match=r"^0 scans of .* it takes 2(; left out: smile: no surface){3}; and 2 more$"):
        enough(0, 2, (bad,) * 5)
