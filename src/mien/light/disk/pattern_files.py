"""Patterns as pictures for a projector, beside the list that names them."""

from pathlib import Path

import numpy as np

from ...errors import BadInput
from ...pictures.color import to_bytes, to_srgb
from ...pictures.video import write_png
from ..patterns import PROJECTED, PatternSet, gray_set, moving_phase_set, paper_set, phase_set, ramp_set, write_patterns

SETS = {"paper": paper_set, "phase": phase_set, "moving-phase": moving_phase_set, "gray": gray_set, "ramp": ramp_set}
"""By name, what can be shown."""


def pattern_set(name: str, size: str) -> PatternSet:
    """A set by its name for a projector of `1024x768`.

    Raises:
        BadInput: no such set, or no such size.
    """
    if name not in SETS:
        raise BadInput(f"patterns {name!r}: expected one of {', '.join(SETS)}")
    numbers = size.lower().split("x")
    if len(numbers) != 2 or not all(word.isdecimal() and 16 <= int(word) <= 16384 for word in numbers):
        raise BadInput(f"size {size!r}: expected width x height in pixels, such as 1024x768")
    width, height = (int(word) for word in numbers)
    return SETS[name](width, height)


def write_pattern_pictures(folder: Path, patterns: PatternSet, linear: bool = False) -> int:
    """`pattern_00.png` and so on, and `patterns.json`; slots of lamps have no picture. How many pictures there are.

    Pictures are sRGB-coded, as a projector expects them that undoes it; `linear` writes the values themselves.
    """
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for slot, pattern in enumerate(patterns.patterns):
        if pattern.kind not in PROJECTED:
            continue
        image = patterns.image(slot)
        coded = image if linear else to_srgb(image)
        write_png(folder / f"pattern_{slot:02d}.png", np.repeat(to_bytes(coded)[..., None], 3, axis=2))
        count += 1
    write_patterns(folder / "patterns.json", patterns)
    return count
