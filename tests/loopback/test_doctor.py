"""The doctor beside a real map server: who answers, whom it knows, and what is said where nobody does."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from protocol.bus import Bus
from tests.loopback.agent_files import SENSOR
from tests.loopback.conftest import Ommatidia

ROOT = Path(__file__).parents[2]
SETTINGS = """
[robot]
name = "{name}"
endpoint = "{endpoint}"
[camera]
endpoint = "{endpoint}"
calibration = "sensor.yaml"
[wheels]
endpoint = "{endpoint}"
"""

Parts = dict[str, dict[str, str]]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[str]:
    """Yield the endpoint of a running map server that knows r1."""
    (tmp_path / "mapserver.toml").write_text('[[robots]]\nname = "r1"\n')
    command = [sys.executable, "-m", "mapserver", "--config", str(tmp_path / "mapserver.toml")]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        yield process.stdout.readline().split()[1]
        process.terminate()


def examined(ommatidia: Ommatidia, folder: Path, endpoint: str, name: str = "r1") -> tuple[int, Parts]:
    """Return the doctor's exit code and its last finding on each part."""
    (folder / "agent.toml").write_text(SETTINGS.format(name=name, endpoint=endpoint))
    (folder / "sensor.yaml").write_text(SENSOR)
    said = ommatidia("doctor", "--config", folder / "agent.toml", "--json")
    return said.returncode, {finding["part"]: finding for finding in json.loads(said.stdout)}


def test_a_robot_that_its_map_server_knows_passes(ommatidia: Ommatidia, tmp_path: Path, server: str) -> None:
    code, parts = examined(ommatidia, tmp_path, server)
    assert code == 0
    assert parts["map server"]["seen"] == "knows r1, and has 0 local maps from it"
    assert parts["clock"]["verdict"] == "good"
    assert parts["certificate"]["verdict"] == "warning"


def test_a_robot_that_its_map_server_does_not_know_is_told_what_to_add(ommatidia: Ommatidia, tmp_path: Path, server: str) -> None:
    code, parts = examined(ommatidia, tmp_path, server, name="r9")
    assert code == 1
    assert parts["map server"]["cause"] == "r9 is not among its robots"
    assert "[[robots]]" in parts["map server"]["next_step"]


def test_a_port_where_nobody_listens_is_told(ommatidia: Ommatidia, tmp_path: Path) -> None:
    with closing(socket.socket()) as unused:
        unused.bind(("127.0.0.1", 0))
        code, parts = examined(ommatidia, tmp_path, f"tcp/127.0.0.1:{unused.getsockname()[1]}")
    assert code == 1
    assert parts["link"]["cause"] == "Connection refused"


def test_a_router_without_a_map_server_is_told(ommatidia: Ommatidia, tmp_path: Path) -> None:
    with Bus.open_router("elsewhere") as router:
        code, parts = examined(ommatidia, tmp_path, router.endpoint)
    assert code == 1
    assert parts["map server"]["cause"] == "another site, or another program"


def test_a_person_reads_one_line_a_part_with_cause_and_next_step(ommatidia: Ommatidia, tmp_path: Path) -> None:
    said = ommatidia("doctor", "--config", tmp_path / "agent.toml")
    assert said.returncode == 1
    assert said.stdout.startswith(f"FAILED   settings: cannot be used\n           cause: {tmp_path}/agent.toml: cannot be read")
