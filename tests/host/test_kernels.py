"""Every kernel gives the same bytes under numba, plain and strict CPython and a real MicroPython."""

import ast
import os
import pathlib
import subprocess
import sys

import pytest

from tests.host.test_dual import interpreter

ROOT = pathlib.Path(__file__).resolve().parents[2]
KERNELS = ROOT / "shared" / "larics" / "kernels"
CASES = ROOT / "tests" / "kernels"
EXECUTORS = ("numba", "plain", "strict", "micropython")
LARGEST = 1 << 30  # the house rule: a factor of two below the int32 limit


def kernels_of(path):
    """Names of the viper functions in a module."""
    return [
        node.name
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.FunctionDef)
        and "micropython.viper" in [ast.unparse(decorator) for decorator in node.decorator_list]
    ]


MODULES = {path.stem: kernels_of(path) for path in sorted(KERNELS.glob("*.py")) if path.stem != "__init__"}
ALL = sorted("%s.%s" % (module, name) for module, names in MODULES.items() for name in names)


def kernels_with_inputs():
    """Names in CASES of each tests/kernels/cases_<module>.py."""
    found = []
    for path in sorted(CASES.glob("cases_*.py")):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "CASES":
                found += ["%s.%s" % (path.stem[6:], ast.literal_eval(key)) for key in node.value.keys]
    return sorted(found)


TESTED = kernels_with_inputs()


def execute(executor, script, *arguments):
    """Runs a script of tests/kernels under an executor; returns the completed process."""
    if executor == "micropython":
        command = [*interpreter(), "-X", "heapsize=48m"] if len(interpreter()) == 1 else interpreter()
        environment = dict(os.environ, MICROPYPATH="shared:tests/kernels:tests/dual:.frozen")
    else:
        command = [sys.executable]
        environment = dict(os.environ, PYTHONPATH="shared:tests/kernels:tests/dual", LARICS_KERNELS=executor)
    return subprocess.run(
        [*command, str(CASES / script), *arguments],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture(scope="module")
def outputs():
    """executor -> kernel -> its lines."""
    tested = sorted(path.stem[6:] for path in CASES.glob("cases_*.py"))
    found = {}
    for executor in EXECUTORS:
        process = execute(executor, "run.py", *tested)
        assert process.stdout, "%s: %s" % (executor, process.stderr)
        found[executor] = lines = {}
        for line in process.stdout.splitlines():
            kernel = line.split()[1] if line.startswith("peak") else line.split()[0]
            lines.setdefault(kernel, []).append(line)
    return found


def first_difference(kernel, number, executor):
    """The arguments of a call after it, where the two executors differ."""
    dumps = [execute(name, "run.py", "--dump", kernel, str(number)).stdout for name in ("plain", executor)]
    for one, other in zip(dumps[0].splitlines(), dumps[1].splitlines(), strict=False):
        if one != other:
            at = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), 0)
            start = max(0, at - 60)
            return "%s\n  plain: ...%s\n  %s: ...%s" % (
                one[:12],
                one[start : at + 60],
                executor,
                other[start : at + 60],
            )
    return "%s\n%s" % tuple(dumps)


def test_kernels_are_found():
    assert len(ALL) > 10


def test_every_kernel_has_inputs():
    """A new kernel needs an entry in CASES of tests/kernels/cases_<module>.py."""
    assert TESTED == ALL


@pytest.mark.parametrize("executor", [name for name in EXECUTORS if name != "plain"])
@pytest.mark.parametrize("kernel", TESTED)
def test_executors_agree(outputs, kernel, executor):
    def calls(name):
        return [line for line in outputs[name].get(kernel, []) if not line.startswith("peak")]

    expected = calls("plain")
    assert len(expected) >= 3, "too few inputs: %s" % expected
    assert not [line for line in expected if "FAILED" in line]
    if calls(executor) != expected:
        pairs = list(zip(expected, calls(executor), strict=False))
        number = next((i for i, (one, other) in enumerate(pairs) if one != other), len(pairs))
        if number == len(pairs) or "FAILED" in pairs[number][1]:
            pytest.fail("%s: %s" % (executor, calls(executor)[-1:]))
        pytest.fail("call %d: %s" % (number, first_difference(kernel, number, executor)))


@pytest.mark.parametrize("kernel", TESTED)
def test_intermediates_keep_a_factor_of_two_below_int32(outputs, kernel):
    (line,) = [line for line in outputs["strict"][kernel] if line.startswith("peak")]
    assert int(line.split()[2]) <= LARGEST


def test_no_frame_overflows_a_whole_detector(tmp_path):
    """Extreme frames through the detectors: the strict executor raises nothing, and all executors agree."""
    frames = str(tmp_path / "frames")
    assert execute("plain", "detectors.py", "--make", frames).returncode == 0
    expected = execute("strict", "detectors.py", frames, "paper", "detector")
    assert expected.returncode == 0, expected.stderr
    lines = expected.stdout.splitlines()
    for name in ("paper", "detector"):
        own = [line for line in lines if line.startswith(name)]
        assert len(own) >= 20 and len([line for line in own if "Detection(" in line]) >= 3
    for executor in ("numba", "plain", "micropython"):
        found = execute(executor, "detectors.py", frames, "paper", "detector")
        assert found.stdout == expected.stdout, executor


def test_golden_frames_give_the_same_detections():
    """Of both methods: compiled by numba and by MicroPython on all frames, interpreted on small ones."""
    files = sorted(str(path) for path in (ROOT / "tests" / "frames").glob("*.pgm"))
    small = [file for file in files if "_r16_" in file]
    assert len(files) >= 30 and len(small) >= 3
    outputs = [execute(executor, "golden.py", *files) for executor in ("numba", "micropython")]
    assert outputs[0].stdout.count("Detection(") >= len(files), outputs[0].stderr
    assert outputs[1].stdout == outputs[0].stdout
    expected = [line for line in outputs[0].stdout.splitlines() if "_r16_" in line]
    assert execute("plain", "golden.py", *small).stdout.splitlines() == expected
    assert execute("strict", "golden.py", *small[:2]).stdout.splitlines() == expected[:4]
