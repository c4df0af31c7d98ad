"""Marker takes as text tables: which program's they are."""

from pathlib import Path

from ..marker_file import RawTake
from .delimited_table import BLANK, read_cells
from .long_table import read_long
from .motive import is_motive, read_motive
from .nexus import is_nexus, read_nexus
from .qualisys import is_qualisys, read_qualisys
from .table_header import is_long, table_under_header
from .trc import read_trc
from .wide_table import read_wide


def read_table(path: Path) -> RawTake:
    """A table of marker positions with a header: of Motive, Nexus, Track Manager, or any that names its columns.

    Long: columns frame (or time), label (or marker, name), x, y, z. Wide: a row a frame and columns NAME_x, NAME_y,
    NAME_z (or `.`, `:`, `-`, blank between, or x_NAME). Two-row: names above a row of X, Y, Z. Case does not matter. A
    unit may stand in brackets (`NAME_x [mm]`), in a row of its own or ahead of the header. Frame numbers that are left
    out become gaps; a time column (seconds, or `[ms]`) gives the rate; in wide forms all other columns become notes.

    Raises:
        BadInput: empty, no such header, frame numbers that run backwards, a cell that is no number.
    """
    cells, delimiter = read_cells(path)
    if is_qualisys(cells):
        return read_qualisys(path, cells)
    if is_nexus(cells):
        return read_nexus(path, cells)
    take = read_motive(path, cells) if is_motive(cells) else None
    if take is not None:
        return take
    table = table_under_header(path, cells, blanks=delimiter == BLANK)
    return read_long(table) if is_long(table.columns) else read_wide(table)


__all__ = ["read_table", "read_trc"]
