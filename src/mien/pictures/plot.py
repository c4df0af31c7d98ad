"""Small charts as inline SVG: no plotting library, text stays text, axes follow the page's ink (light or dark)."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ..errors import BadInput
from .scale import nice_ticks, number

PALETTE = ("#3b82c4", "#e07b39", "#3f9c6b", "#b8559a", "#8a76d6", "#c2a02e", "#d2504f", "#4fa3ad")
"""Series colours in order: of middle lightness, so that they read on white and on black."""

WIDTH = 760
"""Pixels; the picture scales with the page."""

TEXT = 12
"""Size of words, pixels."""


def line_chart(
    series: Mapping[str, tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray]],
    x_label: str = "",
    y_label: str = "",
    *,
    log: bool = False,
    spans: Sequence[tuple[float, float, str]] = (),
    dots: bool = False,
    height: int = 280,
) -> str:
    """Named curves over one pair of axes.

    Args:
        series: name -> (x, y). NaN breaks a line. Thousands of points are thinned to what the picture can show, without
            losing a peak.
        log: logarithmic y axis; values that are not positive are left out.
        spans: stretches of x to shade: (from, to, label).
        dots: mark every point.

    Raises:
        BadInput: x and y of different lengths, or nothing finite to draw.
    """
    curves = {name: _curve(name, x, y, log) for name, (x, y) in series.items()}
    pooled = [np.concatenate(part) for part in zip(*curves.values(), strict=True)] if curves else [np.empty(0)] * 2
    finite = np.isfinite(pooled[0]) & np.isfinite(pooled[1])
    if not finite.any():
        raise BadInput("line chart: there is no finite value to draw")
    low, high = _padded(*_range(pooled[1][finite]), from_zero=not log)
    axes = _Axes(_range(pooled[0][finite]), (low, high), height, log, legend=len(curves) > 1, x_label=x_label)
    parts = [axes.spans(spans), axes.grid(x_label, y_label)]
    for index, (name, (x, y)) in enumerate(curves.items()):
        color = PALETTE[index % len(PALETTE)]
        parts.append(_polyline(axes.x(x), axes.y(y), color, name))
        if dots:
            good = np.isfinite(x) & np.isfinite(y)
            spots = zip(axes.x(x[good]), axes.y(y[good]), strict=True)
            parts += [f'<circle cx="{u:.1f}" cy="{v:.1f}" r="3" fill="{color}"/>' for u, v in spots]
    if len(curves) > 1:
        parts.append(_legend(list(curves), axes.left))
    return _svg(parts, height)


def bar_chart(
    rows: Mapping[str, float | Sequence[float]],
    series: Sequence[str] = (),
    x_label: str = "",
    *,
    mark: float | None = None,
) -> str:
    """Lying bars, one row a name; several bars a row where a row has several values.

    Args:
        rows: name -> value, or one value a series.
        series: names of the values in a row, for the legend.
        mark: a value to draw a line at (a target, a baseline).

    Raises:
        BadInput: no row, or rows with different numbers of values.
    """
    table = np.array(_equal_rows(rows), dtype=float)
    axes = _Rows(list(rows), _range(np.append(table[np.isfinite(table)], [0.0] if mark is None else [0.0, mark])),
                 legend=bool(series), each=max(18, 8 * table.shape[1] + 6))
    parts = [axes.grid(x_label)]
    thick = (axes.each - 6) / table.shape[1]
    for row, values in enumerate(table):
        for index, value in enumerate(np.nan_to_num(values)):
            start, end = sorted((axes.x(0.0), axes.x(value)))
            top = axes.row(row) - axes.each / 2 + 3 + index * thick
            parts.append(
                f'<rect x="{start:.1f}" y="{top:.1f}" width="{max(end - start, 0.5):.1f}" height="{thick - 1:.1f}"'
                f' rx="1.5" fill="{PALETTE[index % len(PALETTE)]}"><title>{number(values[index])}</title></rect>'
            )
    return axes.finish(parts, series, mark)


def box_chart(rows: Mapping[str, Sequence[float] | np.ndarray], x_label: str = "", *, mark: float | None = None) -> str:
    """Spread of many values a row (residuals of each marker): box = quartiles, line = median, whiskers = 5 and 95 %.

    Raises:
        BadInput: no row has a finite value.
    """
    spread = {}
    for name, values in rows.items():
        finite = np.asarray(values, dtype=float)
        finite = finite[np.isfinite(finite)]
        spread[name] = np.percentile(finite, [5, 25, 50, 75, 95]) if len(finite) else np.full(5, np.nan)
    table = np.array(list(spread.values())).reshape(-1, 5)
    if not np.isfinite(table).any():
        raise BadInput("box chart: there is no finite value to draw")
    ends = np.append(table[np.isfinite(table)], [0.0] if mark is None else [0.0, mark])
    axes = _Rows(list(spread), _range(ends), legend=False, each=18)
    parts = [axes.grid(x_label)]
    for row, quantiles in enumerate(table):
        if np.isfinite(quantiles).all():
            parts.append(_box([axes.x(q) for q in quantiles], axes.row(row), quantiles[2]))
    return axes.finish(parts, (), mark)


def _box(ends: Sequence[float], y: float, median: float) -> str:
    p5, p25, p50, p75, p95 = ends
    whiskers = f"M{p5:.1f} {y:.1f}H{p95:.1f}M{p5:.1f} {y - 3:.1f}v6M{p95:.1f} {y - 3:.1f}v6"
    return (
        f'<g><title>median {number(median)}</title><path d="{whiskers}" stroke="{PALETTE[0]}" fill="none"/>'
        f'<rect x="{p25:.1f}" y="{y - 5:.1f}" width="{max(p75 - p25, 1):.1f}" height="10" fill="{PALETTE[0]}"/>'
        f'<path d="M{p50:.1f} {y - 6:.1f}v12" stroke="currentColor" stroke-width="2"/></g>'
    )


class _Axes:
    """Where data go on the page, and the frame round them."""

    def __init__(self, xs, ys, height: int, log: bool, legend: bool, x_label: str):
        self.xs, self.ys, self.log = xs, ys, log
        self.ticks = _log_ticks(*ys) if log else nice_ticks(*ys)
        wide = max((len(number(t)) for t in self.ticks), default=1)
        self.left, self.right = 20 + 0.62 * TEXT * wide, WIDTH - 12
        self.top, self.bottom = (30 if legend else 12), height - (42 if x_label else 26)

    def x(self, value):
        low, high = self.xs
        return self.left + (np.asarray(value) - low) / ((high - low) or 1) * (self.right - self.left)

    def y(self, value):
        low, high, value = (*self.ys, np.asarray(value))
        if self.log:
            low, high, value = np.log10(low), np.log10(high), np.log10(value)
        return self.bottom - (value - low) / ((high - low) or 1) * (self.bottom - self.top)

    def grid(self, x_label: str, y_label: str) -> str:
        parts = []
        for tick in self.ticks:
            v = float(self.y(tick))
            parts.append(_rule(self.left, v, self.right, v) + _word(self.left - 6, v + 4, number(tick), "end"))
        for tick in nice_ticks(*self.xs, about=8):
            u = float(self.x(tick))
            parts.append(_rule(u, self.bottom, u, self.bottom + 4, 0.5))
            parts.append(_word(u, self.bottom + 17, number(tick), "middle"))
        parts.append(_rule(self.left, self.bottom, self.right, self.bottom, 0.5))
        parts.append(_word((self.left + self.right) / 2, self.bottom + 35, x_label, "middle"))
        middle = (self.top + self.bottom) / 2
        parts.append(_word(11, middle, y_label, "middle", f' transform="rotate(-90 11 {middle:.1f})"'))
        return "".join(parts)

    def spans(self, spans) -> str:
        parts = []
        for start, end, text in spans:
            u, v = (float(np.clip(self.x(edge), self.left, self.right)) for edge in (start, end))
            parts.append(
                f'<rect x="{u:.1f}" y="{self.top}" width="{max(v - u, 1):.1f}" height="{self.bottom - self.top}"'
                f' fill="currentColor" fill-opacity="0.07"/>' + _word((u + v) / 2, self.top + 13, text, "middle")
            )
        return "".join(parts)


class _Rows:
    """Rows with a name each over one x axis."""

    def __init__(self, names: list[str], xs, legend: bool, each: int):
        self.names, self.xs, self.each = names, _padded(*xs, from_zero=True), each
        self.left = 14 + 0.58 * TEXT * max(len(name) for name in names)
        self.right, self.top = WIDTH - 16, 30 if legend else 8
        self.bottom = self.top + each * len(names)

    def x(self, value: float) -> float:
        low, high = self.xs
        return self.left + (value - low) / ((high - low) or 1) * (self.right - self.left)

    def row(self, index: int) -> float:
        """The middle of a row."""
        return self.top + (index + 0.5) * self.each

    def grid(self, x_label: str) -> str:
        parts = [_word(self.left - 8, self.row(i) + 4, name, "end") for i, name in enumerate(self.names)]
        for tick in nice_ticks(*self.xs, about=8):
            u = self.x(tick)
            parts.append(_rule(u, self.top, u, self.bottom, 0.5 if tick == 0 else 0.12))
            parts.append(_word(u, self.bottom + 16, number(tick), "middle"))
        parts.append(_word((self.left + self.right) / 2, self.bottom + 34, x_label, "middle"))
        return "".join(parts)

    def finish(self, parts: list[str], series: Sequence[str], mark: float | None) -> str:
        if mark is not None:
            u = self.x(mark)
            parts.append(
                f'<path d="M{u:.1f} {self.top}V{self.bottom}" stroke="{PALETTE[6]}" stroke-dasharray="4 3" fill="none">'
                f"<title>{number(mark)}</title></path>"
            )
        return _svg([*parts, _legend(series, self.left)], self.bottom + 42)


def _curve(name: str, x, y, log: bool) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if x.shape != y.shape or x.ndim != 1:
        raise BadInput(f"line chart: {name!r} needs x and y of one length, got {x.shape} and {y.shape}")
    return _thinned(x, np.where(y > 0, y, np.nan) if log else y)


def _thinned(x: np.ndarray, y: np.ndarray, columns: int = WIDTH) -> tuple[np.ndarray, np.ndarray]:
    """First, lowest, highest and last point of each of `columns` pieces: looks the same, weighs little."""
    if len(x) <= 4 * columns:
        return x, y
    keep = set()
    for piece in np.array_split(np.arange(len(x)), columns):
        values = np.nan_to_num(y[piece], nan=float(np.nanmedian(y)))
        keep |= {piece[0], piece[np.argmin(values)], piece[np.argmax(values)], piece[-1]}
    # gaps must stay gaps
    keep |= set(np.flatnonzero(np.isnan(y) & ~np.isnan(np.roll(y, 1))).tolist())
    index = np.array(sorted(keep))
    return x[index], y[index]


def _polyline(u: np.ndarray, v: np.ndarray, color: str, name: str) -> str:
    good = np.isfinite(u) & np.isfinite(v)
    path, pen = [], "M"
    for a, b, fine in zip(u, v, good, strict=True):
        if fine:
            path.append(f"{pen}{a:.1f} {b:.1f}")
        pen = "L" if fine else "M"
    return (
        f'<path d="{"".join(path)}" fill="none" stroke="{color}" stroke-width="1.6" stroke-linejoin="round"'
        f' stroke-linecap="round"><title>{escape(name)}</title></path>'
    )


def _legend(names: Sequence[str], left: float) -> str:
    parts, x = [], left
    for index, name in enumerate(names):
        parts.append(f'<rect x="{x:.1f}" y="8" width="12" height="4" rx="2" fill="{PALETTE[index % len(PALETTE)]}"/>')
        parts.append(_word(x + 17, 14, name, "start"))
        x += 34 + 0.58 * TEXT * len(name)
    return "".join(parts)


def _rule(x0: float, y0: float, x1: float, y1: float, opacity: float = 0.12) -> str:
    return f'<path d="M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}" stroke="currentColor" stroke-opacity="{opacity}"/>'


def _word(x: float, y: float, text: str, anchor: str, extra: str = "") -> str:
    if not text:
        return ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{escape(text)}</text>'


def _svg(parts: Sequence[str], height: float) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH} {height:.0f}" role="img" font-family="system-ui, sans-serif" font-size="{TEXT}"'
        f' fill="currentColor" style="width:100%;max-width:{WIDTH}px;height:auto">{"".join(parts)}</svg>'
    )


def _equal_rows(rows: Mapping[str, float | Sequence[float]]) -> list[list[float]]:
    values = [[float(v) for v in np.atleast_1d(row)] for row in rows.values()]
    if len({len(v) for v in values}) != 1:
        raise BadInput(f"bar chart: expected rows of one length, got {sorted({len(v) for v in values})}")
    return values


def _range(values: np.ndarray) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _padded(low: float, high: float, from_zero: bool) -> tuple[float, float]:
    """A little air above (and below); a linear axis of values that are all positive starts at zero."""
    air = 0.04 * (high - low)
    if not from_zero:
        return low * 0.9, high * 1.1
    return (0.0 if low >= 0 else low - air), (0.0 if high <= 0 else high + air)


def _log_ticks(low: float, high: float) -> np.ndarray:
    decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    ticks = decades if len(decades) > 4 else np.outer(decades, [1, 2, 5]).ravel()
    return ticks[(ticks >= low) & (ticks <= high)]
