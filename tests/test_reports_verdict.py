import numpy as np

from mien.reports.verdict import WORSE, grade, scans_verdict, solve_verdict, truth_verdict


def test_words_follow_the_share_that_is_missed():
    assert [grade(share) for share in (0.2, 0.5, 0.9, 2.2)] == ["good", "fair", "poor", WORSE]


def test_verdicts_are_sentences_without_wild_figures():
    assert solve_verdict(0.17, 0.3).startswith("Good: 70% of what markers do")
    assert solve_verdict(0.2, 1.3).startswith("Poor: 0% of what markers do")
    assert "was not tried" in solve_verdict(0.17, np.nan)
    told = truth_verdict(2.2, 0.4)
    assert told.startswith(WORSE.capitalize())
    assert "0% of the performer's expression" in told
    assert "60% where it is strongest" in told


def test_scans_are_judged_by_the_regions_that_meet():
    assert scans_verdict(0.104, [], 48) == "All 48 regions correspond reliably. Skin lies 0.10 mm from the scans."
    told = scans_verdict(0.1, ["the mouth of a", "the chin of a", "the mouth of b", "the chin of b"], 48)
    named = "the mouth of a, the chin of a, the mouth of b, ..."
    assert told.startswith(f"44 of 48 regions correspond reliably; look at {named}")
