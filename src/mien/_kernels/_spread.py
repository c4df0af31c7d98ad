"""Rows over threads, for kernels that let go of the interpreter's lock (`nogil=True`).

Cheaper to compile than `parallel=True`, and safe where the caller itself runs in several threads.
"""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

_here = threading.local()


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def single_threaded() -> None:
    """From now on `spread` keeps to the calling thread: for workers of a pool that already fills the cores."""
    _here.alone = True


def spread(work: Callable[[int, int], object], rows: int, threads: int = 0) -> None:
    """Call `work(first, last)` on pieces of 0..rows, side by side in `threads` threads (0 = one a core)."""
    threads = min(threads or (1 if getattr(_here, "alone", False) else cores()), rows)
    if threads <= 1:
        work(0, rows)
        return
    pieces = 2 * threads
    ends = [rows * p // pieces for p in range(pieces + 1)]
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(work, ends[:-1], ends[1:]):
            pass


@contextmanager
def pool_of_generator(threads: int, start: Callable[[], object] | None = None) -> Iterator[ThreadPoolExecutor]:
    """Threads for a generator to hand work to: at its end what has not begun is dropped, and nothing is waited for.

    A generator that is given up halfway may be ended by the garbage collector in any thread, also in one that is only
    starting: threads joined there, as a pool's own `with` does, are waited for forever.
    """
    pool = ThreadPoolExecutor(threads, initializer=start)
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def side_by_side(work: Callable[[Any], Any], things: Sequence[Any]) -> list[Any]:
    """What `work` makes of each thing, in their order, a thread each up to the number of cores."""
    out: list[Any] = [None] * len(things)

    def each(first: int, last: int) -> None:
        for i in range(first, last):
            out[i] = work(things[i])

    spread(each, len(things))
    return out
