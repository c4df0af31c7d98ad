"""Any bytes give data or one clear line, in every reader: damaged files, a few seconds each time."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

from fuzz_readers import all_readers, attempt, fuzz
from fuzz_seeds import Reader

from mien.errors import BadInput

SECONDS = 8
"""By hand as long as one likes: python tools/fuzz_readers.py --seconds 3600."""


def test_the_undamaged_files_are_read(tmp_path):
    for reader in all_readers(tmp_path):
        for seed in reader.seeds:
            assert reader.read(seed) is not None


def test_any_bytes_give_data_or_one_clear_line(tmp_path):
    faults, tries = fuzz(tmp_path, SECONDS)
    assert not faults, "\n".join(f"{fault.reader} try {fault.number}: {fault.error}" for fault in faults)
    assert tries > 100


def test_the_fuzz_would_notice(tmp_path):
    """An exception, a warning and a refusal of two lines are faults; data and one line are not."""
    import warnings

    seed = tmp_path / "a.csv"
    seed.write_text("1,2\n3,4\n")

    def fault(read) -> str:
        found = attempt(Reader("x", (seed,), read), 0, 0, tmp_path / "work")
        return found.error if found else ""

    def refuse(text: str):
        raise BadInput(text)

    assert "ZeroDivisionError" in fault(lambda path: 1 / 0)
    assert "UserWarning" in fault(lambda path: warnings.warn("odd", stacklevel=1))
    assert "BadInput" in fault(lambda path: refuse("two\nlines"))
    assert fault(lambda path: refuse("one line")) == ""
    assert fault(lambda path: path.read_bytes()) == ""
