"""The public face: these names are fetched from the layers on first use, see `__init__.py`."""

from .archive import ArchiveError as ArchiveError
from .engine.drivetrain.control import EngineCommands as EngineCommands
from .engine.drivetrain.control import SensorReadings as SensorReadings
from .engine.drivetrain.feedback_timing import FeedbackTiming as FeedbackTiming
from .engine.machine import Machine as Machine
from .quantities import InputError as InputError
from .results import NotConverged as NotConverged
from .studies.archives.archive_result import read_archive as read_archive
from .studies.archives.comparison import compare_archives as compare_archives
from .studies.archives.description import describe_archive as describe_archive
from .studies.archives.description import verify_archive as verify_archive
from .studies.archives.joining import export_archive as export_archive
from .studies.archives.joining import merge_archives as merge_archives
from .studies.assessment.comparison import assess_valve as assess_valve
from .studies.design.machine_design import design_machine as design_machine
from .studies.discharge.effective_area import evaluate_discharge as evaluate_discharge
from .studies.explore.live_page import explore as explore
from .studies.fmu.export import export_fmu as export_fmu
from .studies.gap.design.isolability import find_isolability as find_isolability
from .studies.gap.search.library import list_effects as list_effects
from .studies.gap.workflow import explain as explain
from .studies.identify.estimate import fit as fit
from .studies.limit.engine_limit_map import find_engine_limit as find_engine_limit
from .studies.limit.valve_limit import find_valve_limit as find_valve_limit
from .studies.limit.valve_map import map_valve as map_valve
from .studies.measured import read_measured as read_measured
from .studies.measured.check import check_measured as check_measured
from .studies.optimise.optimisation import optimise_commands as optimise_commands
from .studies.paper.repetition import repeat_paper as repeat_paper
from .studies.report.writing import write_report as write_report
from .studies.run.engine_ensemble import run_many as run_many
from .studies.run.engine_run import run_engine as run_engine
from .studies.run.valve_run import run_valve as run_valve
from .studies.soft_landing.study import find_soft_landing as find_soft_landing
from .studies.stepping.stepper import Stepper as Stepper
from .studies.sweep.study import sweep as sweep
from .studies.timing.correction import correct_timing as correct_timing
from .studies.transient.start import start_engine as start_engine
from .studies.transient.transient import run_transient as run_transient

__all__: list[str]

__version__: str
