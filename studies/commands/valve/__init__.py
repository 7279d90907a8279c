"""The commands of the valve alone."""

from apesim.studies.commands.options import group
from apesim.studies.commands.valve.discharge import evaluate_discharge
from apesim.studies.commands.valve.fit import fit_valve
from apesim.studies.commands.valve.limit import find_valve_limits
from apesim.studies.commands.valve.map import map_valve_strokes
from apesim.studies.commands.valve.run import run_valve
from apesim.studies.commands.valve.soft_landing import find_soft_landing

valve = group(
    "The electro-pneumatic valve alone, on its test bench.",
    {
        "run": run_valve,
        "map": map_valve_strokes,
        "limit": find_valve_limits,
        "soft-landing": find_soft_landing,
        "discharge": evaluate_discharge,
        "fit": fit_valve,
    },
)
