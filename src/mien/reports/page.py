"""`report.html`: one file that holds everything that it shows and asks nothing of the network."""

import base64
import io
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from ..files import whole

STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1d1f22; --soft: #63676d; --line: #e2e3e6; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #17181a; --ink: #e6e7e9; --soft: #9b9fa6; --line: #303236; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); line-height: 1.55;
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 860px; margin: 0 auto; padding: 56px 24px 96px; }
h1 { font-size: 1.9rem; font-weight: 650; letter-spacing: -0.015em; line-height: 1.2; margin: 0 0 0.4em; }
h2 { font-size: 1.2rem; font-weight: 620; margin: 2.6em 0 0.5em; padding-top: 1em; border-top: 1px solid var(--line); }
p { margin: 0.7em 0; max-width: 68ch; }
p.lead { color: var(--soft); font-size: 1.05rem; }
figure { margin: 1.6em 0; }
figure img, figure video { display: block; max-width: 100%; height: auto; border-radius: 6px; }
figcaption { color: var(--soft); font-size: 0.88rem; margin-top: 0.55em; max-width: 72ch; }
figure iframe { display: block; width: 100%; border: 0; border-radius: 6px; }
details { margin: 2em 0 0; padding-top: 1em; border-top: 1px solid var(--line); }
summary { cursor: pointer; font-weight: 600; }
p.verdict { font-size: 1.15rem; font-weight: 550; }
.scroll { overflow-x: auto; margin: 1.2em 0; }
table { border-collapse: collapse; font-size: 0.92rem; font-variant-numeric: tabular-nums; min-width: 50%; }
th { text-align: left; font-weight: 600; color: var(--soft); border-bottom: 1px solid var(--ink); }
th, td { padding: 0.38em 1.4em 0.38em 0; vertical-align: baseline; }
td { border-bottom: 1px solid var(--line); }
th.n, td.n { text-align: right; }
th:last-child, td:last-child { padding-right: 0; }
code { font: 0.92em ui-monospace, SFMono-Regular, Menlo, Consolas, monospace; }
@media print { main { max-width: none; padding: 0; } figure, tr { break-inside: avoid; } }
"""

PAGE_HEIGHT = 640
"""Pixels of a page within a report: it fits a laptop's screen."""


class Report:
    """A report under way: add parts in reading order, then `write`. All text is escaped."""

    def __init__(self, title: str, lead: str = ""):
        self.title = title
        self._parts = [f"<h1>{escape(title)}</h1>"]
        if lead:
            self._parts.append(f'<p class="lead">{escape(lead)}</p>')

    def heading(self, text: str) -> "Report":
        """Begin a section."""
        self._parts.append(f"<h2>{escape(text)}</h2>")
        return self

    def verdict(self, text: str) -> "Report":
        """Add the sentence that a reader looks for first."""
        self._parts.append(f'<p class="verdict">{escape(text)}</p>')
        return self

    def text(self, text: str) -> "Report":
        """Add paragraphs; an empty line ends one."""
        self._parts += [f"<p>{escape(part.strip())}</p>" for part in text.split("\n\n") if part.strip()]
        return self

    def table(self, rows: Sequence[Sequence[object]], header: Sequence[str] = (), caption: str = "") -> "Report":
        """Add a table. A column of numbers is set flush right; floats show three significant digits at least."""
        columns = max((len(row) for row in [*rows, header]), default=0)
        right = [_is_numeric([row[c] for row in rows if c < len(row)]) for c in range(columns)]
        parts = ["<table>"]
        if header:
            parts.append(f"<thead><tr>{_cells('th', header, right)}</tr></thead>")
        parts.append("<tbody>" + "".join(f"<tr>{_cells('td', row, right)}</tr>" for row in rows) + "</tbody></table>")
        self._figure(f'<div class="scroll">{"".join(parts)}</div>', caption)
        return self

    def figure(
        self, image: UInt8[np.ndarray, "h w c"], caption: str = "", kind: Literal["png", "jpeg"] = "jpeg"
    ) -> "Report":
        """Add a picture, RGB or (as PNG) RGBA. JPEG is a tenth of the size; PNG keeps every pixel."""
        kind = "png" if image.shape[2] == 4 else kind
        buffer = io.BytesIO()
        Image.fromarray(image).save(buffer, format=kind, **({"quality": 90} if kind == "jpeg" else {}))
        shape = f'width="{image.shape[1]}" height="{image.shape[0]}"'
        source = _inline(f"image/{kind}", buffer.getvalue())
        self._figure(f'<img {shape} alt="{escape(caption, quote=True)}" src="{source}">', caption)
        return self

    def chart(self, svg: str, caption: str = "") -> "Report":
        """Add a chart of `mien.pictures.plot` (SVG is taken as it is: give none that you did not make)."""
        self._figure(svg, caption)
        return self

    def video(self, film: bytes | str | Path, caption: str = "") -> "Report":
        """Add an MP4, given as its bytes or its path."""
        data = film if isinstance(film, bytes) else Path(film).read_bytes()
        self._figure(f'<video controls loop muted playsinline src="{_inline("video/mp4", data)}"></video>', caption)
        return self

    def page(self, html: str, caption: str = "", height: int = PAGE_HEIGHT) -> "Report":
        """Add a whole page that runs within this one; `height` in pixels."""
        inside = f'<iframe height="{height}" title="{escape(caption, quote=True)}" srcdoc="{escape(html, quote=True)}">'
        self._figure(f"{inside}</iframe>", caption)
        return self

    def folded(self, title: str, part: "Report") -> "Report":
        """Add the parts of another report, but for its title, behind a line that opens them."""
        inside = "\n".join(part._parts[1:])
        self._parts.append(f"<details><summary>{escape(title)}</summary>\n{inside}\n</details>")
        return self

    def html(self) -> str:
        """The whole page."""
        return (
            '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{escape(self.title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
            + "\n".join(self._parts)
            + "\n</main>\n</body>\n</html>\n"
        )

    def write(self, path: str | Path) -> None:
        """Write the page; whole or not at all.

        Raises:
            BadInput: the folder does not exist.
        """
        with whole(path) as temporary:
            temporary.write_text(self.html(), encoding="utf-8")

    def _figure(self, inside: str, caption: str) -> None:
        below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
        self._parts.append(f"<figure>{inside}{below}</figure>")


def _inline(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _cells(tag: str, row: Sequence[object], right: Sequence[bool]) -> str:
    flags = (' class="n"' if number else "" for number in right)
    return "".join(f"<{tag}{flag}>{escape(_shown(cell))}</{tag}>" for cell, flag in zip(row, flags, strict=False))


def _shown(cell: object) -> str:
    if isinstance(cell, (float, np.floating)):
        if not np.isfinite(cell):
            return "–"
        digits = 3 if cell == 0 else max(0, min(2 - int(np.floor(np.log10(abs(cell)))), 6))
        return f"{cell:.{digits}f}" if abs(cell) < 1e7 else f"{cell:.3g}"
    return f"{cell:,}" if isinstance(cell, (int, np.integer)) and not isinstance(cell, bool) else str(cell)


def _is_numeric(column: Sequence[object]) -> bool:
    """Whether a column is numbers, or text that begins like one ("0.42 mm", "37 %")."""
    def numeric(cell: object) -> bool:
        return isinstance(cell, (int, float, np.number)) or (isinstance(cell, str) and cell[:1] in "0123456789-−–+.")

    return bool(column) and all(numeric(cell) for cell in column if cell != "")
