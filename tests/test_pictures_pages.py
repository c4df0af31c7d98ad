"""Sheets, scales, films, charts and the report."""

import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import av
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
    scale_bar,
    with_scale,
    write_mp4,
    write_png,
)
from mien.pictures.colormap import table
from mien.pictures.scale import PAPER, nice_ticks, number
from mien.reports.page import Report


def flat(color, height=20, width=30):
    return np.full((height, width, 3), color, dtype=np.uint8)


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


@pytest.mark.parametrize(("low", "high", "about", "ticks"), [
    (0.0, 1.0, 5, [0, 0.2, 0.4, 0.6, 0.8, 1]),
    (-1.3, 2.2, 5, [-1, -0.5, 0, 0.5, 1, 1.5, 2]),
    (0.0, 3.2e-3, 3, [0, 1e-3, 2e-3, 3e-3]),
    (97.0, 1260.0, 4, [250, 500, 750, 1000, 1250]),
    (2.0, 2.0, 4, [2]),
])  # fmt: skip
def test_ticks_are_round(low, high, about, ticks):
    np.testing.assert_allclose(nice_ticks(low, high, about), ticks, atol=1e-12)


def test_numbers_are_short():
    assert [number(x) for x in (0.30000000000000004, -0.0, 1250.0, -2.5, 1e-7)] == ["0.3", "0", "1250", "-2.5", "1e-07"]


@pytest.mark.parametrize("shape", [(40, 300), (300, 60)])
def test_scale_bar_runs_from_end_to_end(shape):
    height, width = shape
    bar = scale_bar(width, height, (0.0, 2.0), "mm")
    assert bar.shape == (*shape, 3)
    ends = (255 * table("heat")[[0, -2]] + 0.5).astype(np.uint8)
    found = [np.argwhere((bar == color).all(2)) for color in ends]
    axis = 1 if width > height else 0
    low, high = (places[:, axis].mean() for places in found)
    assert abs(high - low) > 0.6 * max(shape)
    assert (high > low) == (axis == 1)  # upright ones have the greatest value on top
    assert (bar.max(2) > 200).sum() > 20  # there are numbers on it


def test_a_heat_map_has_its_scale_on_the_right():
    both = with_scale(flat(77, 160, 100), (0.0, 1.0))
    assert both.shape[0] == 160
    assert both.shape[1] > 100
    assert (both[:, :100] == 77).all()


def test_film_reads_back(tmp_path):
    path = tmp_path / "film.mp4"
    frames = [np.full((31, 41, 3), (20 * i, 100, 250 - 20 * i), dtype=np.uint8) for i in range(11)]
    assert write_mp4(path, iter(frames), 29.97) == 11
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        assert (stream.width, stream.height) == (40, 30)
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert stream.codec_context.name == "h264"
        np.testing.assert_allclose(float(stream.average_rate), 29.97, rtol=1e-4)
        back = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(back) == 11
    for frame, image in zip(frames, back, strict=True):
        np.testing.assert_allclose(image.mean((0, 1)), frame[0, 0], atol=6)


def test_a_film_that_fails_leaves_nothing_behind(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"the old one")
    with pytest.raises(BadInput, match="frame 1 has shape"):
        write_mp4(path, [flat(0), flat(0, 22)], 30.0)
    with pytest.raises(BadInput, match="at least one frame"):
        write_mp4(path, [], 30.0)
    with pytest.raises(BadInput, match="rate must be positive"):
        write_mp4(path, [flat(0)], 0.0)
    with pytest.raises(BadInput, match="2 x 2"):
        write_mp4(path, [flat(0, 1, 1)], 30.0)

    def stopped():
        yield flat(0)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_mp4(path, stopped(), 30.0)
    assert path.read_bytes() == b"the old one"
    assert list(tmp_path.iterdir()) == [path]


def test_png_keeps_every_pixel(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (9, 7, 4), dtype=np.uint8)
    write_png(tmp_path / "a.png", image)
    with Image.open(tmp_path / "a.png") as back:
        np.testing.assert_array_equal(np.asarray(back), image)
    with pytest.raises(BadInput, match="does not exist"):
        write_png(tmp_path / "no" / "a.png", image)


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


class Sources(HTMLParser):
    """Everything that a page would fetch, and its tags in order."""

    def __init__(self):
        super().__init__()
        self.found, self.tags, self.words = [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.found += [value for name, value in attrs if name in ("src", "href", "data", "poster", "action", "srcset")]

    def handle_data(self, data):
        self.words.append(data)


def full_report(film: bytes = b"film") -> Report:
    report = Report("Take <1> & co", "A lead.")
    report.heading("Fit").text("One.\n\nTwo <script>alert('x')</script>.")
    rows = [["brow", 0.1234, 12, "3 %"], ["chin", float("nan"), 1500, "40 %"]]
    report.table(rows, ["Marker", "mm", "Frames", "Lost"])
    report.figure(flat(200), 'A "square" of grey', kind="png").figure(flat(100))
    report.figure(np.zeros((4, 4, 4), np.uint8), "Cut out.")
    return report.chart(line_chart({"a": ([0, 1], [0, 1])}), "A chart.").video(film, "A film.")


def test_report_holds_everything_and_asks_for_nothing(tmp_path):
    full_report().write(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    seen = Sources()
    seen.feed(page)
    assert len(seen.found) == 4
    assert all(re.match(r"data:(image/(png|jpeg)|video/mp4);base64,", source) for source in seen.found)
    assert not re.search(r"https?:|//[a-z]|url\(|@import|<link|<script", page.replace("<!doctype html>", ""))
    assert {"h1", "h2", "table", "figure", "img", "svg", "video", "figcaption"} <= set(seen.tags)
    assert list(tmp_path.iterdir()) == [tmp_path / "report.html"]


def test_report_escapes_all_text():
    page = full_report().html()
    assert "<title>Take &lt;1&gt; &amp; co</title>" in page
    assert "<p>One.</p>" in page
    assert "<p>Two &lt;script&gt;" in page
    assert 'alt="A &quot;square&quot; of grey"' in page
    assert "<script" not in page


def test_report_tables_set_numbers_flush_right():
    page = full_report().html()
    body = re.search(r"<tbody>(.*?)</tbody>", page).group(1)
    first, second = re.findall(r"<tr>(.*?)</tr>", body)
    assert first == '<td>brow</td><td class="n">0.123</td><td class="n">12</td><td class="n">3 %</td>'
    assert second == '<td>chin</td><td class="n">–</td><td class="n">1,500</td><td class="n">40 %</td>'
    assert '<th>Marker</th><th class="n">mm</th>' in page


def test_report_takes_a_film_by_path(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"\x00film")
    assert "data:video/mp4;base64,AGZpbG0=" in Report("x").video(tmp_path / "a.mp4").html()


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
