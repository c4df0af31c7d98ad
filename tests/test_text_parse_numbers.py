"""Numbers out of large texts."""

import numpy as np

from mien.text.parse_numbers import parse_floats, parse_integers, token_starts, tokens_by_line


def test_parse_floats():
    np.testing.assert_array_equal(parse_floats(b" 1 -2.5e1\n3\t.5 "), [1, -25, 3, 0.5])
    assert parse_floats(b"1 two 3") is None
    np.testing.assert_array_equal(parse_floats(b""), [])


def test_parse_integers():
    np.testing.assert_array_equal(parse_integers(b"1 -2\n3"), [1, -2, 3])
    assert parse_integers(b"1 2.5") is None


def test_tokens():
    text = b"a bb\n\n c "
    assert tokens_by_line(text).tolist() == [2, 0, 1]
    assert token_starts(np.frombuffer(text, np.uint8)).sum() == 3
