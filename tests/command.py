"""A verb called as a user calls it, its errors raised."""

from pathlib import Path

from mien.cli.main import app


def mien(verb: str, *words: str | Path, **options: object) -> None:
    """`mien VERB WORDS --option value ...`: True stands for a flag alone, False for its `no-` form."""
    line = [verb, *map(str, words)]
    for name, value in options.items():
        flag = name.replace("__", ".").replace("_", "-")
        if isinstance(value, bool):
            line.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            line += [f"--{flag}", str(value)]
    app(line, exit_on_error=False, print_error=False, result_action="return_value")
