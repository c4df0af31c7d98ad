"""The command line: one verb a stage, in pipeline order. Bad input is one line on stderr and exit status 2."""

import errno
import os
import sys
from contextlib import redirect_stdout
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import NoReturn

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: our loops have threads of their own

from cyclopts import App, CycloptsError, Group

from .. import __version__
from ..errors import BadInput
from ..files import recorded
from .help_page import ALL, with_help
from .kinds import hint
from .outcome import as_json, next_steps
from .usage import one_line, usage_line

app = App(
    name="mien",
    version=__version__,
    help="Facial performance capture: markers, scans and RGB-D video in; an animated face with a rig out.",
    help_epilogue="`mien help VERB` tells of one verb, `mien FILE` what a file is and what can be done with it. "
    "`--json` after any verb: what came of it, for programs.",
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
    "doctor": "What is installed, what is missing, how fast this machine is.",
    "fetch": "Bring the landmark model.",
}
"""One line a verb, so that `--help` need not import them all."""

for place, (name, line) in enumerate(PIPELINE.items()):
    if find_spec(f"mien.cli.{name}"):
        app.command(f"mien.cli.{name}:{name}", name=name, help=line, group=VERBS, sort_key=place)


app.register_install_completion_command()

JSON = "--json"
"""A flag of every verb: what came of it as one JSON object on stdout."""

OF_THE_PLACE = (
    errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EISDIR, errno.ENOTDIR, errno.ENAMETOOLONG,
)  # fmt: skip
"""Faults of the system that are no fault of ours: a full disk, a place that may not be written, a folder for a file."""

USAGE = 2
"""Exit status of a command line or an input that cannot be used."""

STOPPED = 130
"""Exit status after Ctrl-C: 128 and the number of the signal."""


def main(words: list[str] | None = None) -> NoReturn:
    """Entry point of the `mien` command; `words` stand for the command line's."""
    words = list(sys.argv[1:] if words is None else words)
    if JSON in words:
        words.remove(JSON)
        answer_in_json(words)
    with recorded() as written:
        fault, status = attempt(words)
    if fault:
        print(f"mien: {fault}", file=sys.stderr)
    elif words:
        for line in next_steps(words[0], written):
            print(line)
    sys.exit(status)


def answer_in_json(words: list[str]) -> NoReturn:
    """Run a verb, and print what came of it as one object."""
    said = StringIO()
    with recorded() as written, redirect_stdout(said):
        fault, status = attempt(words)
    verb = words[0] if words else ""
    print(as_json(verb, status, written.paths, said.getvalue(), fault))
    sys.exit(status)


def attempt(words: list[str]) -> tuple[str, int]:
    """Run a command line: what went wrong, in one line (empty if nothing), and the exit status."""
    try:
        run(words)
    except CycloptsError as error:
        return usage_line(error, words, PIPELINE), USAGE
    except BadInput as error:
        line = one_line(str(error))
        more = hint(words[0], words[1:]) if words else ""
        return line + more, USAGE
    except KeyboardInterrupt:
        return "stopped; outputs that were finished are whole, the same command goes on", STOPPED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return "", 1
    except OSError as error:
        if error.errno not in OF_THE_PLACE:
            raise
        return f"{error.filename or 'the output'}: {error.strerror}", USAGE
    return "", 0


def run(words: list[str]) -> None:
    """What the words say: a verb, help on one, or a file alone."""
    verb = words[0] if words else ""
    if verb == "help":
        words = [*words[1:2], "--help"]
        verb = words[0]
    everything = ALL in words
    if verb in PIPELINE and (everything or "--help" in words or "-h" in words):
        with_help(app, verb, everything)
        words = ["--help" if word == ALL else word for word in words]
    if verb not in PIPELINE and len(words) == 1 and Path(verb).expanduser().exists():
        from .about import about

        path = Path(verb).expanduser()
        for line in about(path):
            print(line)
        return
    app(words, exit_on_error=False, print_error=False, result_action="return_value")
