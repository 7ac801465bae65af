"""Every command that a page shows is one that there is: its options, targets, scripts and extras."""

import argparse
import functools
import re
import shlex
import tomllib

import pytest

from larics_host import cli
from larics_host.errors import UserError
from tests.host.test_dual import ROOT

PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in (ROOT, *(ROOT / name for name in ("docs", "firmware/vehicle", "ros2")))
    for path in (folder.glob("*.md") if folder == ROOT else folder.rglob("*.md"))
)
BLOCK = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.M | re.S)
INLINE = re.compile(r"`([^`\n]+)`")
ENDS = ("|", ">", ">>", "&&", ";", "&", "2>")
OTHER = ("json", "python", "c", "cpp", "cmake", "yaml", "ini", "mermaid")  # blocks that are no commands


def commands(text):
    """Lists of words, one a command, of a block for a shell."""
    found = []
    for line in text.replace("\\\n", " ").splitlines():
        try:
            words = shlex.split(line, comments=True)
        except ValueError:  # what is printed, not typed
            continue
        command = []
        for word in [*words, ";"]:
            if word in ENDS:
                found.append(command)
                command = []
            else:
                command.append(word)
    return [words for words in found if words]


def blocks(text):
    return [words for kind, block in BLOCK.findall(text) if kind not in OTHER for words in commands(block)]


def inline(text):
    rest = BLOCK.sub("", text)
    return [span.split() for span in INLINE.findall(rest)]


@functools.cache
def parser(name):
    return cli.build_parser(name)


@functools.cache
def options(name):
    """All options of a command and its sub-commands."""
    found, waiting = set(), [parser(name)]
    while waiting:
        for action in waiting.pop()._actions:
            found.update(action.option_strings)
            if isinstance(action, argparse._SubParsersAction):
                waiting += action.choices.values()
    return found


def refused(words):
    """What the command line would say to these words behind `larics`; None when it takes them."""
    try:
        parser(words[0] if words[0] in cli.COMMANDS else None).parse_args(words)
    except UserError as error:
        return str(error)
    except SystemExit:  # --help, --version
        return None
    return None


def missing(words):
    """What a command names that is not there, None when all is."""
    if words[0] == "make":
        targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.M)
        return next((w for w in words[1:] if re.fullmatch(r"[a-z-]+", w) and w not in targets), None)
    if words[:2] == ["pip", "install"]:
        with open(ROOT / "pyproject.toml", "rb") as file:
            extras = tomllib.load(file)["project"]["optional-dependencies"]
        named = [
            name
            for word in words[2:]
            for part in re.findall(r"\[([\w,]+)\]", word)
            for name in part.split(",")
        ]
        return next((name for name in named if name not in extras), None)
    if words[0] in ("python", "python3") and len(words) > 1:
        script = words[2].replace(".", "/") + ".py" if words[1] == "-m" and len(words) > 2 else words[1]
        if script.startswith("tools/") and not (ROOT / script).exists():
            return script
    return None


@pytest.mark.parametrize("page", PAGES)
def test_a_page_names_commands_that_there_are(page):
    text = (ROOT / page).read_text()
    wrong = [(words, missing(words)) for words in blocks(text) + inline(text) if words and missing(words)]
    for words in blocks(text):
        if words[0] == "larics" and len(words) > 1 and refused(words[1:]):
            wrong.append((words, refused(words[1:])))
    for words in inline(text):
        if words[0] == "larics" and len(words) > 1 and re.fullmatch(r"[a-z]+\d?", words[1]):
            named = {word.partition("=")[0] for word in words if re.fullmatch(r"--[a-z-]+(=.*)?", word)}
            if words[1] not in cli.COMMANDS or named - options(words[1]):
                wrong.append((words, "no such command or option"))
    assert not wrong


def test_what_is_not_there_is_noticed():
    assert any(words[0] == "larics" for words in blocks((ROOT / "README.md").read_text()))
    assert refused(["detect", "a.png", "--leap"]) and refused(["leap"])
    assert refused(["settings", "set", "--port", "x", "baud=1"]) is None
    assert missing(["make", "leap"]) == "leap" and missing(["pip", "install", ".[leap]"]) == "leap"
    assert (
        missing(["python", "tools/leap.py"]) == "tools/leap.py"
        and missing(["make", "test", "TEST=-k"]) is None
    )
    assert commands("larics detect a | larics log  # b\n") == [["larics", "detect", "a"], ["larics", "log"]]
