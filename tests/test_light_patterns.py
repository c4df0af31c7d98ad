import numpy as np
import pytest

from mien.errors import BadInput
from mien.light.patterns import gray_set, paper_set, phase_set, profile, ramp_set, read_patterns, write_patterns


def test_the_papers_set_has_twelve_slots_and_a_coarsest_pattern_without_folds():
    patterns = paper_set(1024, 768)
    assert len(patterns) == 12
    assert patterns.rate / len(patterns) == 30
    coarsest = profile(patterns.patterns[0], 1024)
    assert (np.diff(coarsest) < 0).all()
    periods = [patterns.patterns[slot].periods for slot in patterns.of("sinusoid")]
    np.testing.assert_allclose(np.diff(np.log(periods[:-1])), np.log(periods[1] / periods[0]))


def test_where_one_of_the_finest_patterns_is_flat_the_other_is_steep():
    patterns = paper_set(1024, 768)
    finest = [patterns.patterns[slot] for slot in patterns.of("sinusoid")][-2:]
    told = sum(np.gradient(profile(wave, 1024)) ** 2 for wave in finest)
    assert told[1:-1].min() > 0.9 * told.max()


@pytest.mark.parametrize("axis", ["x", "y"])
def test_gray_codes_of_neighbours_differ_in_one_bit_and_inverses_are_inverse(axis):
    patterns = gray_set(100, 60)
    size = 100 if axis == "x" else 60
    bits = np.stack([profile(patterns.patterns[slot], size) for slot in patterns.of("gray", axis=axis)])
    inverse = np.stack([profile(patterns.patterns[slot], size) for slot in patterns.of("gray_inverse", axis=axis)])
    assert (np.abs(np.diff(bits, axis=1)).sum(axis=0) == 1).all()
    np.testing.assert_array_equal(bits + inverse, 1)


def test_images_have_the_projectors_size_and_lamps_have_none():
    patterns = paper_set(64, 48)
    assert patterns.image(0).shape == (48, 64)
    assert patterns.image(patterns.one("full")).min() == 1
    with pytest.raises(BadInput, match="lamps"):
        patterns.image(patterns.one("tracking"))


def test_ramps_go_from_black_to_white():
    levels = [ramp_set(8, 4).image(slot).mean() for slot in range(9)]
    np.testing.assert_allclose(levels, np.linspace(0, 1, 9))


def test_lists_come_back_and_others_are_refused(tmp_path):
    for patterns in (paper_set(64, 48), phase_set(64, 48, 5), gray_set(64, 48)):
        write_patterns(tmp_path / "p.json", patterns)
        assert read_patterns(tmp_path / "p.json") == patterns
    for text in ("{}", "[1]", "no", '{"patterns": [{"kind": "moire"}], "width": 2, "height": 2}'):
        (tmp_path / "p.json").write_text(text)
        with pytest.raises(BadInput, match=r"p\.json"):
            read_patterns(tmp_path / "p.json")
    with pytest.raises(BadInput, match="3 steps"):
        phase_set(64, 48, 2)
    with pytest.raises(BadInput, match="expected one black"):
        paper_set(64, 48).one("black")
