"""One bad scan does not stop the others: what was left out, and why."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from ..errors import BadInput

T = TypeVar("T")


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


def enough(count: int, least: int, out: Sequence[LeftOut]) -> None:
    """Refuse to go on with too few scans.

    Raises:
        BadInput: fewer than `least`; the message says what was left out.
    """
    if count < least:
        why = "".join(f"; {one}" for one in out)
        raise BadInput(f"{count} scan(s) of selected frames can be used; {least} are needed{why}")
