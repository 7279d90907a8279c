"""The main job: four intakes from 300 to 2400 r/min, 1.0 MPa gauge and 287 K, behind a receiver of 1 L."""

import shutil
import tempfile
from pathlib import Path

import apesim
from docs.results import Number
from docs.results._figures import FOLDER
from docs.results._terminal import run

LONG = True
NAMES = {"epv": "fixed", "epv corrected": "corrected", "cam": "cam", "ideal": "ideal"}
SHOWN = ("torque_and_air", "indicator_diagrams", "cycle_traces")


def compute():
    """What the command prints, its figures, and what the curves over speed say."""
    with tempfile.TemporaryDirectory() as folder:
        archive = Path(folder) / "sweep.h5"
        printed = run("engine", "sweep", "--out", str(archive))
        for name in SHOWN:
            shutil.copy(archive.with_suffix(".figures") / f"{name}.png", FOLDER)
        runs = apesim.read_archive(archive).to_pandas()
    printed = type(printed)(printed.text.replace(f"{folder}/", ""))
    return {"printed": printed, **_findings(runs)}


def _findings(runs):
    values = {}
    over_speed = {NAMES[name]: rows.set_index("speed_rpm").sort_index() for name, rows in runs.groupby("actuation")}
    for name, rows in over_speed.items():
        torque, power, efficiency = (rows[key] for key in ("brake_torque", "brake_power", "exergy_efficiency"))
        values |= {
            f"{name}.torque_1500": Number(torque[1500.0], "N·m", error=0.05),
            f"{name}.highest_speed": Number(torque[torque > 0.0].index.max(), "r/min"),
            f"{name}.speed_of_most_torque": Number(torque.idxmax(), "r/min"),
            f"{name}.most_power": Number(power.max() / 1e3, "kW", error=0.05),
            f"{name}.speed_of_most_power": Number(power.idxmax(), "r/min"),
            f"{name}.efficiency_300": Number(1e2 * efficiency[300.0], "%", error=0.5),
            f"{name}.efficiency_1000": Number(1e2 * efficiency[1000.0], "%", error=0.5),
        }
    torque = {name: rows["brake_torque"] for name, rows in over_speed.items()}
    late_wins = torque["fixed"] > torque["ideal"]
    lift = over_speed["corrected"]["peak_lift"]
    partly = lift < lift.max() * (1.0 - 1e-6)
    return values | {
        "late_beats_ideal_up_to": Number(late_wins[late_wins].index.max(), "r/min"),
        "corrected_turns_back_from": Number(partly[partly].index.min(), "r/min"),
    }
