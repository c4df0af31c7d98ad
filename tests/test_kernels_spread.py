"""Rows over threads: every row once, whatever the number of threads."""

import threading

import pytest

from mien._kernels._spread import cores, pool_of_generator, side_by_side, single_threaded, spread


def pieces(rows: int, threads: int) -> list[tuple[int, int]]:
    done, lock = [], threading.Lock()

    def work(first, last):
        with lock:
            done.append((first, last))

    spread(work, rows, threads)
    return sorted(done)


@pytest.mark.parametrize(("rows", "threads"), [(0, 3), (1, 3), (5, 1), (5, 2), (100, 7)])
def test_every_row_is_done_once(rows, threads):
    covered = [row for first, last in pieces(rows, threads) for row in range(first, last)]
    assert covered == list(range(rows))


def test_faults_come_out():
    def work(first, last):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        spread(work, 10, 2)


def test_a_worker_that_is_told_so_keeps_to_its_thread():
    seen = []

    def worker():
        single_threaded()
        spread(lambda a, b: seen.append((a, b, threading.get_ident())), 50)
        seen.append(threading.get_ident())

    one = threading.Thread(target=worker)
    one.start()
    one.join()
    assert seen[0] == (0, 50, seen[1])
    assert cores() >= 1


def test_things_side_by_side_come_out_in_their_order():
    assert side_by_side(lambda x: x * x, [3, 1, 2]) == [9, 1, 4]
    assert side_by_side(lambda x: x, []) == []
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda x: 1 / x, [1, 0])


def test_a_generator_that_is_given_up_waits_for_no_thread():
    begun, go = threading.Event(), threading.Event()

    def work():
        begun.set()
        return go.wait(30)

    def handing_out():
        with pool_of_generator(1) as pool:
            yield pool.submit(work), pool.submit(work)

    walk = handing_out()
    busy, queued = next(walk)
    begun.wait(30)
    walk.close()
    assert not busy.done()
    assert queued.cancelled()
    go.set()
    assert busy.result(30)
