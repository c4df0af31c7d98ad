"""Usage errors have one style: one line that says what is wrong and where to read more, exit status 2."""

import pytest

from mien.cli.main import main


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("slove take.c3d", "slove: no such verb; did you mean solve?; see `mien --help`"),
        ("tka.c3d", "tka.c3d: no such file; see `mien --help`"),
        ("takes/", "takes/: no such file; see `mien --help`"),
        ("solve", "solve: TAKE is missing; see `mien solve --help`"),
        ("solve x --bad 1", "--bad: no such option of solve; see `mien solve --help`"),
        ("solve x --unit mm", "--unit: no such option of solve; did you mean --units?; see `mien solve --help`"),
        ("solve x --rate", "--rate: its value is missing; see `mien solve --help`"),
        ("solve x y", "y: one word too many for solve; see `mien solve --help`"),
        ("render a.obj", "render: --output is missing; see `mien render --help`"),
        (
            "solve x --rate abc",
            'invalid value for --rate: unable to convert "abc" into float; see `mien solve --help`',
        ),
        (
            "personalize x --shapes all",
            'invalid value "all" for --shapes. Choose from: "arkit", "facs23"; see `mien personalize --help`',
        ),
    ],
)
def test_usage_errors(words, line, capsys):
    with pytest.raises(SystemExit) as stop:
        main(words.split())
    assert stop.value.code == 2
    assert capsys.readouterr().err == f"mien: {line}\n"
