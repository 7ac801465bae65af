"""The site of the pages and docstrings: built without a warning; docstrings and files elsewhere in it."""

import subprocess
import sys

import pytest

from tests.host.test_dual import ROOT

sys.path.append(str(ROOT / "docs" / "site"))
import docstrings  # noqa: E402
import pages_elsewhere  # noqa: E402


def build(source, out):
    return subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", str(source), str(out)],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    result = build(ROOT / "docs", out)
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
    return out


def test_every_page_and_picture_is_there(site):
    for page in (ROOT / "docs").rglob("*.md"):
        assert (site / page.relative_to(ROOT / "docs").with_suffix(".html")).exists(), page
    assert "GET_SETTING" in (site / "wire.html").read_text()


def test_the_reference_shows_docstrings(site):
    text = (site / "python.html").read_text()
    assert "Finds markers in grey frames of one size" in text and "radius_min_px" in text


def test_pages_from_elsewhere_are_whole_and_link_within_the_site(site):
    text = (site / "vehicle_library.html").read_text()
    assert (
        "larics_supervisor.h" in text
        and 'href="vehicle_functions.html"' in text
        and 'href="wire.html"' in text
    )
    assert pages_elsewhere.page_of("wire") is None


def test_a_link_to_nowhere_is_an_error(tmp_path):
    (tmp_path / "conf.py").write_text('extensions = ["myst_parser"]\n')
    (tmp_path / "index.md").write_text("# A\n\n[b](b.md)\n")
    result = build(tmp_path, tmp_path / "out")
    assert result.returncode != 0 and "b.md" in result.stderr


def test_docstrings_keep_their_columns_and_examples():
    lines = [
        "Finds `it` * 2.",
        "",
        "width, height    px",
        "line_mm    width of",
        "           the line",
        "",
        "    run()",
    ]
    assert docstrings.restructured(lines) == [
        "Finds ``it`` \\* 2.", "",
        ":``width, height``: px", ":``line_mm``: width of the line", "",
        ".. code-block:: text", "", "        run()", "",
    ]  # fmt: skip
