"""What is reported on was not tuned on."""

from mien.stage.seeds import MANY_REPORTING_SEEDS, REPORTING_SEEDS, TUNING_SEEDS


def test_seeds_to_tune_on_and_to_report_on_are_apart():
    assert not set(TUNING_SEEDS) & set(MANY_REPORTING_SEEDS)
    assert set(REPORTING_SEEDS) <= set(MANY_REPORTING_SEEDS)
    assert len(MANY_REPORTING_SEEDS) >= 20
