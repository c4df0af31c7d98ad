"""Damaged files for every reader: any bytes must give data or one clear line.

    python tools/fuzz_readers.py --seconds 3600 [--only c3d] [--seed 1] [--keep FOLDER]

Small good files are made, damaged at random (bytes, lines, cells, counts, sections) and read. A fault is anything but
data or `BadInput` with one line: another exception, a warning, a read that takes longer than ten seconds. Try number n
of a reader is the same whenever it is run with the same seed. Files that brought a fault are kept in FOLDER.
"""

import argparse
import faulthandler
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from fuzz_mutations import damaged, damaged_folder
from fuzz_records import record_readers
from fuzz_seeds import Reader, readers

from mien.errors import BadInput

HANG_S = 10
"""Seconds after which a small file counts as never read."""


@dataclass(frozen=True)
class Fault:
    """A damaged file that brought neither data nor a clear line."""

    reader: str
    number: int
    """Which try it was."""
    error: str
    """Kind of the exception and the line of mien that it came through."""
    trace: str


def fuzz(
    folder: Path, seconds: float, seed: int = 0, only: str = "", keep: Path | None = None
) -> tuple[list[Fault], int]:
    """(faults, tries): every reader in turn until the time is over, at least once each."""
    stock = [reader for reader in all_readers(folder / "seeds") if only in reader.name]
    end = time.monotonic() + seconds
    faults: list[Fault] = []
    tries = 0
    while tries < len(stock) or time.monotonic() < end:
        number, place = divmod(tries, len(stock))
        fault = attempt(stock[place], number, seed, folder / "work", keep)
        faults += [fault] if fault else []
        tries += 1
    return faults, tries


def all_readers(folder: Path) -> list[Reader]:
    """Readers of files by other programs and of our own records."""
    return [*readers(folder), *record_readers(folder)]


def attempt(reader: Reader, number: int, seed: int, work: Path, keep: Path | None = None) -> Fault | None:
    """Try `number` of one reader."""
    rng = random.Random(f"{seed} {reader.name} {number}")
    path = _damaged_copy(rng, reader, work)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            signal.alarm(HANG_S)
            reader.read(path)
    except BadInput as refusal:
        if "\n" not in str(refusal).strip() and str(refusal).strip():
            return None
        error: BaseException = refusal
    except Exception as unexpected:
        error = unexpected
    else:
        return None
    finally:
        signal.alarm(0)
    if keep is not None:
        _keep(path, keep / f"{reader.name}-{seed}-{number}{path.suffix}")
    return Fault(reader.name, number, _summary(error), "".join(traceback.format_exception(error)))


def _damaged_copy(rng: random.Random, reader: Reader, work: Path) -> Path:
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    seed = rng.choice(reader.seeds)
    target = work / seed.name
    if seed.is_dir():
        shutil.copytree(seed, target)
        damaged_folder(rng, target)
        return target
    for beside in seed.parent.iterdir():
        if beside.is_file() and beside.stem.split(".")[0] == seed.stem.split(".")[0]:
            shutil.copy(beside, work / beside.name)
    target.write_bytes(damaged(rng, seed.read_bytes(), reader.kind or seed.suffix.lower()))
    return target


def _summary(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "/mien/" in frame.filename]
    place = f"{Path(ours[-1].filename).name}:{ours[-1].lineno} {ours[-1].name}" if ours else "?"
    return f"{type(error).__name__} in {place}: {str(error)[:120]!r}"


def _keep(path: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        shutil.copytree(path, target, dirs_exist_ok=True)
    elif path.exists():
        shutil.copy(path, target)


def _alarm(*_):
    raise TimeoutError(f"not read within {HANG_S} s")


signal.signal(signal.SIGALRM, _alarm)


def main() -> int:
    """Run as a command: a table of faults, exit status 1 if there are any."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seconds", type=float, default=60)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--only", default="", help="part of the readers' names")
    options.add_argument("--keep", type=Path, help="folder for the files that brought a fault")
    chosen = options.parse_args()
    faulthandler.enable()
    with tempfile.TemporaryDirectory() as folder:
        faults, tries = fuzz(Path(folder), chosen.seconds, chosen.seed, chosen.only, chosen.keep)
    kinds = Counter((fault.reader, fault.error) for fault in faults)
    for (reader, error), count in kinds.most_common():
        first = next(fault for fault in faults if (fault.reader, fault.error) == (reader, error))
        print(f"{count:5d}  {reader} (try {first.number}): {error}")
    print(f"{tries} tries, {len(faults)} faults of {len(kinds)} kinds")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
