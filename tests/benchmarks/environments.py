"""Environments in which releases are measured beside each other, and what is run in them."""

import json
import os
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
CALLS = Path(__file__).with_name("calls.py")
NO_SUCH_COMMAND = 2
"""Code with which the command line ends that does not know a command or an option."""


class Cost(NamedTuple):
    """What a piece of work takes."""

    seconds: float = float("nan")
    """Time [s]; NaN: the release has it not, or fails."""
    processor: float = float("nan")
    """Processor time, child processes included [s]."""
    cycles: int | None = None
    """Cycles to the periodic state, where it is an operating point."""
    why: str = ""
    """Why there is no time."""


class Environment(NamedTuple):
    """A release, installed for itself."""

    label: str
    """Its version, or "now"."""
    folder: Path
    """Folder of the environment; its cache and what its commands write stand in it."""

    def _variables(self, cache):
        variables = {
            name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "NUMBA_DISABLE_JIT")
        }
        return variables | {"APESIM_CACHE_DIR": str(cache)}

    def call(self, name, seconds):
        """Time of a call of `calls.py`, warm."""
        command = [self.folder / "bin/python", "-P", CALLS, name, str(seconds)]
        variables = self._variables(self.folder / "cache")
        done = subprocess.run(command, cwd=self.folder, env=variables, capture_output=True, text=True, check=False)
        if done.returncode:
            return Cost(why=_last_line(done.stderr))
        found = json.loads(done.stdout.splitlines()[-1])
        return Cost(found.get("seconds", float("nan")), cycles=found.get("cycles"), why=found.get("missing", ""))

    def command(self, words, cache=None):
        """Time of a command in a process of its own, from its start to its end; warm, unless a cache is given."""
        variables = self._variables(cache or self.folder / "cache")
        with tempfile.TemporaryFile("w+") as said:
            start = time.perf_counter()
            process = subprocess.Popen(
                [self.folder / "bin/apesim", *words], cwd=self.folder, env=variables, stdout=said, stderr=said
            )
            _, status, usage = os.wait4(process.pid, 0)
            seconds = time.perf_counter() - start
            process.returncode = os.waitstatus_to_exitcode(status)
            said.seek(0)
            if process.returncode:
                missing = "no such command: " if process.returncode == NO_SUCH_COMMAND else ""
                return Cost(why=missing + _last_line(said.read()))
        return Cost(seconds, usage.ru_utime + usage.ru_stime)

    def first_run(self, words):
        """Cost of a command's first run ever, with an empty folder of caches."""
        with tempfile.TemporaryDirectory(dir=self.folder) as cache:
            return self.command(words, Path(cache))


def _last_line(text):
    lines = [line.strip(" │") for line in text.splitlines() if line.strip(" │╰─╯")]
    return lines[-1] if lines else "it said nothing"


def make_environment(wheel, label, folder):
    """Install a wheel into an environment of its own, beside all that this one has.

    Parameters
    ----------
    wheel : Path
    label : str
    folder : Path
        It is made.

    Returns
    -------
    Environment
    """
    venv.create(folder, with_pip=False, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    (site / "shared.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))
    pip = [sys.executable, "-m", "pip", "--python", folder / "bin/python"]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", wheel], check=True)
    return Environment(label, folder)


def build_wheel(folder):
    """Build the wheel of the commit that is checked out, as for a release."""
    subprocess.run([sys.executable, ROOT / ".ci/release", folder], check=True, stdout=subprocess.DEVNULL)
    (wheel,) = Path(folder).glob("*.whl")
    return wheel
