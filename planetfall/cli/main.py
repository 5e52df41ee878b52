"""The command line `planetfall`: fly, render, record, gallery, new, bench, stress, planets, views, graph.

Errors of the library become one red line on stderr and exit code 2; --debug shows where they came from. PLANETFALL_LOG
sets the log level (debug, info, warning).
"""

from __future__ import annotations

import importlib
import logging
import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import UnusedCliTokensError
from rich.console import Console
from rich.logging import RichHandler
from rich.text import Text

from .._version import __version__
from ..errors import SettingError
from ..expected import expected_errors
from .dataset import dataset_command
from .fly import fly_command
from .gallery import gallery_command
from .info import graph_command, planets_command, views_command
from .map import map_app
from .new import new_command
from .render import record_command, render_command
from .rivers import rivers_command
from .share import share_command

__all__ = ["app", "main"]

EXIT_EXPECTED = 2
EXIT_INTERRUPTED = 130

app = App(
    name="planetfall",
    help="Whole planets: fly from 36 000 km out down to a beach. Every command also takes --debug: full tracebacks, "
    "and --import MODULE: a game's own components, known to scene files and --set from then on.",
    version=__version__,
    suppress_keyboard_interrupt=False,
)
app.command(fly_command, name="fly")
app.command(render_command, name="render")
app.command(record_command, name="record")
app.command(gallery_command, name="gallery")
app.command(dataset_command, name="dataset")
app.command(new_command, name="new")
app.command(planets_command, name="planets")
app.command(views_command, name="views")
app.command(graph_command, name="graph")
app.command(rivers_command, name="rivers")
app.command(map_app, name="map")
app.command(share_command, name="share")

Tokens = Annotated[str, Parameter(show=False, allow_leading_hyphen=True)]


@app.command(name="bench", help_flags=[])
def bench_command(*arguments: Tokens) -> int:
    """Measure run time beside error, suite by suite. See planetfall bench --help."""
    from ..benchmarks import cli

    return cli.bench_main(list(arguments))


@app.command(name="stress", help_flags=[])
def stress_command(*arguments: Tokens) -> int:
    """Seeded sweeps for the worst case of a suite. See planetfall stress --help."""
    from ..benchmarks import cli

    return cli.stress_main(list(arguments))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line; returns the exit code. The console script calls this."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given
    given = [argument for argument in given if argument != "--debug"]
    start_logging("debug" if debug else os.environ.get("PLANETFALL_LOG", "warning"))

    def run() -> object:
        left = import_modules(given)
        return app(left, exit_on_error=False, print_error=False, result_action="return_value")

    return guarded(run, debug)


def import_modules(given: Sequence[str]) -> list[str]:
    """Import what `--import MODULE` names, such as a game that registers components; the other arguments.

    Modules of the current folder are found, as with `python -m`. SettingError for one that can't be imported.
    """
    left: list[str] = []
    arguments = iter(given)
    for argument in arguments:
        option, equals, name = argument.partition("=")
        if option != "--import":
            left.append(argument)
            continue
        name = name if equals else next(arguments, "")
        if not name or name.startswith(("-", ".")):
            raise SettingError(f"--import: expected a module such as games.rings, found {name!r}")
        if os.getcwd() not in sys.path:
            sys.path.insert(0, os.getcwd())
        try:
            importlib.import_module(name)
        except ImportError as error:
            raise SettingError(f"--import {name}: {error}; looked in {os.getcwd()} and where packages are") from error
    return left


def guarded(run: Callable[[], object], debug: bool = False) -> int:
    """Exit code of `run`; the library's own errors, and wrong options, become one red line instead of a traceback."""
    console = Console(stderr=True)
    try:
        code = run()
    except KeyboardInterrupt:
        console.print("stopped")
        return EXIT_INTERRUPTED
    except Exception as error:
        if debug or not isinstance(error, (CycloptsError, *expected_errors())):
            raise
        console.print(Text(f"planetfall: {_said(error)}", style="red"), soft_wrap=True)
        return EXIT_EXPECTED
    return code if isinstance(code, int) else 0


def _said(error: Exception) -> str:
    if isinstance(error, UnusedCliTokensError):
        stray = " ".join(error.unused_tokens or ())
        again = f"; each takes its own --set: --set {stray.split()[0]}" if "=" in stray else ""
        return f"nothing takes {stray!r}{again}"
    return str(error)


def start_logging(level: str) -> None:
    """Warnings of the library on stderr, in the terminal's colours."""
    number = logging.getLevelName(level.upper())
    logger = logging.getLogger("planetfall")
    if not any(isinstance(handler, RichHandler) for handler in logger.handlers):
        logger.addHandler(RichHandler(console=Console(stderr=True), show_time=False, show_path=False))
    logger.setLevel(number if isinstance(number, int) else logging.WARNING)
    if not isinstance(number, int):
        logger.warning("PLANETFALL_LOG: expected debug, info, warning or error, found %r", level)
