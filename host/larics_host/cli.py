"""The command `larics`: finds the sub-command, runs it, and turns bad input into one line.

A sub-command is a module `larics_host.commands.<name>` with

    NAME = "marker"                 what the user types
    HELP = "..."                    one line, for `larics --help`
    EXAMPLE = "larics marker ..."   one or more lines, for `larics marker --help`
    def add_arguments(parser)       argparse
    def run(args) -> int            the exit code; UserError for bad input

Only the module of the command in use is imported, so a missing optional dependency hurts that command
alone. `larics --help` imports them all: keep slow imports inside `run`.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import logging
import os
import sys
from collections.abc import Sequence

from larics import __version__
from larics_host.errors import EXIT_INTERRUPTED, UserError, begin_run, missing_package, report

COMMANDS = (
    "marker",
    "detect",
    "camera",
    "validate",
    "monitor",
    "log",
    "replay",
    "record",
    "ros2",
    "settings",
    "calibrate",
    "map",
    "fleet",
    "simulate",
    "flash",
    "traceback",
)

EXIT_BAD_INPUT = 2
EXIT_BROKEN_PIPE = 141


class _Parser(argparse.ArgumentParser):
    """argparse with the same one-line errors as everything else."""

    def error(self, message):
        raise UserError("%s (see %s --help)" % (message, self.prog))

    def _print_message(self, message, file=None):
        if message:  # argparse would not notice that nobody reads it
            (file or sys.stderr).write(message)


def _missing_package(error, who):
    """The UserError for a package that is not installed; raises `error` again when it is one of ours."""
    missing = (error.name or "").split(".")[0]
    if missing in ("", "larics", "larics_host"):
        raise error
    return missing_package(who, missing)


def _load(name):
    """The module of a sub-command. Raises UserError when a package it needs is not installed."""
    try:
        return importlib.import_module("larics_host.commands." + name)
    except ModuleNotFoundError as error:
        raise _missing_package(error, "larics " + name) from error


def _add_command(commands, name):
    module = _load(name)
    parser = commands.add_parser(
        module.NAME,
        help=module.HELP,
        description=module.HELP,
        epilog="example:\n" + "\n".join("  " + line for line in module.EXAMPLE.strip().splitlines()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    module.add_arguments(parser)
    parser.set_defaults(run=module.run)


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """The parser with all sub-commands, or with the one named `only`."""
    parser = _Parser(
        prog="larics",
        description="Printed ceiling markers as a localization sensor for indoor robots.",
        epilog="`larics COMMAND --help` shows the options of a command with an example.",
    )
    parser.add_argument("--version", action="version", version="larics " + __version__)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name in [only] if only else COMMANDS:
        try:
            _add_command(commands, name)
        except UserError as error:
            if only:
                raise
            commands.add_parser(name, help="(not usable: %s)" % error)
    return parser


def _have_streams():
    """Closed standard output fails as one whose reader has gone, with exit code 141."""
    if sys.stdout is None:
        reader, writer = os.pipe()
        if writer != 1:
            os.dup2(writer, 1)  # or a file that is opened later gets what other programs print
            os.close(writer)
        if reader != 1:
            os.close(reader)
        sys.stdout = open(1, "w", errors="backslashreplace", closefd=False)  # noqa: SIM115 (to the end)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115 (to the end)


def _print_anything():
    # a file name that the terminal's encoding cannot show must not end the program
    if getattr(sys.stdout, "errors", None) == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")


def _leave_output():
    # nobody takes our output any more; the interpreter must not complain when it flushes at exit
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            with contextlib.suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command line; returns the exit code (2 for bad input, 130 when interrupted, 141 when nobody
    takes its output)."""
    argv = sys.argv[1:] if argv is None else list(argv)
    _have_streams()
    _print_anything()
    begin_run()
    # it tells at length of a home that it cannot write, also when another package brings it
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        try:
            code = _run(argv)
        finally:
            sys.stdout.flush()  # after --help, too
        return code
    except BrokenPipeError:
        return EXIT_BROKEN_PIPE
    except OSError as error:
        # a full disk behind standard output, or what no command foresaw
        with contextlib.suppress(OSError):
            where = error.filename or "cannot write to standard output"
            report("%s: %s" % (where, error.strerror) if error.strerror else error)
        return EXIT_BAD_INPUT
    finally:
        _leave_output()


def _run(argv):
    try:
        args = build_parser(argv[0] if argv and argv[0] in COMMANDS else None).parse_args(argv)
        return args.run(args) or 0
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except UserError as error:
        report(error)
    except ModuleNotFoundError as error:
        report(_missing_package(error, "this"))
    return EXIT_BAD_INPUT
