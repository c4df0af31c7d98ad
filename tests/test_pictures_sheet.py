"""Contact sheets, labels and scales beside pictures."""

import numpy as np
import pytest
from PIL import Image

from mien.errors import BadInput
from mien.pictures import (
    bar_chart,
    box_chart,
    contact_sheet,
    hstack,
    label,
    line_chart,
    with_scale,
    write_png,
)
from mien.pictures.scale import PAPER
from mien.reports.page import Report
from page_parts import flat


def test_contact_sheet_by_hand():
    sheet = contact_sheet([flat(10), flat(20), flat(30)], columns=2, gap=2)
    assert sheet.shape == (42, 62, 3)
    assert (sheet[:20, :30] == 10).all()
    assert (sheet[:20, 32:] == 20).all()
    assert (sheet[22:, :30] == 30).all()
    assert (sheet[22:, 32:] == PAPER).all()
    assert (sheet[20:22] == PAPER).all()
    assert contact_sheet([flat(0)] * 5).shape == (44, 98, 3)  # three columns, two rows, gaps of 4
    assert contact_sheet([flat(0)], columns=4).shape == (20, 30, 3)


def test_labels_are_drawn_in_the_lower_left_of_a_copy():
    image = flat(120, 200, 300)
    drawn = label(image, "jawOpen")
    changed = np.argwhere((drawn != 120).any(2))
    assert (image == 120).all()
    assert changed[:, 0].min() > 150
    assert changed[:, 1].max() < 100
    assert drawn.max() > 220
    captioned = contact_sheet([image, image], ["a", "b"], columns=2, gap=0)
    assert (captioned[:, :300] != captioned[:, 300:]).any()


def test_hstack_by_hand():
    row = hstack([flat(1, width=5), flat(2, width=7)], gap=3)
    assert row.shape == (20, 15, 3)
    assert (row[:, :5] == 1).all()
    assert (row[:, 5:8] == PAPER).all()
    assert (row[:, 8:] == 2).all()


def test_a_heat_map_has_its_scale_on_the_right():
    both = with_scale(flat(77, 160, 100), (0.0, 1.0))
    assert both.shape[0] == 160
    assert both.shape[1] > 100
    assert (both[:, :100] == 77).all()


def test_png_keeps_every_pixel(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (9, 7, 4), dtype=np.uint8)
    write_png(tmp_path / "a.png", image)
    with Image.open(tmp_path / "a.png") as back:
        np.testing.assert_array_equal(np.asarray(back), image)
    with pytest.raises(BadInput, match="does not exist"):
        write_png(tmp_path / "no" / "a.png", image)


def test_bad_input_is_told():
    with pytest.raises(BadInput, match="one size"):
        contact_sheet([flat(0), flat(0, 21)])
    with pytest.raises(BadInput, match="none"):
        contact_sheet([])
    with pytest.raises(BadInput, match="expected 2 captions"):
        contact_sheet([flat(0), flat(0)], ["one"])
    with pytest.raises(BadInput, match="one height"):
        hstack([flat(0), flat(0, 21)])
    with pytest.raises(BadInput, match="'a' needs x and y of one length"):
        line_chart({"a": ([1, 2], [1])})
    with pytest.raises(BadInput, match="no finite value"):
        line_chart({"a": ([1, 2], [np.nan, np.nan])})
    with pytest.raises(BadInput, match="no finite value"):
        line_chart({})
    with pytest.raises(BadInput, match="rows of one length"):
        bar_chart({"a": [1.0, 2.0], "b": [1.0]})
    with pytest.raises(BadInput, match="no finite value"):
        box_chart({"a": [np.nan]})
    with pytest.raises(BadInput, match="does not exist"):
        Report("x").write("/no/such/folder/report.html")
