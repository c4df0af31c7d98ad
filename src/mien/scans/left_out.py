"""One bad scan does not stop the others: what was left out, and why."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from ..errors import BadInput
from ..one_line import count

T = TypeVar("T")

NAMED = 3
"""Scans that are named, with the reason, in one line."""


@dataclass(frozen=True)
class LeftOut:
    """A scan that the rig is made without."""

    name: str
    why: str

    def __str__(self) -> str:
        return f"left out: {self.name}: {self.why}"


def kept(found: Sequence[T | LeftOut], strict: bool = False) -> tuple[list[T], tuple[LeftOut, ...]]:
    """What is there, and what is left out.

    Raises:
        BadInput: something is left out, and `strict` forbids it.
    """
    out = tuple(one for one in found if isinstance(one, LeftOut))
    if out and strict:
        raise BadInput("; ".join(f"{one.name}: {one.why}" for one in out))
    return [one for one in found if not isinstance(one, LeftOut)], out


def enough(found: int, least: int, out: Sequence[LeftOut]) -> None:
    """Refuse to go on with too few scans.

    Raises:
        BadInput: fewer than `least`; the message says what was left out, the first of it by name.
    """
    if found < least:
        why = "".join(f"; {one}" for one in out[:NAMED])
        more = f"; and {len(out) - NAMED} more" if len(out) > NAMED else ""
        used = count(found, "scans")
        raise BadInput(f"{used} of selected frames can be used, and it takes {least}{why}{more}")
