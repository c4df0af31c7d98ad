"""The command line: one verb a stage, in pipeline order. Bad input is one line on stderr and exit status 2."""

import os
import sys
from importlib.util import find_spec

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: our loops have threads of their own

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

PIPELINE = {
    "demo": "The whole of one system on the bundled actor; ends with a picture and a report.",
    "solve": "Markers to an animated face.",
    "select": "The fewest frames of a take to scan.",
    "register": "Scans to one topology.",
    "personalize": "An RGB-D take to a personal rig.",
    "track": "RGB-D or video to an animated face.",
    "retarget": "An animated face onto another rig.",
    "render": "Pictures, contact sheets and films.",
    "convert": "From one format to another.",
    "fetch": "Bring the landmark model.",
}
"""One line a verb, so that `--help` need not import them all."""

for place, (name, line) in enumerate(PIPELINE.items()):
    if find_spec(f"mien.cli.{name}"):
        app.command(f"mien.cli.{name}:{name}", name=name, help=line, group=VERBS, sort_key=place)


def main(words: list[str] | None = None) -> None:
    """Entry point of the `mien` command; `words` stand for the command line's."""
    try:
        app(sys.argv[1:] if words is None else words)
    except BadInput as error:
        print(f"mien: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("mien: stopped; outputs that were finished are whole, the same command goes on", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
