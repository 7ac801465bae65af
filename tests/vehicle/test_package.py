"""The library as its users install it: archive, metadata, pages, and what each build system finds."""

import json
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

import larics
from larics_host.drive.c_controller import STATES
from tools import vehicle_package
from tools.vehicle_build import LIBRARY, SOURCES, STRICT

FOLDER = LIBRARY.parent


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The library as it comes out of the archive."""
    folder = tmp_path_factory.mktemp("package")
    archive = vehicle_package.make(folder)
    first = archive.read_bytes()
    assert vehicle_package.make(folder).read_bytes() == first  # the same sources, the same bytes
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder)
    return folder / ("LARICS-" + larics.__version__)


def test_the_root_of_the_archive_is_the_library(unpacked):
    names = {path.name for path in unpacked.iterdir()}
    assert names == {
        *("CMakeLists.txt", "LICENSE", "README.md", "REFERENCE.md", "examples", "idf_component.yml"),
        *("keywords.txt", "library.json", "library.properties", "src", "zephyr"),
    }


def test_metadata_agree(unpacked):
    properties = dict(
        line.split("=", 1) for line in (unpacked / "library.properties").read_text().splitlines()
    )
    for name in ("name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url"):
        assert properties[name]
    assert set(properties["includes"].split(",")) <= {path.name for path in (unpacked / "src").glob("*.h")}
    described = json.loads((unpacked / "library.json").read_text())
    assert described["version"] == properties["version"] == larics.__version__
    for example in described["examples"]:
        assert all((unpacked / example["base"] / name).is_file() for name in example["files"])
    assert larics.__version__ in (unpacked / "idf_component.yml").read_text()


def test_the_address_is_a_placeholder_until_it_is_given(tmp_path, capsys):
    def told(archive):
        with zipfile.ZipFile(archive) as opened:
            root = archive.stem + "/"
            names = ("library.properties", "library.json", "idf_component.yml")
            return [opened.read(root + name).decode() for name in names]

    for text in told(vehicle_package.make(tmp_path)):
        assert text.count("https://larics-camera.example/vehicle") == 1  # reserved: it leads nowhere
    assert vehicle_package.main([str(tmp_path), "--url", "https://robots.invalid/larics"]) == 0
    for text in told(next(tmp_path.glob("*.zip"))):
        assert text.count("https://robots.invalid/larics") == 1 and ".example" not in text
    assert vehicle_package.main([str(tmp_path), "--url", 'no "address']) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_headers_named_are_the_public_ones():
    names = {path.name for path in vehicle_package.public_headers()}
    assert set(json.loads((FOLDER / "library.json").read_text())["headers"]) == names
    properties = (FOLDER / "library.properties").read_text()
    assert set(re.search("^includes=(.*)$", properties, re.MULTILINE).group(1).split(",")) == names


def test_keywords_are_what_the_headers_declare(unpacked):
    rows = [line.split("\t") for line in (unpacked / "keywords.txt").read_text().splitlines()]
    assert all(len(row) == 2 for row in rows)
    kinds = dict(rows)
    assert kinds["larics_supervisor"] == "KEYWORD1" and kinds["larics_begin_drain"] == "KEYWORD2"
    assert "larics_since_ms" not in kinds and "larics_layout" not in kinds  # private
    assert kinds["LARICS_GOOD"] == "LITERAL1" and kinds["larics_encode"] == "KEYWORD2"


def test_cmake_builds_it(unpacked, tmp_path):
    if not shutil.which("cmake"):
        pytest.skip("not installed: apt-get install cmake")
    (tmp_path / "main.c").write_text(
        '#include "larics_drive.h"\nint main(void) { larics_drive d; return !larics_drive_init(&d, 0); }\n'
    )
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.13)\nproject(app C)\nadd_subdirectory(%s larics)\n"
        "add_executable(app main.c)\ntarget_link_libraries(app PRIVATE larics)\n" % unpacked
    )
    for command in (["cmake", "-S", ".", "-B", "out"], ["cmake", "--build", "out"], ["out/app"]):
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)


def test_every_build_system_names_every_source():
    text = (FOLDER / "CMakeLists.txt").read_text()
    assert set(re.findall(r"src/(\w+\.c)", text)) == {path.name for path in SOURCES}
    assert (
        "idf_component_register" in text
        and "zephyr_library" in (FOLDER / "zephyr" / "CMakeLists.txt").read_text()
    )


def pages():
    """{function: text of its page}"""
    text = (FOLDER / "REFERENCE.md").read_text()
    return {part.split("\n", 1)[0]: part for part in text.split("\n### ")[1:]}


def test_every_function_has_a_page():
    declared = {}
    for header in vehicle_package.public_headers():
        for match in re.finditer(r"^[a-z][\w ]*\b(larics_\w+)\([^;{]*\);", header.read_text(), re.MULTILINE):
            declared[match.group(1)] = " ".join(match.group(0).split())
    found = pages()
    assert set(found) == set(declared)
    for name, page in found.items():
        assert "**Synopsis** `%s`" % declared[name] in page
        for part in ("**Description** ", "**Returns** ", "**Errors** ", "**Example**"):
            assert part in page


def test_the_examples_on_the_pages_compile(tmp_path):
    types = ("decoder", "supervisor", "limits", "choice", "drive", "route", "wheels", "commands", "info")
    names = {"supervisor": "camera"}
    lines = ["#include <string.h>"]
    lines += ['#include "%s"' % path.name for path in sorted(LIBRARY.glob("larics*.h"))]
    lines += ["static larics_%s %s;" % (kind, names.get(kind, kind)) for kind in types]
    lines += ["static larics_message message;", "static larics_drive_limits drive_limits;"]
    lines += ["static uint8_t frame[LARICS_MAX_FRAME], byte;", "static uint16_t sequence, workspace[8];"]
    lines += ["static const uint16_t ids[] = {3, 4, 7, 3};", "static int32_t x, values[8];"]
    lines += ["static const larics_map_marker map[] = {{3, 0, 0}, {4, 2000, 0}, {7, 2000, 2000}};"]
    lines += ["static uint16_t entries[4];", "static uint32_t costs[3];"]
    lines += ["static uint32_t now_ms;", "static size_t size;", "int main(void)", "{"]
    lines += [re.search(r"```c\n(.*?)\n```", page, re.DOTALL).group(1) for page in pages().values()]
    lines += ["    (void)x; (void)size; (void)message; (void)byte; (void)frame; (void)drive_limits;"]
    source = tmp_path / "examples.c"
    source.write_text("\n".join([*lines, "    return 0;", "}"]))
    flags = [flag for flag in STRICT if not flag.endswith("conversion")]
    unused = ["-Wno-unused-variable", "-Wno-unused-const-variable"]
    command = ["gcc", *flags, *unused, "-fsyntax-only", "-I", str(LIBRARY), str(source)]
    subprocess.run(command, check=True)


def test_the_tests_that_the_failure_classes_name_exist():
    text = (FOLDER / "README.md").read_text()
    named = set(re.findall(r"`(test_\w+)`", text))
    here = "".join(path.read_text() for path in Path(__file__).parent.glob("test_*.py"))
    assert len(named) > 8 and named <= set(re.findall(r"^def (test_\w+)", here, re.MULTILINE))


def test_the_states_in_the_readme_are_those_of_the_header():
    header = (LIBRARY / "larics_supervisor.h").read_text()
    states = re.findall(r"^#define LARICS_(\w+) (\d+) +/\*", header, re.MULTILINE)
    order = [name for name, number in sorted(states, key=lambda state: int(state[1])) if name != "BOOTS"]
    table = (FOLDER / "README.md").read_text().split("## States")[1].split("## ")[0]
    assert re.findall(r"^\| ([A-Z_]+) \|", table, re.MULTILINE) == order
    assert [word.upper().replace(" ", "_") for word in STATES] == order
