"""Programs in C that several files of tests talk to."""

import pytest

from tools.vehicle_build import ROOT, SANITIZE, build


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    """session.c with the library, for `session.Session`."""
    folder = tmp_path_factory.mktemp("session")
    return build([ROOT / "tests" / "vehicle" / "session.c"], folder / "session", *SANITIZE)
