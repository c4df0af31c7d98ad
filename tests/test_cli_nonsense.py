"""Every option of every verb refuses values that cannot be, in one line and before any work."""

import inspect
from typing import get_args

import pytest

from mien.cli.main import PIPELINE, app, attempt
from mien.cli.options import JOIN, SIGNED, flag_name, is_whole, leaves, overlaid
from mien.errors import BadInput

WORDS = {
    "demo": ["markers"],
    "retarget": ["a.glb", "--to", "b.glb"],
    "detail": ["fit", "a"],
    "render": ["a.glb", "-o", "a.png"],
    "convert": ["a.glb", "-o", "b.glb"],
}
"""What a verb must be given; else a file."""


def numeric(verb: str):
    """Names of a verb's own options that are numbers, and whether they are whole ones."""
    for p in inspect.signature(app[verb].default_command).parameters.values():
        if p.kind is inspect.Parameter.KEYWORD_ONLY and p.name.count(JOIN) < 2:
            [kind, *_] = get_args(p.annotation) if hasattr(p.annotation, "__metadata__") else [p.annotation]
            if is_whole(kind) or float in (kind, *get_args(kind)):
                yield p.name, is_whole(kind)


def refusal(verb: str, *words: str) -> str:
    fault, status = attempt([verb, *WORDS.get(verb, ["a"]), *words])
    assert status == 2, f"{verb} {words}"
    assert "\n" not in fault, f"{verb} {words}"
    return fault


@pytest.mark.parametrize("verb", PIPELINE)
def test_what_is_no_number_is_refused_by_the_option_s_name(verb):
    for name, whole in numeric(verb):
        flag = flag_name(name)
        assert flag in refusal(verb, flag, "1.5" if whole else "nan")
        if JOIN not in name:
            assert flag in refusal(verb, flag, "-1" if whole else "inf")


def test_what_has_a_sign_may_be_below_0():
    """Angles and shifts: the verb goes on to its file."""
    assert refusal("render", "--yaw-deg", "-20", "--pitch-deg", "-5") == "a.glb: no such file or folder"
    assert "below 0" not in refusal("select", "--video-offset", "-2")
    assert "--tolerance: -1 is below 0" in refusal("select", "--tolerance", "-1")


@pytest.mark.parametrize("verb", PIPELINE)
def test_settings_of_the_steps_inside_are_no_nan_and_not_below_0(verb):
    configs = getattr(app[verb].default_command, "configs", {})
    for config, instance in configs.items():
        for path, _, value, _ in leaves(instance, config):
            numbers = value if isinstance(value, tuple) else [value]
            if all(type(number) in (int, float) for number in numbers):
                with pytest.raises(BadInput, match=f"^{flag_name(path)}: nan"):
                    overlaid(configs, {path: float("nan")})
                if min(numbers, default=0) >= 0 and path.split(JOIN)[-1] not in SIGNED:
                    with pytest.raises(BadInput, match=f"^{flag_name(path)}: -1 is below 0"):
                        overlaid(configs, {path: -1.0})


@pytest.mark.parametrize(
    "line",
    [
        "register {} --density 9",
        "stream a.glb --vmc 127.0.0.1 --fps 0",
        "stream a.glb --vmc 127.0.0.1 --fps 1e30",
        "render {} -o a.mp4 --fps inf",
        "rig {} --texture 99999999",
        "rig {} --pixel-mm 0",
        "scan {} --pixel-mm 1e-9",
        "rig {} --corrections {}",
        "track {} --rate 0",
        "track {} --focal 0",
        "select {} --sheet a.png --video {}",
        "scan {} --depth-scale 0",
    ],
)
def test_what_would_never_end_is_refused_before_it_begins(line, tmp_path):
    fault, status = attempt(line.format(*[tmp_path] * 2).split())
    option = line.split()[-2]
    assert status == 2
    assert fault.startswith((f"{option}: ", f"{tmp_path}: "))
    assert "\n" not in fault
