"""Long work reports where it is to any object with `update`; by default to nobody."""

from typing import Protocol, runtime_checkable


@runtime_checkable
class Progress(Protocol):
    """Whoever wants to know how far long work has come."""

    def update(self, stage: str, done: int, total: int) -> None:
        """`done` of `total` steps of `stage` are behind us."""
        ...


class Silent:
    """Progress that nobody watches."""

    def update(self, stage: str, done: int, total: int) -> None:
        """Say nothing."""


SILENT = Silent()


def unheard(_: str) -> None:
    """What is told to nobody: stands in for a `tell`."""
