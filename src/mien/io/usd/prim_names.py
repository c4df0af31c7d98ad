"""Names that USD takes for prims."""

import re
from collections.abc import Sequence


def prim_names(names: Sequence[str]) -> list[str]:
    """An identifier for each name (letters, digits, underscores; no digit first), all different, alike where it may be.

    Only ASCII: not every program reads more. Names that differ by case alone are told apart too, since some file
    systems and programs do not tell them.
    """
    taken: set[str] = set()
    out = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name) or "_"
        plain = f"_{plain}" if plain[0].isdigit() else plain
        number, unique = 1, plain
        while unique.lower() in taken:
            number += 1
            unique = f"{plain}_{number}"
        taken.add(unique.lower())
        out.append(unique)
    return out
