"""Puts into a wheel what lies beside the package in a checkout: the sources of firmware and board."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
BESIDE = ("firmware", "shared")  # as larics_host.sources looks for them


class BuildWithSources(build_py):
    def run(self):
        super().run()
        if self.editable_mode:
            return
        for name in BESIDE:
            target = Path(self.build_lib) / "larics_host" / "board" / name
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(
                ROOT / name, target, ignore=shutil.ignore_patterns("__pycache__", "*.pyc", "build")
            )


setup(cmdclass={"build_py": BuildWithSources})
