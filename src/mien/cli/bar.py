"""The progress bar that every verb shows."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars


class Bar:
    """`mien.progress.Progress` drawn by rich, one line a stage, on stderr."""

    def __init__(self, bars: Bars):
        self._bars = bars
        self._tasks = {}

    def update(self, stage: str, done: int, total: int) -> None:
        """Move the stage's bar; the first call makes it."""
        task = self._tasks.get(stage)
        if task is None:
            self._bars.start()
            task = self._bars.add_task(stage, total=total)
            self._tasks[stage] = task
        self._bars.update(task, completed=done, total=total)

    def stop(self) -> None:
        """Leave the bars as they are, if there are any."""
        if self._tasks:
            self._bars.stop()


@contextmanager
def bar() -> Iterator[Bar]:
    """A progress bar from the block's first stage until its end; a block without one leaves stderr as it was."""
    columns = [
        SpinnerColumn(),
        TextColumn("{task.description:<34}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    ]
    stderr = Console(stderr=True)
    shown = Bar(Bars(*columns, console=stderr))
    try:
        yield shown
    finally:
        shown.stop()
