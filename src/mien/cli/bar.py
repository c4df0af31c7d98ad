"""The progress bar that every verb shows."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars


class Bar:
    """`mien.progress.Progress` drawn by rich, one line a stage, on stderr."""

    def __init__(self, bars: Bars):
        self._bars = bars
        self._tasks = {}

    def update(self, stage: str, done: int, total: int) -> None:
        """Move the stage's bar; the first call makes it."""
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=total)
        self._bars.update(self._tasks[stage], completed=done, total=total)


@contextmanager
def bar() -> Iterator[Bar]:
    """A progress bar while the block runs."""
    columns = (TextColumn("{task.description:<34}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Bars(*columns, console=Console(stderr=True)) as bars:
        yield Bar(bars)
