"""Pairs of shape names by hand: `--map FILE`."""

import csv
import json
from pathlib import Path

from ..errors import BadInput
from ..files import existing
from ..text.decode_text import decode_text
from .markers.tables.delimited_table import commonest_delimiter


def read_name_map(path: str | Path) -> dict[str, str]:
    """A JSON object {name: name}, or a CSV with two columns; which of the two rigs comes first does not matter.

    Raises:
        BadInput: missing, or neither.
    """
    path = existing(path)
    text = decode_text(path)
    if text.lstrip()[:1] in ("{", "["):
        try:
            pairs = json.loads(text)
        except ValueError as error:
            raise BadInput(f'{path}: is no JSON ({error}); write {{"theirs": "jawOpen"}}') from error
        if not isinstance(pairs, dict) or not all(isinstance(value, str) for value in pairs.values()):
            raise BadInput(f'{path}: needs one JSON object of names, {{"theirs": "jawOpen"}}')
        return pairs
    delimiter = commonest_delimiter(text)
    rows = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines(), delimiter=delimiter) if any(row)]
    if not rows or any(len(row) < 2 or not row[0] or not row[1] for row in rows):
        raise BadInput(f"{path}: needs two columns, a name of each rig in every row: theirs,jawOpen")
    return {row[0]: row[1] for row in rows}
