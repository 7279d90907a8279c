"""The commands of the engine."""

from apesim.studies.commands.engine.assess import assess_valve
from apesim.studies.commands.engine.limit import find_engine_limit
from apesim.studies.commands.engine.optimise import optimise_commands
from apesim.studies.commands.engine.run import run_engine
from apesim.studies.commands.engine.start import start_engine
from apesim.studies.commands.engine.sweep import sweep_engine
from apesim.studies.commands.engine.timing import correct_timing
from apesim.studies.commands.engine.transient import run_transient
from apesim.studies.commands.options import group

engine = group(
    "The engine that breathes through it.",
    {
        "run": run_engine,
        "sweep": sweep_engine,
        "timing": correct_timing,
        "limit": find_engine_limit,
        "assess": assess_valve,
        "optimise": optimise_commands,
        "start": start_engine,
        "transient": run_transient,
    },
)
