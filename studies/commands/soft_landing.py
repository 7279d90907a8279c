"""The command `apesim valve soft-landing`."""

import numpy as np

from apesim.quantities import Choice, Quantity, parse, parse_range
from apesim.studies.commands.archived import computed, summary
from apesim.studies.commands.given import PRESSURE, TEMPERATURE, TIME
from apesim.studies.commands.machine import load_machine
from apesim.studies.commands.tables import table_of
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.soft_landing.braking import ADDED, APART, BRAKE, RELEASE, SPEED, SWITCHED, front_of, widest_soft
from apesim.studies.soft_landing.landing import BOTH, ONLY_A, ONLY_B, SOLENOIDS
from apesim.studies.soft_landing.results import archive_of
from apesim.studies.soft_landing.strokes import FACTORS, KINDS, LIMITS, OFFSETS, SPACING, faults_of, soft_landings
from apesim.valve.bench import run_bench

ANY = "any"
TOLD = {BOTH: "A and B", ONLY_A: "A", ONLY_B: "B"}
GIVEN = Choice((*SOLENOIDS, ANY), "command line")
BRAKE_HEADER = (
    *("MPa gauge", "stroke", "brake", "solenoids", "edges\n[ms]", "added\n[ms]", "v_e\n[m/s]", "energy left\n[%]"),
    *("worst v_e\n[m/s]", "worst added\n[ms]"),
)
SHORT_TIME = Quantity("ms", 0.01, 100, "command line", typical="1 ms")


def soft_landing_command(
    console, machine_file, settings, pressure, temperature, cost, spacing, solenoids, pulse, out, overwrite, figures
):
    """Brakes that land the piston softly; see `apesim valve soft-landing --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.figures.soft_landing import soft_landing_figures

    machine = load_machine(machine_file, settings)
    pressures = parse_range(pressure, PRESSURE, machine.ambient.pressure, where="--pressure", file=COMMAND_LINE)
    temperature = parse(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE)
    cost = parse(cost, SHORT_TIME, where="--cost", file=COMMAND_LINE)
    spacing = parse(spacing, SHORT_TIME, where="--spacing", file=COMMAND_LINE) if spacing else SPACING
    solenoids = GIVEN.options[parse(solenoids, GIVEN, where="--solenoids", file=COMMAND_LINE)]
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)
    ways = SOLENOIDS if solenoids == ANY else (solenoids,)
    results = []

    def compute(command, report):
        results.extend(soft_landings(machine, pressures, temperature, pulse, spacing, cost, report, ways))
        return archive_of(machine, results, spacing, cost, command, ways)

    def draw(archive, folder):
        return soft_landing_figures(archive, machine.ambient.pressure, folder) if figures else []

    _, told = computed(console, "soft landing", (run_bench, machine, pulse), compute, out, overwrite, draw)
    faults = faults_of(results, spacing, cost, ways)
    data = {
        "spacing_ms": 1e3 * spacing,
        "cost_ms": 1e3 * cost,
        "solenoids": solenoids,
        "reachable": not faults,
        "points": [_point(result, spacing, cost) for result in results],
        "faults": faults,
    }
    console.result(data | told, *_tables(results, spacing, cost), summary(told, f"{len(results)} strokes"))
    for fault in faults:
        console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


def _point(result, spacing, cost):
    """A stroke at one pressure, for JSON."""
    pressure, temperature = result.task.machine.supply.control()
    wide = widest_soft(result.brakes, result.unbraked, cost)
    fronts = zip(LIMITS, (spacing, 0.0), strict=True)
    return {
        "supply_pressure_Pa": pressure,
        "supply_temperature_K": temperature,
        "stroke": result.task.stroke,
        "unbraked": {
            "contact_ms": 1e3 * result.unbraked.contact,
            "seating_speed_m_s": result.unbraked.speed,
            "seating_energy_J": _energy(result, result.unbraked.speed),
            "lowest_speed_m_s": result.lowest,
        },
        "reachable": bool(result.choices["within_spacing", "softest"]),
        **{limit: {kind: _pattern(result, result.choices[limit, kind]) for kind in KINDS} for limit in LIMITS},
        "needed_spacing_ms": 1e3 * wide[0, APART] if len(wide) else None,
        "front": {
            limit: [
                {
                    "solenoids": _solenoids(row),
                    "edges_ms": _edges(row),
                    "added_ms": 1e3 * row[ADDED],
                    "seating_speed_m_s": row[SPEED],
                }
                for row in front_of(result.brakes, apart)
            ]
            for limit, apart in fronts
        },
    }


def _edges(row):
    """The command and the edges of a brake, after the command [ms]."""
    return [0.0, *(round(1e3 * row[column], 6) for column in (BRAKE, RELEASE))]


def _solenoids(row):
    """Those that a brake switches."""
    return SOLENOIDS[int(row[SWITCHED])]


def _energy(result, speed):
    """Energy at contact [J]."""
    return 0.5 * result.task.machine.valve.moving_mass * speed**2


def _pattern(result, choice):
    """A choice, for JSON; None if there is none."""
    if not choice:
        return None
    conditions = [(factor, offset) for factor in FACTORS for offset in OFFSETS]
    return {
        "solenoids": choice.solenoids,
        "edges_ms": _edges(choice.row),
        "spacing_ms": 1e3 * choice.row[APART],
        "added_ms": 1e3 * choice.row[ADDED],
        "seating_speed_m_s": choice.row[SPEED],
        "seating_energy_J": _energy(result, choice.row[SPEED]),
        "robustness": [
            {
                "pressure_factor": factor,
                "temperature_offset_K": offset,
                "seating_speed_m_s": landing.speed,
                "contact_ms": 1e3 * landing.contact,
                "added_ms": 1e3 * added,
                "stays": landing.stays,
            }
            for (factor, offset), landing, added in zip(conditions, choice.landings, choice.added, strict=True)
        ],
    }


def _tables(results, spacing, cost):
    """What a terminal shows."""
    rows = []
    for result in results:
        wide = widest_soft(result.brakes, result.unbraked, cost)
        rows.append(
            (
                f"{result.gauge / 1e6:.3g}",
                result.task.stroke,
                f"{1e3 * result.unbraked.contact:.2f}",
                f"{result.unbraked.speed:.3f}",
                f"{1e3 * _energy(result, result.unbraked.speed):.1f}",
                f"{result.lowest:.3f}",
                f"{1e3 * wide[0, APART]:.2f}" if len(wide) else "-",
            )
        )
    header = ("MPa gauge", "stroke", "contact [ms]", "v_e [m/s]", "energy [mJ]", "lowest [m/s]", "edges apart [ms]")
    yield table_of("Without a brake; edges so far apart that a brake could halve v_e", header, rows, left=(1,))
    titles = (f"Brakes with edges {1e3 * spacing:.3g} ms apart", "Brakes with edges as close as it takes")
    for title, limit in zip(titles, LIMITS, strict=True):
        rows = [_row(result, limit, kind) for result in results for kind in KINDS if result.choices[limit, kind]]
        if rows:
            yield table_of(f"{title}, for {1e3 * cost:.3g} ms", BRAKE_HEADER, (*rows,), left=(1, 2, 3))
        else:
            yield f"{title}, for {1e3 * cost:.3g} ms: none lowers the seating speed\n"
    yield (
        f"lowest: of the unbraked piston between its peak speed and contact. worst: at {FACTORS[0]:g}, 1 and "
        f"{FACTORS[-1]:g} of the gauge pressure and {OFFSETS[-1]:g} K up and down; ! falls off its stop there"
    )


def _row(result, limit, kind):
    choice = result.choices[limit, kind]
    speeds = [landing.speed for landing in choice.landings]
    worst = "fails" if np.isnan(speeds).any() else f"{max(speeds):.3f}"
    falls = "" if all(landing.stays for landing in choice.landings) else " !"
    return (
        f"{result.gauge / 1e6:.3g}",
        result.task.stroke,
        kind,
        TOLD[choice.solenoids],
        " ".join(f"{edge:.2f}" for edge in _edges(choice.row)[1:]),
        f"{1e3 * choice.row[ADDED]:.2f}",
        f"{choice.row[SPEED]:.3f}",
        f"{100.0 * (choice.row[SPEED] / result.unbraked.speed) ** 2:.1f}",
        worst + falls,
        f"{1e3 * choice.added.max():.2f}",
    )
