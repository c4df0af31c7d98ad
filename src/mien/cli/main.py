"""The command line: one verb a stage, in pipeline order. Bad input is one line on stderr and exit status 2."""

import errno
import os
import sys
from importlib.util import find_spec
from typing import NoReturn

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: our loops have threads of their own

from cyclopts import App, CycloptsError, Group

from .. import __version__
from ..errors import BadInput
from .usage import one_line, usage_line

app = App(
    name="mien",
    version=__version__,
    help="Facial performance capture: markers, scans and RGB-D video in; an animated face with a rig out.",
    default_parameter=None,
    suppress_keyboard_interrupt=False,
)

VERBS = Group("Verbs, in pipeline order", sort_key=0)

PIPELINE = {
    "demo": "The whole of one system on the bundled actor; ends with a picture and a report.",
    "solve": "Markers to an animated face.",
    "select": "The fewest frames of a take to scan.",
    "register": "Scans to one topology.",
    "scan": "A held expression before an RGB-D sensor to one textured scan.",
    "rig": "Captures of expressions to a rig with textures.",
    "personalize": "An RGB-D take to a personal rig.",
    "track": "RGB-D or video to an animated face.",
    "retarget": "An animated face onto another rig.",
    "detail": "Wrinkles and pores from markers.",
    "decode": "Pictures of active light to detailed scans.",
    "view": "Faces in the browser, moving.",
    "render": "Pictures, contact sheets and films.",
    "convert": "From one format to another.",
    "stream": "To avatar programs and engines, over the network.",
    "fetch": "Bring the landmark model.",
}
"""One line a verb, so that `--help` need not import them all."""

for place, (name, line) in enumerate(PIPELINE.items()):
    if find_spec(f"mien.cli.{name}"):
        app.command(f"mien.cli.{name}:{name}", name=name, help=line, group=VERBS, sort_key=place)


OF_THE_PLACE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM)
"""Faults of the system that are no fault of ours: a full disk, a place that may not be written."""

USAGE = 2
"""Exit status of a command line or an input that cannot be used."""

STOPPED = 130
"""Exit status after Ctrl-C: 128 and the number of the signal."""


def main(words: list[str] | None = None) -> None:
    """Entry point of the `mien` command; `words` stand for the command line's."""
    words = sys.argv[1:] if words is None else words
    try:
        app(words, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        stop(usage_line(error, words, PIPELINE), USAGE)
    except BadInput as error:
        stop(one_line(str(error)), USAGE)
    except KeyboardInterrupt:
        stop("stopped; outputs that were finished are whole, the same command goes on", STOPPED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        if error.errno not in OF_THE_PLACE:
            raise
        stop(f"{error.filename or 'the output'}: {error.strerror}", USAGE)


def stop(line: str, status: int) -> NoReturn:
    """End with one line on stderr."""
    print(f"mien: {line}", file=sys.stderr)
    sys.exit(status)
