"""The command of the missing-effect workflow."""

import json
import time
from pathlib import Path

from apesim.quantities import Culprit, InputError
from apesim.quantities.settings import dumps
from engine.effects import ALL_EFFECTS
from studies.commands.machine import load_machine
from studies.commands.tables import table_of
from studies.console import COMMAND_LINE, plain
from studies.gap.child import child_of
from studies.gap.explain import explain
from studies.gap.gate import gate
from studies.gap.record import record
from studies.measured import read_measured


def explain_command(console, machine_file, settings, folder, out, without):
    """Name what is missing between a machine and measured data; see `apesim gap explain --help`.

    Parameters
    ----------
    console : studies.console.Console
    machine_file : path or None
    settings : list of str or None
        ``KEY=VALUE``
    folder : path
        Of the measured data.
    out : path
        Folder to write.
    without : list of str
        Effects that are not to be considered.
    """
    machine = load_machine(machine_file, settings)
    known = [effect.name for effect in ALL_EFFECTS]
    for name in without:
        if name not in known:
            raise InputError([Culprit(COMMAND_LINE, "--without", f"{name!r} is no effect", "see apesim gap effects")])
    measured = read_measured(folder, machine.ambient.pressure)
    gate(measured)
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    with console.progress("explaining") as report:
        findings = console.run("explaining", explain, machine, measured, without, lambda _, *at: report(*at))
    data = plain(record(findings, time.perf_counter() - start))
    parent = Path(machine_file).read_text() if machine_file else dumps(machine)
    for name, text in (
        ("verdict.json", json.dumps(data, indent=1, ensure_ascii=False) + "\n"),
        ("machine.toml", child_of(findings, parent, data)),
    ):
        (out / name).write_text(text)
    console.result(data, *shown(data))
    for warning in findings.warnings:
        console.message(f"warning: {warning}")


def shown(data):
    """The verdict on a terminal."""
    yield f"{data['verdict']}: {data['sentence']} ({data['reason']}; probability {data['probability']:.2f})"
    rows = [
        [row["effect"], f"{row['deviations']:.1f}", _limit(data["detection_limits"].get(row["effect"]))]
        for row in data["scores"][:8]
    ]
    yield table_of("", ("effect", "score [deviations]", "visible from (5 deviations)"), rows, left=(0,))


def _limit(limit):
    if limit is None or limit["limit"] is None:
        return "beyond its range"
    return f"{limit['limit']:.3g} {limit['unit']}".strip()
