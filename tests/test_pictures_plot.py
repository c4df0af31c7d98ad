"""Charts."""

import re
from xml.etree import ElementTree

import numpy as np

from mien.pictures import (
    bar_chart,
    box_chart,
    line_chart,
)


def shapes_of(svg: str, tag: str) -> list[ElementTree.Element]:
    return list(ElementTree.fromstring(svg).iter(tag))


def test_line_chart_draws_what_it_is_given():
    x = np.arange(50.0)
    gap = np.where((x > 20) & (x < 30), np.nan, np.sin(x / 5))
    svg = line_chart({"a & b": (x, gap), "<c>": (x, x / 50)}, "time, s", "mm", spans=[(5.0, 9.0, "smile")])
    curves = [path for path in shapes_of(svg, "path") if path.find("title") is not None]
    assert [curve.find("title").text for curve in curves] == ["a & b", "<c>"]
    assert curves[0].get("d").count("M") == 2  # broken by the gap
    assert curves[1].get("d").count("M") == 1
    points = np.array(re.findall(r"[ML]([\d.]+) ([\d.]+)", curves[1].get("d")), dtype=float)
    assert len(points) == 50
    assert (np.diff(points[:, 0]) > 0).all()
    assert (np.diff(points[:, 1]) < 0).all()  # up the page
    np.testing.assert_allclose(np.diff(points, axis=0), np.tile(points[1] - points[0], (49, 1)), atol=0.11)
    words = [word.text for word in shapes_of(svg, "text")]
    assert {"time, s", "mm", "smile", "a & b", "<c>", "0"} <= set(words)
    assert len(shapes_of(svg, "rect")) == 3  # the span and two keys


def test_log_axis_by_hand():
    svg = line_chart({"e": ([1, 2, 3, 4], [10.0, 1.0, 0.1, -1.0])}, log=True, dots=True)
    dots = [float(dot.get("cy")) for dot in shapes_of(svg, "circle")]
    assert len(dots) == 3  # what is not positive is left out
    np.testing.assert_allclose(dots[1] - dots[0], dots[2] - dots[1], atol=0.11)


def test_long_curves_are_thinned_but_keep_their_peaks():
    y = np.zeros(100_000)
    y[54_321] = 7.0
    svg = line_chart({"y": (np.arange(100_000), y)})
    assert len(svg) < 60_000
    heights = [float(v) for v in re.findall(r"[ML][\d.]+ ([\d.]+)", shapes_of(svg, "path")[-1].get("d"))]
    assert min(heights) < max(heights) - 100


def test_bars_by_hand():
    svg = bar_chart({"jawOpen": [1.0, 0.5], "browDown": [-0.5, 0.0]}, ["solved", "truth"], "weight", mark=0.8)
    bars = [r for r in shapes_of(svg, "rect") if r.find("title") is not None]
    widths = [float(bar.get("width")) for bar in bars]
    np.testing.assert_allclose(widths[1], widths[0] / 2, atol=0.1)
    np.testing.assert_allclose(widths[2], widths[0] / 2, atol=0.1)
    zero = float(bars[0].get("x"))
    np.testing.assert_allclose(float(bars[2].get("x")) + widths[2], zero, atol=0.11)  # to the left of zero
    assert {"jawOpen", "browDown", "solved", "truth", "weight"} <= {word.text for word in shapes_of(svg, "text")}


def test_boxes_by_hand():
    svg = box_chart({"a": np.linspace(0, 100, 101), "gone": [np.nan]}, "mm")
    groups = shapes_of(svg, "g")
    assert len(groups) == 1
    assert groups[0].find("title").text == "median 50"
    whiskers, box, median = list(groups[0])[1:]
    start, width = float(box.get("x")), float(box.get("width"))
    middle = float(re.match(r"M([\d.]+)", median.get("d")).group(1))
    np.testing.assert_allclose(middle, start + width / 2, atol=0.1)  # 25, 50, 75
    p5, p95 = re.match(r"M([\d.]+) [\d.]+H([\d.]+)", whiskers.get("d")).groups()
    np.testing.assert_allclose(float(p95) - float(p5), 1.8 * width, atol=0.3)
