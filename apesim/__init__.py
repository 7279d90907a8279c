"""Simulate air-powered engines whose intake is opened by an electro-pneumatic valve.

The ground that all layers share, in the order in which they build on one another: kernel (the compile decorator),
quantities (units, ranges, strict files), air (gas, its states), flow_function, restriction (flow through
it), exergy (of streams and volumes), effect (what an effect is), leak (through a restriction, as an effect), march (the
one adaptive march, and periodic states), archive (HDF5), results (named numbers and traces).

The layers above it are `apesim.valve`, `apesim.engine` and `apesim.studies`. In a checkout their folders stand beside
this one; installed, within it.

The names below are the public face. They are fetched from the layers on first use, so that importing this package
loads none of them.
"""

import importlib
from pathlib import Path

_FOLDER = Path(__file__).parent  # not resolved: an editable install may link each file from elsewhere
if not (_FOLDER / "valve").exists():
    __path__.append(str(_FOLDER.parent))

_PUBLIC = {
    "Machine": "apesim.engine.machine",
    "load_machine": "apesim.studies.machine_file",
    "run_bench": "apesim.studies.public",
    "run_steady": "apesim.studies.public",
    "indicators": "apesim.studies.public",
    "run_sweep": "apesim.studies.public",
    "vary": "apesim.studies.sweep",
    "read_archive": "apesim.archive",
    "read_grid": "apesim.archive.grid",
    "read_measured": "apesim.studies.measured",
    "explain": "apesim.studies.gap.workflow",
    "find_isolability": "apesim.studies.gap.design.isolability",
    "fit": "apesim.studies.identify.estimate",
    "InputError": "apesim.quantities",
    "ArchiveError": "apesim.archive",
}
__all__ = list(_PUBLIC)


def __getattr__(name):
    if name not in _PUBLIC:
        raise AttributeError(f"module 'apesim' has no attribute {name!r}")
    module = importlib.import_module(_PUBLIC[name])
    value = getattr(module, "read" if name == "read_archive" else name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(set(globals()) | set(_PUBLIC))
