"""Rows of a recording to evenly spaced frames, by their time codes or seconds."""

import re
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

_CODE = re.compile(r"\s*(\d+):(\d+):(\d+)([:;.,])(\d+(?:[.,]\d+)?)\s*")
_DATE, _ZONE = r"(?:\d{4}-\d\d-\d\d[T ](?=\d+:))?", r"(?:Z|[+-]\d\d:?\d\d)?"
_SECONDS = re.compile(rf"\s*{_DATE}(?:(?:(\d+):)?(\d+):)?(\d+(?:[.,]\d+)?)\s*{_ZONE}\s*")
_RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)
"""Frames a second that time codes count in."""
_MEASURED_RATES = (24000 / 1001, 24, 25, 30000 / 1001, 30, 48, 50, 60000 / 1001, 60, 90, 100, 120, 240)
"""Frames a second that clocks in seconds are snapped to, where they are this near: a share."""
_SNAP = 4e-4
_DAY_S = 86400.0
_FALLBACK = 60.0
"""The app's own rate, where the take is too short to tell."""


class Clock(NamedTuple):
    """Where rows belong."""

    frames: Int[np.ndarray, " rows"]
    """Frame of each row from 0; growing, but equal where a time stands twice."""
    rate: float
    """Frames a second."""
    notes: tuple[str, ...]


def read_clock(codes: list[str], rate: float | None) -> Clock:
    """Frames of rows from `HH:MM:SS:FF.fff` (FF counts frames of the second; `;` before it: drop-frame), or seconds.

    `rate` is believed instead of what the codes say. Without codes frames follow one another.
    """
    found = [_CODE.fullmatch(code) for code in codes]
    if all(match and match[4] in ":;" for match in found):
        return _from_frames([match for match in found if match], rate)
    seconds = [_seconds(code) for code in codes]
    if codes and all(value is not None for value in seconds):
        return _from_seconds(np.array(seconds, dtype=float), rate)
    note = f"the time codes cannot be read; frames follow one another at {rate or _FALLBACK:g}/s (--rate changes it)"
    return Clock(np.arange(len(codes)), rate or _FALLBACK, (note,))


def _from_frames(found: list[re.Match], rate: float | None) -> Clock:
    h, m, s = np.array([[float(match[i]) for i in (1, 2, 3)] for match in found]).T
    frame = np.array([float(match[5].replace(",", ".")) for match in found])
    second = h * 3600 + m * 60 + s
    counted = int(frame.max()) + 1
    near = [r for r in _RATES if counted <= r <= counted + 2]
    short = bool(second[0] == second[-1]) and counted <= _FALLBACK
    base = _FALLBACK if short else float(near[0] if near else counted)
    notes = [f"the take is too short to tell its rate; read at {base:g}/s"] if short and rate is None else []
    drops, dropped = _drop_frames(h, m, base) if any(match[4] == ";" for match in found) else (0.0, False)
    if any(match[4] == ";" for match in found):
        notes.append(f"time codes with ; are drop-frame, counted at {base:g} frames a second")
    count = _across_midnight(second * base + frame - drops, base)
    steps = np.diff(count)
    usual = steps[steps > 0]
    step = float(np.median(usual)) if len(usual) else 1.0
    each = next((k for k in (0.25, 0.5, 1.0, 2.0, 3.0, 4.0) if abs(step - k) < 0.2 * k), 1.0)
    true = base * 1000 / 1001 if dropped else base
    return _placed((count - count.min()) / each, rate or true / each, notes)


def _drop_frames(h: np.ndarray, m: np.ndarray, base: float) -> tuple[np.ndarray, bool]:
    """Frame numbers that drop-frame codes have skipped so far (two a minute at 30, but not in every tenth), and whether
    the take has seen any go."""
    minutes = h * 60 + m
    skipped = round(base / 15) * (minutes - minutes // 10)
    return skipped, bool(skipped.max() > skipped.min())


def _seconds(code: str) -> float | None:
    match = _SECONDS.fullmatch(code)
    if not match:
        return None
    h, m, s = (float((part or "0").replace(",", ".")) for part in match.groups())
    return h * 3600 + m * 60 + s


def _from_seconds(times: np.ndarray, rate: float | None) -> Clock:
    gaps = np.diff(times)
    gaps = gaps[gaps > 0]
    usual = float(np.median(gaps)) if len(gaps) else 1 / _FALLBACK
    if usual == 1.0 and (times % 1 == 0).all():
        told = rate or _FALLBACK
        return _placed(times - times.min(), told, [f"the clock counts frames; read at {told:g}/s (--rate changes it)"])
    unit = next((u for u in (1.0, 1e-3, 1e-6) if usual * u < 0.5), 1e-9)
    one = gaps[np.abs(gaps - usual) < 0.5 * usual]
    measured = 1.0 / (unit * float(one.mean())) if len(one) else _FALLBACK
    snapped = min(_MEASURED_RATES, key=lambda r: abs(r - measured))
    found = float(snapped) if abs(snapped - measured) < _SNAP * snapped + 0.5 / max(len(times), 1) else measured
    notes = [] if rate is not None else [f"the clock counts seconds: {found:.5g} frames a second"]
    return _placed((times - times.min()) * unit * (rate or found), rate or found, notes)


def _across_midnight(count: np.ndarray, base: float) -> np.ndarray:
    steps = np.diff(count, prepend=count[:1])
    return count + _DAY_S * base * np.cumsum(steps < -0.5 * _DAY_S * base)


def _placed(place: Float[np.ndarray, " rows"], rate: float, notes: list[str]) -> Clock:
    places = np.round(place).astype(np.int64)
    if (np.diff(places) < 0).any() or places.max(initial=0) > 50 * len(places) + 1000:
        notes.append(f"the time codes jump; frames follow one another at {rate:g}/s")
        places = np.arange(len(places))
    twice = int((np.diff(places) == 0).sum())
    if twice:
        notes.append(f"{twice} rows repeat a time; the last of each is kept")
    missing = int(places[-1] + 1 - len(np.unique(places))) if len(places) else 0
    if missing:
        notes.append(f"{missing} frames have no row; they hold the last value")
    return Clock(places, float(rate), tuple(notes))
