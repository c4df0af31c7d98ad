"""Tables of further channels: any spelling of the time, any columns; a clear line for what is none."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.gauge_file import read_gauges


def written(tmp_path, text):
    path = tmp_path / "gauges.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "time,brow,lid\n0,1,-2\n0.5,,4\n",
        "lid;Time_ms;brow\n-2;0;1,0\n4;500;NA\n",
        "seconds\tbrow\tlid\n0\t1\t-2\n\n0.5\tnan\t4\n",
        "t (s),brow,lid\n0,1,-2\n0.5,,4\n",
    ],
)
def test_time_and_channels_are_told_by_their_names(tmp_path, text):
    table = read_gauges(written(tmp_path, text)).only(("brow", "lid"))
    np.testing.assert_allclose(table.times, [0, 0.5])
    np.testing.assert_allclose(table.values, [[1, -2], [np.nan, 4]])


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "has no time column"),
        ("brow,lid\n1,2\n", "has no time column"),
        ("time\n0\n1\n", "no further column"),
        ("time,a,a\n0,1,2\n1,2,3\n", "'a' stands there twice"),
        ("time,a\n0,1\n1,much\n", "row 3: 'much' is neither a number nor NA"),
        ("time,a\n1,1\n0,2\n", "numbers that increase"),
        ("time,a\n1,1\n", "two at least"),
    ],
)
def test_what_is_no_such_table_is_said(tmp_path, text, line):
    with pytest.raises(BadInput, match=line):
        read_gauges(written(tmp_path, text))
