"""`planetfall bench` and `planetfall stress`: options, progress, tables, files. planetfall/cli/main.py calls them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ..errors import SettingError
from .cli_against import AgainstOptions, run_against
from .document import document as write_document
from .front import ALTERNATIVES
from .peer_results import PEERS, read_peer_results, runs_of_peer
from .plots import MISSING, save_plots
from .schema import Extent, Report, read_report
from .session import Bench, Session
from .stability import stability
from .store import document_path, read_reports, results_root, save_report, stability_path
from .stress import STRESS_SUITES, replay_file, run_sweep, usual_count
from .suites import SUITES, benches_of, choose
from .tables import show_comparison, show_report

EXIT_FAILED = 1

_Output = Annotated[Path | None, Parameter(help="Folder for results; in a checkout benchmarks/results if left out.")]

_NOT_AGAINST = AgainstOptions()


def bench_main(arguments: Sequence[str]) -> int:
    """`planetfall bench ...`; returns the exit code: 1 when a bench could not run."""
    return _run(_bench, "bench", "Measure run time beside error, suite by suite.", arguments)


def stress_main(arguments: Sequence[str]) -> int:
    """`planetfall stress ...`; returns the exit code: 1 when a case failed."""
    return _run(_stress, "stress", "Seeded sweeps for the worst case of a suite.", arguments)


def _run(command: Callable[..., int], name: str, about: str, arguments: Sequence[str]) -> int:
    app = App(name=f"planetfall {name}", help=about, version_flags=[])
    app.default(command)
    code = app(list(arguments), exit_on_error=False, print_error=False, result_action="return_value")
    return code if isinstance(code, int) else 0


def _bench(
    *suites: str,
    quick: Annotated[
        bool, Parameter(negative="", help="Without what takes long: five minutes for all suites; saved apart.")
    ] = False,
    full: Annotated[
        bool, Parameter(negative="", help="More runs, larger samples and pictures: hours; saved apart.")
    ] = False,
    output: _Output = None,
    save: Annotated[bool, Parameter(help="Write the results to files.")] = True,
    compare: Annotated[
        tuple[Path, Path] | None,
        Parameter(negative="", help="Two results files, or two folders of them: nothing is run."),
    ] = None,
    document: Annotated[
        bool, Parameter(negative="", help="Write docs/benchmarks.md and tables.md of each device: nothing is run.")
    ] = False,
    plot: Annotated[
        Path | None, Parameter(help="A results file or a folder of them: their plots are drawn beside, nothing is run.")
    ] = None,
    list_: Annotated[bool, Parameter(name="--list", negative="", help="Name the suites and their benches.")] = False,
    peer_results: Annotated[
        Path | None,
        Parameter(help="Folder of what a browser's sky and clouds took here: suite peers compares with it."),
    ] = None,
    against: AgainstOptions = _NOT_AGAINST,
) -> int:
    """Measure run time beside error, suite by suite.

    Parameters
    ----------
    suites
        Suites (--list names them) or single benches (terrain.normals); all if left out. With --against, cases.
    """
    console = Console()
    if list_:
        for suite, benches in choose(suites).items():
            console.print(f"[bold]{suite}[/]  {SUITES[suite]}", highlight=False)
            console.print(f"  {', '.join(benches)}", highlight=False)
        return 0
    if compare is not None:
        return _compare(*compare, console)
    if document:
        root = output or results_root()
        console.print(f"written: {write_document(root, document_path(root))}", highlight=False, soft_wrap=True)
        return 0
    if plot is not None:
        return _plot(plot, console)
    if against.given():
        if quick or full:
            raise SettingError("bench: --quick and --full are about suites; leave them out with --against")
        return 0 if run_against(against, suites, console, _progress) else EXIT_FAILED
    if quick and full:
        raise SettingError("bench: --quick and --full exclude each other; leave one out")
    extent: Extent = "quick" if quick else "full" if full else "usual"
    failed = False
    chosen = _with_peers(choose(suites, quick), peer_results, named=bool(suites), console=console)
    for suite, benches in chosen.items():
        whole = choose([suite], quick)[suite]
        left_out = [name for name in benches_of(suite) if name not in benches] if benches.keys() == whole.keys() else []
        with Session(suite, extent, peer_results) as session, _progress(suite) as progress:
            report = session.run(benches, progress, left_out)
        show_report(report, console)
        failed = failed or bool(report.skipped)
        if save and (output is not None or benches.keys() == whole.keys()):
            _save(report, output or results_root(), console)
        elif save:
            console.print("not saved: only a part of the suite was run; --output FOLDER saves it there", style="dim")
    return EXIT_FAILED if failed else 0


def _stress(
    suite: Annotated[
        str, Parameter(help="One of space, terrain, atmosphere, clouds, ocean, frame, descent, compare.")
    ] = "",
    /,
    *,
    seed: Annotated[int, Parameter(help="Case k of a seed is always the same.")] = 1,
    count: Annotated[int | None, Parameter(help="How many cases; left out, as many as the suite says.")] = None,
    replay: Annotated[Path | None, Parameter(help="A failing case's file: run that case alone.")] = None,
    output: _Output = None,
    save: Annotated[bool, Parameter(help="Write the results and the failing cases to files.")] = True,
    document: Annotated[
        bool, Parameter(negative="", help="Write docs/numerical-stability.md from the results of compare.")
    ] = False,
) -> int:
    """Seeded sweeps for the worst case of a suite; every failing case is saved and can be replayed."""
    console = Console()
    root = output or results_root()
    if document:
        console.print(f"written: {stability(root, stability_path(root))}", highlight=False, soft_wrap=True)
        return 0
    if replay is not None:
        report = replay_file(replay)
        show_report(report, console)
        return EXIT_FAILED if report.failures else 0
    if not suite:
        raise SettingError(f"stress: name a suite: {', '.join(STRESS_SUITES)}; or --replay FILE")
    count = usual_count(suite) if count is None else count
    if count < 1:
        raise SettingError(f"--count must be at least 1, found {count}")
    with _progress(suite) as progress:
        report = run_sweep(suite, seed, count, root if save else None, progress)
    if output is None and count < usual_count(suite):
        report.extent = "quick"  # beside a whole sweep's results, not in their place
    show_report(report, console)
    if save:
        console.print(f"written: {save_report(report, root)}", highlight=False, soft_wrap=True)
    return EXIT_FAILED if report.failures or report.skipped else 0


def _with_peers(
    chosen: dict[str, Mapping[str, Bench]], folder: Path | None, named: bool, console: Console
) -> dict[str, Mapping[str, Bench]]:
    """The suites to run, once the files are there that suite peers is about. Without a folder only those who name it
    want it."""
    if PEERS not in chosen:
        if folder is not None:
            raise SettingError(f"bench: --peer-results goes with suite {PEERS}; name it as well")
        return chosen
    if folder is None and not named:
        console.print(f"left out: {PEERS}, which needs --peer-results FOLDER", style="dim")
        return {suite: benches for suite, benches in chosen.items() if suite != PEERS}
    wanted = dict.fromkeys(run for bench in chosen[PEERS] for run in runs_of_peer(bench))
    read_peer_results(folder, wanted)
    return chosen


def _save(report: Report, root: Path, console: Console) -> None:
    path = save_report(report, root)
    console.print(f"written: {path}", highlight=False, soft_wrap=True)
    try:
        for plot in save_plots(report, path.parent):
            console.print(f"written: {plot}", highlight=False, soft_wrap=True)
    except ImportError:
        console.print(MISSING, style="dim")


def _plot(place: Path, console: Console) -> int:
    files = sorted(p for p in place.rglob("*.json") if "failures" not in p.parts) if place.is_dir() else [place]
    try:
        made = [plot for file in files for plot in save_plots(read_report(file), file.parent, quick=True)]
    except ImportError as error:
        raise SettingError(f"--plot: {MISSING}") from error
    if not made:
        raise SettingError(f"--plot: {place} has no bench of time against error; those are {', '.join(ALTERNATIVES)}")
    for plot in made:
        console.print(f"written: {plot}", highlight=False, soft_wrap=True)
    return 0


def _compare(old: Path, new: Path, console: Console) -> int:
    before, after = read_reports(old), read_reports(new)
    shared = [name for name in after if name in before]
    if len(before) == len(after) == 1:
        shared = list(after)
        before = {shared[0]: next(iter(before.values()))}
    if not shared:
        raise SettingError(f"--compare: no suite is in both: {', '.join(before)} and {', '.join(after)}")
    for name in shared:
        show_comparison(before[name], after[name], console)
    return 0


@contextmanager
def _progress(suite: str) -> Iterator[Callable[[str, int, int], None]]:
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(suite, total=None)
        yield lambda what, done, of: bar.update(task, description=f"{suite} {what}", completed=done, total=of)
