"""The installation into a fresh Debian: what a board needs to run an agent is there, twice in a row without harm, and goes again."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
UNIT = "ommatidia-agent.service"
BUILT_WITH = ("setuptools", "wheel")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(900),
    pytest.mark.skipif(os.geteuid() != 0, reason="only root can make an image"),
    pytest.mark.skipif(shutil.which("debootstrap") is None, reason="debootstrap is not installed"),
]

Install = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a fresh Debian; its mirror may be out of reach, which is not the installation's fault."""
    folder = tmp_path_factory.mktemp("image")
    run_or_skip("debootstrap", "--variant=minbase", "--include=python3,python3-venv,systemd,udev", "bookworm", str(folder))
    return folder


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all Python packages of an agent, in the versions of the lock."""
    folder = tmp_path_factory.mktemp("wheels")
    versions = folder / "versions"
    versions.write_text("\n".join(re.findall(r"^[\w.-]+==[^ ;\\]+", (ROOT / "requirements.lock").read_text(), flags=re.MULTILINE)))
    needed = [*BUILT_WITH, "--constraint", str(versions), f"{ROOT}[agent]"]
    run_or_skip(sys.executable, "-m", "pip", "wheel", "--quiet", "--wheel-dir", str(folder), "--prefer-binary", *needed)
    return folder


@pytest.fixture(scope="module")
def install(image: Path, wheels: Path) -> Install:
    """Return a function that runs the installer on the image with further arguments."""

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [str(ROOT / "deploy" / "install.sh"), "--root", str(image), "--wheels", str(wheels), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    return run


def test_an_agent_is_installed_twice_without_harm_and_removed(image: Path, install: Install) -> None:
    first = install("agent", "--name", "r7", "--server", "tcp/10.0.0.5:7447")
    assert first.returncode == 0, first.stderr
    settings = image / "etc/ommatidia/agent.toml"
    assert 'name = "r7"' in settings.read_text()
    settings.write_text(settings.read_text() + "\n# mine\n")

    again = install("agent", "--name", "r8")
    assert again.returncode == 0, again.stderr
    assert settings.read_text().endswith("# mine\n")

    checked = inside(image, "ommatidia", "config", "check", "/etc/ommatidia/agent.toml")
    assert "agent of robot r7" in checked.stdout
    verified = subprocess.run(["systemd-analyze", f"--root={image}", "verify", UNIT], capture_output=True, text=True, check=False)
    assert verified.stderr == ""
    assert (image / "etc/systemd/system/multi-user.target.wants" / UNIT).is_symlink()

    removed = install("--uninstall", "--purge")
    assert removed.returncode == 0, removed.stderr
    left = {path for path in image.rglob("*ommatidia*") if not path.is_relative_to(image / "proc")}
    assert left == set()


def test_a_folder_that_is_no_debian_is_refused_in_one_line(tmp_path: Path) -> None:
    refused = subprocess.run([str(ROOT / "deploy" / "install.sh"), "--root", str(tmp_path)], capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert refused.stderr == f"install.sh: {tmp_path} is no Debian and no Raspberry Pi OS: /etc/debian_version is missing\n"


def run_or_skip(*command: str) -> None:
    """Run what needs a registry, and skip the test, with the last thing it said, where that is out of reach."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode:
        pytest.skip(f"{command[0]} failed: {done.stdout.strip().splitlines()[-1]}")


def inside(image: Path, *command: str) -> subprocess.CompletedProcess[str]:
    """Run a command in the image."""
    return subprocess.run(["chroot", str(image), *command], capture_output=True, text=True, check=False)
