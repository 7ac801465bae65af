"""The pages for people name only what there is, and show the code's own numbers."""

import ast
import functools
import os
import re
import subprocess
import sys

import pytest

from larics.wire import messages as m
from larics.wire import nmea
from tests.host.test_dual import ROOT
from tools import check_rules

PAGES = ("docs/architecture.md", "docs/detector.md", "docs/fleet.md", "CONTRIBUTING.md", "README.md")
NAMED = re.compile(r"`((?:shared|firmware|host|tests|tools|docs)/[\w/.]+)(?::([\w.]+))?`")


@functools.cache
def tree(path):
    return ast.parse((ROOT / path).read_text())


def has(path, name):
    """Whether a module has a function, class or method of this dotted name."""
    body = tree(path).body
    for part in name.split("."):
        found = [node for node in body if getattr(node, "name", None) == part]
        if not found:
            return False
        body = found[0].body
    return True


@pytest.mark.parametrize("page", PAGES)
def test_every_file_and_function_named_exists(page):
    named = NAMED.findall((ROOT / page).read_text())
    assert named
    missing = [path for path, _ in named if not (ROOT / path).exists()]
    assert not missing
    missing = [path + ":" + name for path, name in named if name and not has(path, name)]
    assert not missing


def test_what_is_not_there_is_noticed():
    assert has("firmware/loop.py", "Loop.step")
    assert not has("firmware/loop.py", "Loop.leap") and not has("firmware/loop.py", "step")
    assert NAMED.findall("see `firmware/loop.py:Loop.leap`, `docs/x.md` or `x.py`") == [
        ("firmware/loop.py", "Loop.leap"),
        ("docs/x.md", ""),
    ]


def test_the_arrows_are_those_that_are_enforced():
    text = (ROOT / "docs" / "architecture.md").read_text()
    table = text.split("<!-- arrows:begin -->")[1].split("<!-- arrows:end -->")[0]
    rows = re.findall(r"^\| `(\w+)` \|[^|]*\|([^|]*)\|$", table, re.M)
    found = {name: tuple(re.findall(r"`(\w+)`", targets)) for name, targets in rows}
    assert found == {name: arrows for name, arrows in check_rules.ARROWS.items() if name != "_cpython"}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text()
    folder = (ROOT / page).parent
    links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)]+)\)", text) if "://" not in link]
    assert not [link for link in links if link and not (folder / link).exists()]


def test_every_limit_stands_in_the_page_with_its_value():
    from tools import detector_limits

    text = detector_limits.PAGE.read_text()
    explained = dict(detector_limits.sections(text))
    assert len(explained) >= 11
    for path, section in explained.items():
        rows = dict(detector_limits.ROW.findall(section))
        assert rows.keys() == detector_limits.limits(path).keys(), path
        for row in re.findall(r"^\| `.*$", section, re.M):
            assert all(cell.strip() for cell in row.strip("|").split("|")), row
    assert detector_limits.with_values(text) == text, "run: python -m tools.detector_limits"


def test_the_pictures_of_the_page_can_be_made_again_and_are_small(tmp_path, capsys):
    from tools import detector_figures

    detector_figures.main(tmp_path)
    capsys.readouterr()
    names = {path.name for path in tmp_path.glob("*.png")}
    kept = {path.name: path for path in (ROOT / "docs" / "detector").glob("*.png")}
    assert names == kept.keys() and len(names) == 8
    assert all(path.stat().st_size < 300_000 for path in kept.values())
    # what the README's lines are shown to read is still what is rendered
    assert (tmp_path / "frame.png").read_bytes() == kept["frame.png"].read_bytes()


def test_the_readmes_python_runs_and_prints_what_it_says():
    text = (ROOT / "README.md").read_text()
    part = text.split("<!-- python:begin -->")[1].split("<!-- python:end -->")[0]
    ((_, code), (_, said)) = re.findall(r"^```(python|text)\n(.*?)^```$", part, re.M | re.S)
    assert len(code.splitlines()) <= 11
    environment = dict(os.environ, PYTHONPATH="shared:host")
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert (result.returncode, result.stdout, result.stderr) == (0, said, "") and "ID 1513" in said


def test_the_readme_tells_the_lines_share_as_the_wires_page_does():
    rates = (ROOT / "docs" / "wire.md").read_text().split("begin rates")[1]
    slow, fast = re.search(
        r"^\| MARKER, POSE, STATUS \| \d+ \| (.+?) \| (.+?) \|", rates, re.MULTILINE
    ).groups()
    text = " ".join((ROOT / "README.md").read_text().split())
    assert (
        "one marker, the pose and STATUS take %s of a line of 115200 baud, %s of 921600" % (slow, fast)
        in text
    )


def test_the_letters_of_the_states_are_explained():
    text = " ".join((ROOT / "docs" / "wire.md").read_text().split())
    words = {m.TRACKING: "T (tracking)", m.COASTING: "C (coasting)"}
    words.update({m.CARRIED: "O (carried", m.LOST: "L (lost)"})
    assert len(nmea._STATES) == len(words) and all(word in text for word in words.values())
    assert all(nmea._STATES[state] == ord(word[0]) for state, word in words.items())
