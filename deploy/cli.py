"""The `ommatidia` command. Exit code 0: done; 2: usage or configuration error, one line on stderr; 130: interrupted.

What a command needs is imported inside it, so that a robot with the light extra can start its agent.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Literal, NoReturn

import typer

from deploy.calibrate_command import app as calibrate
from deploy.unwinding import INTERRUPTED, unwind_on_signals
from protocol.errors import OmmatidiaError
from protocol.settings import ENDPOINT_FORM

BAD_USAGE = 2

app = typer.Typer(
    help="A swarm of small robots that look straight down and map a room together.",
    epilog="Examples:\n\nommatidia demo\n\nommatidia replay RECORDING --out runs/first\n\nommatidia evaluate runs/first --truth RECORDING",
    add_completion=False,
    pretty_exceptions_enable=False,
)
config_app = typer.Typer(help="Settings files.", no_args_is_help=True)
app.add_typer(config_app, name="config")
app.add_typer(calibrate, name="calibrate")


def _endpoint(text: str) -> str:
    """Return where a map server listens, told as tcp/HOST:PORT."""
    if re.fullmatch(ENDPOINT_FORM, text) is None:
        raise typer.BadParameter(f"{text!r} is no endpoint: say tcp/HOST:PORT, such as tcp/192.168.1.20:7447")
    return text


RecordingFolder = Annotated[Path, typer.Argument(metavar="RECORDING", help="Folder that holds robots.yaml.", show_default=False)]
OutFolder = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Folder for the run; runs/<recording>-<time> if not given.", show_default=False)
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace a run that lies in DIR.")]
Robots = Annotated[
    list[str] | None, typer.Argument(metavar="ROBOT", help="Robots; the map server and all robots if none is named.", show_default=False)
]
Endpoint = Annotated[
    str, typer.Option(metavar="E", parser=_endpoint, help="Where the map server listens, as tcp/HOST:PORT.", show_default=False)
]
Site = Annotated[str, typer.Option(metavar="S", help="The swarm's site.")]
Reason = Annotated[str, typer.Option(metavar="TEXT", help="Why, in one line; every robot tells it.", show_default=False)]
ConfigFile = Annotated[Path, typer.Option(metavar="FILE", help="Settings, as TOML.", show_default=False)]


def _rate(text: str) -> float:
    """Return how fast to play: 1.0 is the recorded pace, infinity as fast as it goes."""
    try:
        rate = math.inf if text == "max" else float(text)
    except ValueError:
        rate = math.nan
    if not rate > 0.0 or (math.isinf(rate) and text != "max"):
        raise typer.BadParameter(f"{text!r} is neither 'max' nor a number above 0")
    return rate


@app.callback(invoke_without_command=True)
def _common(
    context: typer.Context,
    show_version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    if show_version:
        print(f"ommatidia {_version()}")
    elif context.invoked_subcommand is None:
        print(context.get_help())


@app.command(
    epilog="Examples:\n\nommatidia replay RECORDING\n\nommatidia replay RECORDING --out runs/paper --method paper --rate max"
    "\n\nommatidia replay --format mrclam DIR --rate max --loss 0.2 --seed 1"
    "\n\nommatidia replay RECORDING --unknown-starts others"
)
def replay(
    recording: RecordingFolder,
    out: OutFolder = None,
    method: Annotated[
        Literal["full", "paper"],
        typer.Option(help="full: our best; paper: the paper's own, once with its lens, once with the calibrated one."),
    ] = "full",
    rate: Annotated[
        float, typer.Option(metavar="1.0|max", parser=_rate, help="1.0: at the recorded pace; max: as fast as it goes, no frame skipped.")
    ] = 1.0,
    form: Annotated[
        Literal["recording", "mrclam"],
        typer.Option("--format", help="recording: cameras and wheels; mrclam: a folder of the UTIAS multi-robot data set."),
    ] = "recording",
    loss: Annotated[
        float, typer.Option(min=0.0, max=0.95, metavar="P", help="Probability with which a local map, or poses, are lost on their way.")
    ] = 0.0,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Of the losses: the same ones with the same seed.")] = 0,
    unknown_starts: Annotated[
        Literal["none", "others", "all"],
        typer.Option(help="Withhold where robots start: of all, or of all but the first; they have to find their places."),
    ] = "none",
    overwrite: Overwrite = False,
) -> None:
    """Map a recording: real agents and a map server, over Zenoh, on this machine."""
    from rich.console import Console

    from deploy.replay_command import Wishes, replay_recording
    from mapserver.config import LossSettings

    losses = LossSettings(share=loss, seed=seed)
    replay_recording(Wishes(recording, form, out, method, rate, unknown_starts, losses, overwrite), Console())


@app.command(epilog="Examples:\n\nommatidia evaluate runs/first --truth RECORDING")
def evaluate(
    run: Annotated[Path, typer.Argument(metavar="DIR", help="Folder that a run has left.", show_default=False)],
    truth: Annotated[Path, typer.Option(metavar="RECORDING", help="The recording, with its ground_truth/.", show_default=False)],
    ablation: Annotated[bool, typer.Option("--ablation", help="Go through the recording again, with more and more of the method.")] = False,
) -> None:
    """Judge a run: the paper's tables and figures, beside the paper's own numbers."""
    from rich.console import Console

    from deploy.evaluate_command import evaluate_run

    evaluate_run(run, truth, Console(), ablates=ablation)


@app.command(
    epilog="Examples:\n\nommatidia demo\n\nommatidia demo --robots 6 --seed 7\n\nommatidia demo --scenario passer_by --record recorded"
)
def demo(
    robots: Annotated[int, typer.Option(min=1, max=12, help="How many, in a random arena.")] = 3,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Of the random arena: each has another one.")] = 2,
    duration: Annotated[
        float | None, typer.Option(min=1.0, metavar="S", help="Seconds of world time at most; as the scenario says if not given.")
    ] = None,
    scenario: Annotated[str | None, typer.Option(metavar="FILE", help="A scenario, by file or name, in place of a random arena.")] = None,
    record: Annotated[Path | None, typer.Option(metavar="DIR", help="Keep frames, wheels and truth there, as a recording.")] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Show no progress.")] = False,
    out: OutFolder = None,
    overwrite: Overwrite = False,
) -> None:
    """Show it all: a simulated swarm drives in formation through an arena, maps it, and is judged."""
    from rich.console import Console

    from deploy.demo import Wishes
    from deploy.demo import demo as show

    show(Wishes(robots, seed, duration, scenario, record, out, overwrite, headless), Console())


@app.command(epilog="Examples:\n\nommatidia agent --config /etc/ommatidia/agent.toml")
def agent(
    config: ConfigFile,
    clock: Annotated[
        str, typer.Option(metavar="KEY=NUMBER,...", help="Go by a bad clock, to try one out: offset_s, drift_ppm, step_s, step_at_s.")
    ] = "",
) -> None:
    """Run a robot: from its camera and wheels to local maps."""
    from agent.__main__ import run_agent

    raise typer.Exit(run_agent(config, clock))


@app.command(epilog="Examples:\n\nommatidia mapserver --config /etc/ommatidia/mapserver.toml")
def mapserver(config: ConfigFile) -> None:
    """Run the map server: from local maps to one map and everybody's pose."""
    from mapserver.__main__ import run

    run(config)


@app.command(epilog="Examples:\n\nommatidia stop --endpoint tcp/192.168.1.20:7447\n\nommatidia stop r2 r3 --endpoint E --reason 'a cat'")
def stop(endpoint: Endpoint, robots: Robots = None, site: Site = "home", reason: Reason = "") -> None:
    """Stop robots, whatever else they are told, until they are released."""
    from deploy.stop_command import order_stop

    order_stop("stop", robots or [], endpoint, site, reason, print)


@app.command(epilog="Examples:\n\nommatidia release --endpoint tcp/192.168.1.20:7447\n\nommatidia release r2 --endpoint E")
def release(endpoint: Endpoint, robots: Robots = None, site: Site = "home", reason: Reason = "") -> None:
    """Release stopped robots: they follow the next setpoint."""
    from deploy.stop_command import order_stop

    order_stop("release", robots or [], endpoint, site, reason, print)


@app.command(epilog="Examples:\n\nommatidia doctor\n\nommatidia doctor --push\n\nommatidia doctor --config agent.toml --json")
def doctor(
    config: Annotated[Path, typer.Option(metavar="FILE", help="The robot's settings, as TOML.")] = Path("/etc/ommatidia/agent.toml"),
    as_json: Annotated[bool, typer.Option("--json", help="Say it as one JSON list.")] = False,
    push: Annotated[bool, typer.Option("--push", help="Ask for a push of the robot, to see both encoders turn.")] = False,
) -> None:
    """Say what is wrong with a robot: cause and next step of each part that fails. Exit code 1 where one does."""
    from agent.doctor.diagnosis import diagnose
    from deploy.doctor_command import tell_as_json, tell_findings

    raise typer.Exit((tell_as_json if as_json else tell_findings)(diagnose(config, _ask if push else None), print))


@config_app.command(
    epilog="Examples:\n\nommatidia config check /etc/ommatidia/agent.toml\n\nommatidia config check mine.toml --role scenario"
)
def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Settings, as TOML.", show_default=False)],
    role: Annotated[
        Literal["agent", "mapserver", "scenario"] | None,
        typer.Option(help="Whose settings they are to be; told from the file if not given.", show_default=False),
    ] = None,
) -> None:
    """Say whether a settings file can be used; if not, what is wrong, where, and what to do."""
    from deploy.config_command import check_config

    check_config(file, role, print)


def _ask(what: str) -> None:
    """Ask a person for something, beside whatever is said on stdout."""
    print(what, file=sys.stderr)


def main() -> NoReturn:
    """Run the command line and exit."""
    unwind_on_signals()
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit code; whatever stops it becomes one line on stderr."""
    try:
        code = app(list(arguments), prog_name="ommatidia", standalone_mode=False) or 0
    except typer.TyperException as error:
        return _complain(f"{error.format_message().rstrip('.')}; try --help", BAD_USAGE)
    except OmmatidiaError as error:
        return _complain(str(error), BAD_USAGE)
    except ModuleNotFoundError as error:
        return _complain(f"the package {error.name} is not installed: pip install 'ommatidia[agent,mapserver,sim]'", BAD_USAGE)
    except OSError as error:
        return _complain(f"{error.filename}: {error.strerror}" if error.filename else str(error), BAD_USAGE)
    return _complain("interrupted", INTERRUPTED) if code == INTERRUPTED else int(code)


def _complain(problem: str, code: int) -> int:
    """Say what is wrong in exactly one line, and return the exit code."""
    print(f"ommatidia: {' '.join(problem.split())}", file=sys.stderr)
    return code


def _version() -> str:
    try:
        return version("ommatidia")
    except PackageNotFoundError:
        return "(not installed)"
