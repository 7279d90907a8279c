"""What the paper says of the valve's design and experiments: working frequency, friction, springs, measured curves."""

from typing import Any

from apesim.engine.machine import Machine
from apesim.studies.limit.valve_limit import is_complete, working_limit
from apesim.studies.limit.valve_map import PULSE
from apesim.studies.paper.claims.claim import NOT_COMPUTABLE, Claim, verdict_of
from apesim.studies.run.operating_conditions import with_control_air
from apesim.valve.bench import run_bench
from apesim.valve.effects.chamber_wall_heat import ChamberWallHeat
from apesim.valve.effects.coulomb_friction import CoulombFriction

MEASURED = (0.16, 0.4, 0.49)
"""The paper's pressures of control air in experiments [MPa gauge]."""
PRESSURES = ", ".join(f"{pressure:g}" for pressure in MEASURED)
RATE = 30.0
"""The valve's working frequency, by the paper [Hz]."""
HEAT = 200.0
"""Heat transfer coefficient, the upper end of 50 to 200 for forced convection in small cylinders [W/(m2 K)]."""


def working_frequency(machine: Machine) -> Claim:
    """Judge the claim that the valve reaches about 30 Hz [EPV, abstract and Fig. 10].

    It finds six limits, which takes seconds.
    """
    ambient = machine.ambient.pressure
    limits = {
        (pressure, duty): working_limit(with_control_air(machine, ambient + pressure * 1e6, 287.0), duty, 0.1).limit
        for duty in (0.3, 0.5)
        for pressure in MEASURED
    }
    rates = {d: ", ".join(f"{limits[p, d]:.1f}" for p in MEASURED) for d in (0.3, 0.5)}
    values = {f"limit_hz_at_{p:g}_MPa_duty_{d:g}": value for (p, d), value in limits.items()}
    ours = f"every stroke is complete up to {rates[0.5]} Hz at {PRESSURES} MPa, energised for half of the period"
    return _frequency_claim(ours, values, min(limits[p, 0.5] for p in MEASURED) >= RATE)._replace(
        depends_on=("duty",),
        remark="Judged by 30 Hz, energised for half of the period, at all three pressures that the paper measured at. "
        "The abstract calls 30 Hz the maximum; that depends on the duty, which it does not name: for 0.3 of the period "
        f"the limits are {rates[0.3]} Hz.",
    )


def works_at_30_hz(machine: Machine) -> Claim:
    """Judge the claim of `working_frequency` alone, without computing its limits [EPV, abstract and Fig. 10].

    >>> print(works_at_30_hz(Machine()).verdict)
    reproduced
    """
    ambient = machine.ambient.pressure
    done = [is_complete(with_control_air(machine, ambient + p * 1e6, 287.0), RATE, 0.5) for p in MEASURED]
    ours = f"every stroke is complete at {RATE:g} Hz at {sum(done)} of the pressures {PRESSURES} MPa"
    return _frequency_claim(ours, {"pressures_with_complete_strokes": sum(done)}, all(done))


def _frequency_claim(ours: str, values: dict[str, float], holds: bool) -> Claim:
    """Make the claim that the valve reaches about 30 Hz, with the model's answer.

    The claim stands in the abstract and in the discussion of Fig. 10 of the EPV paper (doi 10.1631/jzus.A0820373).
    """
    return Claim(
        "working_frequency",
        "abstract, discussion of Fig. 10",
        "The valve's working frequency could reach about 30 Hz.",
        "about 30 Hz",
        ours,
        values,
        verdict_of(holds),
        "",
    )


def engine_speed() -> Claim:
    """Judge the claim that 30 Hz are 2000 r/min [EPV, abstract and discussion of Fig. 10]."""
    speed, rate = RATE * 60.0, 2000.0 / 60.0
    return Claim(
        "engine_speed",
        "abstract",
        "30 Hz correspond to an engine speed of 2000 r/min.",
        "2000 r/min",
        f"{speed:.0f} r/min at one event a revolution; 2000 r/min are {rate:.1f} Hz",
        {"speed_rpm": speed, "rate_hz": rate},
        verdict_of(abs(speed - 2000.0) < 50.0),
        "Arithmetic, of any valve; judged by 50 r/min.",
    )


def friction_is_small(machine: Machine) -> Claim:
    """Judge the claim that Coulomb friction below 1.1 N is negligible [EPV, simulation setting]."""
    supplied = with_control_air(machine, machine.ambient.pressure + 0.4e6, 287.0)
    effects = supplied.effects._replace(coulomb_friction=CoulombFriction(1.1, 1.1))  # type: ignore[call-arg]
    rubbed = supplied._replace(effects=effects)
    base, other = run_bench(supplied, PULSE).opening, run_bench(rubbed, PULSE).opening
    changes = [getattr(other, f) / getattr(base, f) - 1.0 for f in ("delay", "stroke_time", "seating_speed")]
    return Claim(
        "friction_is_negligible",
        "experimental validation",
        "Coulomb friction is below 1.1 N and negligible.",
        "negligible",
        f"1.1 N change delay, stroke time and seating speed by {', '.join(f'{100 * c:+.2f} %' for c in changes)}",
        dict(zip(("delay_change", "stroke_time_change", "seating_speed_change"), changes, strict=True)),
        verdict_of(max(map(abs, changes)) < 0.01),
        "At 0.40 MPa; judged by 1 %.",
    )


def heat_is_small(machine: Machine) -> Claim:
    """Judge the claim that heat from the walls can be left out [EPV, above Eq. 6]."""
    supplied = with_control_air(machine, machine.ambient.pressure + 0.4e6, 287.0)
    effects = supplied.effects._replace(chamber_wall_heat=ChamberWallHeat(HEAT))  # type: ignore[call-arg]
    warmed = supplied._replace(effects=effects)
    base, other = run_bench(supplied, PULSE), run_bench(warmed, PULSE)
    pairs = [(getattr(other, side), getattr(base, side)) for side in ("opening", "closing")]
    changes = [
        max((getattr(new, f) / getattr(old, f) - 1.0 for new, old in pairs), key=abs)
        for f in ("delay", "stroke_time", "seating_speed")
    ]
    return Claim(
        "heat_is_negligible",
        "Eq. 6",
        "The strokes are so short that heat between air and walls can be left out.",
        "negligible",
        f"{HEAT:g} W/(m² K) change delay, stroke time and seating speed by up to "
        f"{', '.join(f'{100 * c:+.2f} %' for c in changes)}, opening or closing",
        dict(zip(("delay_change", "stroke_time_change", "seating_speed_change"), changes, strict=True)),
        verdict_of(max(map(abs, changes)) < 0.05),
        "At 0.40 MPa, walls at 293 K; the coefficient is the upper end of what small cylinders are said to have. "
        "Judged by 5 %.",
    )


def springs_soften(machine: Machine) -> Claim:
    """Judge the claim that the springs' main function is to soften the impact [EPV, section on system dynamics].

    >>> print(springs_soften(Machine()).verdict)
    reproduced
    """
    supplied = with_control_air(machine, machine.ambient.pressure + 0.4e6, 287.0)
    free = supplied._replace(valve=supplied.valve._replace(spring_rate=0.0))
    openings: tuple[Any, Any] = run_bench(supplied, PULSE).opening, run_bench(free, PULSE).opening
    with_springs, without = openings
    change = with_springs.seating_speed / without.seating_speed - 1.0
    return Claim(
        "springs_soften_the_impact",
        "system dynamics",
        "The springs' main function is to soften the piston's impact.",
        "softer",
        f"seating speed {with_springs.seating_speed:.3f} m/s with springs, {without.seating_speed:.3f} m/s without "
        f"({100 * change:+.1f} %)",
        {"with_springs_m_s": with_springs.seating_speed, "without_m_s": without.seating_speed},
        verdict_of(change < 0.0),
        "They push in the first half of the stroke as much as they brake in the second.",
    )


def time_error() -> Claim:
    """State the claim that simulated and measured lift differ by less than 1.2 ms, which cannot be computed.

    The paper does not give its measurements as numbers [EPV, discussion of Fig. 6].
    """
    return Claim(
        "time_error",
        "Fig. 6",
        "At 0.16 and 0.49 MPa simulated and measured lift differ by less than 1.2 ms.",
        "below 1.2 ms",
        "the measured curves survive as figures only",
        {"paper_ms": 1.2},
        NOT_COMPUTABLE,
        "apesim valve fit measures it on a user's check runs.",
    )
