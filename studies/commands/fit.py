"""The command that identifies parameters from measured data."""

from apesim.quantities import Choice, parse, unit
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.identify.estimate import fit
from apesim.studies.identify.free import METHODS, free_parameters
from apesim.studies.measured import CHECK, GATE, VALVE, read_measured
from apesim.studies.tables import table_of
from apesim.valve.bench import run_bench

METHOD = Choice(METHODS, "command line")
HEADER = ("run", "largest time shift [ms]", "by noise alone, 95 % [ms]", "left over noise", "limit")


def fit_command(common, *, folder, free, method):
    """Parameters from measured data; see `apesim valve fit --help`.

    Parameters
    ----------
    common : apesim.studies.options.Common
    folder : path
        Of the measured data.
    free : list of str
        ``KEY`` or ``KEY=LOW:HIGH``
    method : {"least-squares", "ga"} or None

    Returns
    -------
    int
        Exit code.
    """
    console, machine = common.console, common.load_machine()
    method = METHODS[parse(method or METHODS[0], METHOD, where="--method", file=COMMAND_LINE)]
    free_parameters(machine, free or (), method)
    measured = read_measured(folder, machine.ambient.pressure, VALVE)
    console.warm_up(run_bench, machine, 10e-3)
    with console.progress("simulations") as report:
        found = call_in_thread(
            fit, measured, free, machine=machine, method=method, progress=lambda stage, done, total: report(done, total)
        ).result()
    console.result(found.to_dict(), *_shown(found))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    refusing = [one for one in found.gates if one.contradicted]
    for one in refusing:
        console.message(
            f"{one.run}: refuses the model: what is left is {one.residual_over_noise:.3g} times the noise, "
            f"beyond the {one.limit:.3g} that noise and the parameters' uncertainty allow"
        )
    return DONE if found.converged and not refusing else INCOMPLETE


def _shown(found):
    """Tables and a line for the terminal."""
    rows = []
    for key, value in found.parameters.items():
        declared = found.declared[key]
        factor = float(unit(declared.unit).factor)
        texts = ["-" if v is None else f"{v / factor:.6g}" for v in (value, *(found.interval_95[key] or (None, None)))]
        rows.append((key, *texts, f"{declared.unit}{declared.suffix}" or "-"))
    yield table_of("Parameters", ("", "value", "95 % from", "to", "unit"), rows)
    for role, runs in ((GATE, found.gates), (CHECK, found.checks)):
        if runs:
            rows = [
                (
                    one.run,
                    f"{one.time_shift_s * 1e3:.4g}",
                    f"{one.noise_limit_s * 1e3:.4g}",
                    f"{one.residual_over_noise:.3g}",
                    f"{one.limit:.3g}",
                )
                for one in runs
            ]
            yield table_of(f"{role.capitalize()} runs, not fitted", HEADER, rows)
    yield f"objective {found.objective * 1e3:.5g} mm (Eq. 11); {found.evaluations} simulations"
