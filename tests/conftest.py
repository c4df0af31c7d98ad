"""The files that take longest come first: whichever begins last keeps the other core waiting for its whole length."""

LONGEST_FIRST = (
    "test_tracking_on_film.py",
    "test_viewer_studio.py",
    "test_scans_pipeline.py",
    "test_tracking.py",
    "test_cli_solve.py",
    "test_experiments_blendshapes_figures.py",
    "test_flow_variational.py",
    "test_fitting_register_scan.py",
    "test_io_fuzz.py",
)
"""10 s and more on a machine that has compiled nothing; told by `pytest --durations=40`."""


def pytest_collection_modifyitems(items):
    place = {name: i for i, name in enumerate(LONGEST_FIRST)}
    items.sort(key=lambda item: place.get(item.path.name, len(place)))
