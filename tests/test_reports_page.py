"""Pages that hold everything and ask for nothing."""

import re
from html.parser import HTMLParser

import numpy as np

from mien.pictures import (
    line_chart,
)
from mien.reports.page import Report
from page_parts import flat


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


def test_pages_within_and_folded_parts():
    report = Report("a").verdict("Good: & fast").page("<p id='x'>moves</p>", "the face")
    report.folded("figures", Report("").table([("a", 1)]))
    text = report.html()
    assert 'srcdoc="&lt;p id=&#x27;x&#x27;&gt;moves' in text
    assert '<p class="verdict">Good: &amp; fast</p>' in text
    assert text.index("<details><summary>figures") < text.index("<table>") < text.index("</details>")
    assert text.count("<h1>") == 1
