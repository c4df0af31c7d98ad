"""The command line: one verb a stage, in pipeline order. Bad input is one line on stderr and exit status 2."""

import os
import sys

from cyclopts import App, Group

from .. import __version__
from ..errors import BadInput

app = App(
    name="mien",
    version=__version__,
    help="Facial performance capture: markers, scans and RGB-D video in; an animated face with a rig out.",
    default_parameter=None,
)

VERBS = Group("Verbs, in pipeline order", sort_key=0)

for place, name in enumerate(("demo", "solve", "render", "convert", "fetch")):
    app.command(f"mien.cli.{name}:{name}", name=name, group=VERBS, sort_key=place)


def main() -> None:
    """Entry point of the `mien` command."""
    try:
        app()
    except BadInput as error:
        print(f"mien: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("mien: stopped; outputs that were finished are whole, run the same command again to go on", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
