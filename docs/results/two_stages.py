"""Work per gram of one and of two stages over the supply's pressure, and what exchanger, bore and timing change."""

from functools import partial
from math import pi

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq, minimize

import apesim
from apesim.engine.angles import DEGREE
from apesim.engine.cam import cam_angles
from apesim.engine.cycle.state import receiver_gas
from apesim.engine.drivetrain.preparing import prepare
from apesim.engine.drivetrain.state import block_of, receiver_in
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.style import BLUE, MARKERS, RED, STYLES, colours_of
from docs.results import Number, Table
from docs.results._figures import keep

LONG = True
SPEED = 600.0
"""Imposed speed [r/min]."""
TURNS, TURNS_SOUGHT = 200, 80
"""Turns from rest at constant speed: of what is told, and of what is tried in the search for cut-offs."""
CAMS = {"engine.intake": "cam"}
SECOND = {
    "stage_2.bore": "120 mm",
    "stage_2.groove.effective_area": "300 mm^2",
    "stage_2.exhaust.effective_area": "1000 mm^2",
    "inter_receiver.effectiveness": 0.8,
}
PRESSURES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
LOW_PRESSURES = (0.4, 0.6, 0.8, *PRESSURES)
"""Supply pressures [MPa gauge]; where cut-offs suit the pressure, lower ones, too."""
EFFECTIVENESS = (0.0, 0.4, 0.8, 1.0)
BORES = (90, 100, 110, 120, 130, 140, 150)
"""Bores of the second cylinder [mm]."""
SHOWN = (1.0, 3.0, 6.0)
FLANK, OPENS = 25.0, -5.0
"""Flank of a cam, and the angle at which it begins to open [deg]: those of the default machine."""
STATED = (70.0, 70.0)
"""Angles at which the cams of both stages end, as the default machine has it [deg]."""
DAMPED = 0.7
"""Share of a miss by which commands are moved: a short pulse closes the later, the earlier it was energised."""
WORK = partial(Number, unit="J/g", error=0.05)
REPEATS: dict[str, list[float]] = {"cams": [], "valves": []}
"""Largest relative change of work and air from one revolution to the next, at the end of each run that is told."""


def compute():
    """Work per gram over pressure, effectiveness, bore and timing; the inter-receiver over a turn; four figures."""
    stated = {stages: [_work(p, stages) for p in PRESSURES] for stages in (1, 2)}
    suited = {stages: [_suited(p, stages) for p in LOW_PRESSURES] for stages in (1, 2)}
    exchangers = {e: [_work(p, 2, inter_receiver_effectiveness=e) for p in PRESSURES] for e in EFFECTIVENESS}
    bores = {p: [_work(p, 2, stage_2_bore=(bore, "mm")) for bore in BORES] for p in SHOWN}
    bores["suited"] = [_suited(3.0, 2, stage_2_bore=(bore, "mm"))[1] for bore in BORES]
    cut_offs = dict(zip(LOW_PRESSURES, (each[0] for each in suited[2]), strict=True))
    turns = {"stated": _turn(3.0, STATED), "suited": _turn(3.0, cut_offs[3.0])}
    figures = {
        "work": partial(_draw_work, stated, suited),
        "sizes": partial(_draw_sizes, stated[1], exchangers, bores),
        "pv": partial(_draw_indicator, turns),
        "between": partial(_draw_between, turns),
    }
    keep(partial(write_figures, figures), **{name: f"two_stages_{name}" for name in figures})
    values = {
        "break_even": Number(brentq(_gain, 2.0, 3.0, xtol=1e-3), "MPa", error=0.005),
        "break_even_suited": Number(_crossing(suited), "MPa", error=0.05),
        "stated": _over_pressure(stated),
        "suited": _suited_table(suited),
        "exchanger": _exchanger_table(exchangers, cut_offs[3.0]),
        "bores": _bore_table(bores),
        "valves": _valve_table(cut_offs),
        "others": _other_table(),
        "one_at_3": WORK(dict(zip(LOW_PRESSURES, suited[1], strict=True))[3.0][1]),
        "no_exchanger": WORK(_suited(3.0, 2, inter_receiver_effectiveness=0.0)[1]),
    }
    values |= _turn_values(turns) | _shift() | {"claims": _claims(stated, values)}
    for name, changes in REPEATS.items():
        values[f"repeats.{name}"] = Number(1e9 * max(changes), "·\u00a010⁻⁹", error=5.0)
        values[f"runs.{name}"] = Number(len(changes))
    return values


# Machines and runs -------------------------------------------------------------------------------------------------


def _machine(pressure, stages, cut_offs=STATED, **keys):
    """A machine with cams that end at the cut-offs [deg], the supply at a gauge pressure [MPa]."""
    values = {"supply_pressure": f"{pressure} MPa gauge", "supply_control_pressure": "1 MPa gauge"} | CAMS
    if stages == 2:
        values |= SECOND
    for cam, closes in zip(("engine.cam", "stage_2.cam")[:stages], cut_offs, strict=False):
        # A window that is too short for both flanks has shorter ones.
        flank = min(FLANK, 0.5 * (float(closes) - OPENS))
        values |= {f"{cam}.closes": (float(closes), "deg"), f"{cam}.flank": (flank, "deg")}
    return apesim.Machine().with_(**values).with_(**keys)


def _run(machine, turns=TURNS, sample=None):
    """Turns at constant speed from rest."""
    end = turns * 60.0 / SPEED
    speed = f"0 s: {SPEED} rpm, {end} s: {SPEED} rpm"
    return apesim.run_transient(machine, speed=speed, sample=sample or f"{0.5 * end} s")


def _read(run):
    """Work per gram of all air in the last whole revolution [J/g]."""
    work = 2.0 * pi * run.traces["revolution_brake_torque"].values
    air = 1e3 * sum(run.traces[f"revolution_{name}"].values for name in ("engine_air", "control_air"))
    if len(work) > TURNS_SOUGHT:
        changes = [abs(each[-1] / each[-2] - 1.0) for each in (run.traces["revolution_gas_torque"].values, air)]
        REPEATS["valves" if run["control_air"] else "cams"].append(max(changes))
    return work[-1] / air[-1]


def _work(pressure, stages, cut_offs=STATED, turns=TURNS, **keys):
    """Work per gram at a supply pressure [MPa gauge]."""
    return _read(_run(_machine(pressure, stages, cut_offs, **keys), turns))


def _gain(pressure):
    """Work per gram that a second stage adds with the stated cams [J/g]."""
    return _work(pressure, 2) - _work(pressure, 1)


def _suited(pressure, stages, **keys):
    """Cut-offs with the most work per gram [deg], and that work [J/g]; sought by Nelder and Mead's method."""

    def loss(cut_offs):
        if min(cut_offs) < 10.0 or max(cut_offs) > 170.0:
            return 1e3
        return -_read(_run(_machine(pressure, stages, cut_offs, **keys), TURNS_SOUGHT))

    first = np.array([60.0, 110.0][:stages])
    simplex = np.vstack([first, first + 15.0 * np.eye(stages)])
    options = {"xatol": 0.5, "fatol": 5e-3, "initial_simplex": simplex}
    found = minimize(loss, first, method="Nelder-Mead", options=options)
    return tuple(found.x), _work(pressure, stages, found.x, **keys)


def _crossing(suited):
    """Pressure above which two stages give more, each with its cut-offs, linear between those that were run [MPa]."""
    gains = np.array([two - one for (_, one), (_, two) in zip(suited[1], suited[2], strict=True)])
    at = int(np.flatnonzero(gains < 0.0)[-1])
    return float(np.interp(0.0, gains[at : at + 2], LOW_PRESSURES[at : at + 2]))


# Tables ------------------------------------------------------------------------------------------------------------


def _over_pressure(stated):
    names = {1: "one stage [J/g]", 2: "two stages [J/g]"}
    rows = [[names[stages], *map(WORK, works)] for stages, works in stated.items()]
    return Table(["supply [MPa gauge]", *(f"{p:g}" for p in PRESSURES)], rows)


def _suited_table(suited):
    rows = []
    for pressure, (one, alone), (two, both) in zip(LOW_PRESSURES, suited[1], suited[2], strict=True):
        angles = [Number(angle, "°", error=0.5) for angle in (*one, *two)]
        rows.append([f"{pressure:g}", angles[0], WORK(alone), *angles[1:], WORK(both)])
    heads = ["supply [MPa gauge]", "one stage: cam ends at [°]", "work [J/g]", "two stages: first cam ends at [°]"]
    return Table([*heads, "second [°]", "work [J/g]"], rows)


def _exchanger_table(exchangers, cut_offs):
    rows = []
    for effectiveness, works in exchangers.items():
        run = _run(_machine(3.0, 2, cut_offs, inter_receiver_effectiveness=effectiveness))
        row = [WORK(works[PRESSURES.index(pressure)]) for pressure in SHOWN]
        heat = float(run.march.revolutions["exchanged_heat"][-1])
        rows.append([f"{effectiveness:g}", *row, WORK(_read(run)), Number(heat, "J", error=0.05)])
    heads = ["effectiveness", *(f"stated cams, {pressure:g} MPa [J/g]" for pressure in SHOWN)]
    return Table([*heads, "suited cams, 3 MPa [J/g]", "their heat a turn [J]"], rows)


def _bore_table(bores):
    rows = [[f"{bore}", *(WORK(works[k]) for works in bores.values())] for k, bore in enumerate(BORES)]
    heads = [f"stated cams, {pressure:g} MPa [J/g]" for pressure in SHOWN]
    return Table(["bore [mm]", *heads, "suited cams, 3 MPa [J/g]"], rows)


def _with_valves(machine):
    """A machine with electro-pneumatic valves that open and close where its cams do, and the largest miss [deg].

    Each command is moved by what the valve of its stage misses, until all miss less than 0.01 deg.
    """
    stages = [machine.engine.cam, machine.stage_2.cam][: 1 + machine.stage_2.is_on]
    lift = machine.valve.stroke
    targets = np.array([cam_angles(cam.resolve_lift(lift), machine.groove.lap)[:2] for cam in stages]) / DEGREE
    commands = targets - np.array([20.0, 30.0])
    for _ in range(40):
        keys = {"engine.intake": "epv"}
        for name, (energise, release) in zip(("command", "stage_2.command"), commands, strict=False):
            keys |= {f"{name}.energise": (energise, "deg"), f"{name}.release": (release, "deg")}
        valves = machine.with_(**keys)
        run = _run(valves)
        found = [run.traces[f"valve_{event}_deg"].values[-1] for event in ("open", "close")]
        miss = (np.column_stack(found) - targets + 180.0) % 360.0 - 180.0
        if np.abs(miss).max() < 0.01:
            return valves, run, commands
        commands = commands - DAMPED * miss
    raise RuntimeError(f"the commands do not settle: {miss}")


def _valve_table(cut_offs):
    """One and two stages with valves in place of cams."""
    rows = []
    for pressure in SHOWN:
        one = _machine(pressure, 1).with_(engine_intake="epv")
        two = _machine(pressure, 2).with_(engine_intake="epv")
        suited_one, _ = _suited(pressure, 1)
        cases = {
            "one stage, commands −5° and 70°": (None, one),
            "two stages, commands −5° and 70°": (None, two),
            "one stage, as the suited cam": (_machine(pressure, 1, suited_one), None),
            "two stages, as the suited cams": (_machine(pressure, 2, cut_offs[pressure]), None),
        }
        for name, (cams, valves) in cases.items():
            run, commands, works = None, None, "–"
            if cams is None:
                run = _run(valves)
            else:
                _, run, commands = _with_valves(cams)
                works = WORK(_read(_run(cams)))
            engine, control = (
                1e3 * run.traces[f"revolution_{key}"].values[-1] for key in ("engine_air", "control_air")
            )
            texts = ["–", "–"]
            if commands is not None:
                texts = [f"{energise:.1f}, {release:.1f}".replace("-", "−") for energise, release in commands] + ["–"]
            row = [f"{pressure:g}", name, *texts[:2], Number(engine, "g", error=0.005)]
            work = _read(run)
            row += [Number(control, "g", error=0.005), WORK(work), WORK(work * (1.0 + control / engine)), works]
            rows.append([*row, "yes" if run.traces["full_lift"].values[-1].all() else "no"])
    heads = ["supply [MPa gauge]", "machine", "commands of stage 1 [°]", "of stage 2 [°]", "engine air a turn [g]"]
    return Table(
        [
            *heads,
            "control air a turn [g]",
            "work [J/g]",
            "over engine air alone [J/g]",
            "of the cams [J/g]",
            "full lift",
        ],
        rows,
    )


def _other_table():
    """What else moves the work with the stated cams."""
    cases = {
        "as stated: phase 180°, 2 L, first exhaust closes at 340°": {},
        "phase 0°": {"stage_2_phase": "0 deg"},
        "phase 90°": {"stage_2_phase": "90 deg"},
        "phase 270°": {"stage_2_phase": "270 deg"},
        "inter-receiver of 0.5 L": {"inter_receiver_volume": "0.5 L"},
        "inter-receiver of 8 L": {"inter_receiver_volume": "8 L", "turns": 4 * TURNS},
        "first exhaust closes at 350°": {"engine_exhaust_closes": "350 deg"},
    }
    rows = [[name, *(WORK(_work(pressure, 2, **keys)) for pressure in SHOWN)] for name, keys in cases.items()]
    return Table(["machine", *(f"{pressure:g} MPa [J/g]" for pressure in SHOWN)], rows)


def _claims(stated, values):
    """What the model's description says of two stages, and what is measured here."""
    ends, suited = (f"{values[key].text} gauge" for key in ("break_even", "break_even_suited"))
    one, two = (WORK(stated[stages][0]).digits for stages in (1, 2))
    return Table(
        ["claim", "claimed", "measured here", "verdict"],
        [
            ["work per gram at 1 MPa, two stages and one", "69, 113 J/g", f"{two}, {one} J/g", "confirmed"],
            ["break-even", "near 3 MPa", ends, "lower than that"],
            [
                "two stages do not pay at 1 MPa",
                "",
                f"they pay from {suited} on",
                "contradicted: so only with cams that end at 70°",
            ],
        ],
    )


def _shift():
    """Work of second cylinders that draw at different times from an inter-receiver that nothing else draws from."""
    works = [_work(1.0, 2, stage_2_phase=(phase, "deg")) for phase in (0.0, 60.0)]
    return {"shift": Number(1e9 * abs(works[1] / works[0] - 1.0), "·\u00a010⁻⁹", error=5.0)}


# The inter-receiver over a turn ------------------------------------------------------------------------------------


def _turn(pressure, cut_offs):
    """Pressures [MPa abs], volumes [L] and the inter-receiver's temperature [K] over the last turn [deg]."""
    machine = _machine(pressure, 2, cut_offs)
    run = _run(machine, sample="0.1 ms")
    last = slice(-round(60.0 / SPEED / 1e-4) - 1, None)
    traces = {key: trace.values[last] for key, trace in run.traces.items() if trace.dims[0] == "time"}

    # Its mass at the end is in the state; before, it follows from what flows in and out.
    p, y, mode = prepare(machine, 0.0).p, run.march.y, run.march.mode
    content, state = receiver_gas(block_of(y, 1)), receiver_in(p, y, mode, 1)
    flow = traces["exhaust_flow"][:, 0] - traces["groove_flow"][:, 1]
    passed = np.append(0.0, np.cumsum(0.5 * (flow[1:] + flow[:-1]) * np.diff(traces["time"])))
    mass = content.mass + passed - passed[-1]
    between = traces["receiver_pressure"][:, 1]
    constant = state.pressure * machine.inter_receiver.volume / (content.mass * state.temperature)
    return {
        "angle": traces["angle_deg"] - traces["angle_deg"][0],
        "volumes": 1e3 * traces["cylinder_volume"],
        "pressures": traces["cylinder_pressure"] / 1e6,
        "temperatures": traces["cylinder_temperature"],
        "between": between / 1e6,
        "temperature": between * machine.inter_receiver.volume / (mass * constant),
        "open": abs(passed[-1]) / content.mass,
        "cut_offs": cut_offs,
    }


def _turn_values(turns):
    """Extremes over a turn at 3 MPa."""
    values = {}
    for name, turn in turns.items():
        for end, extreme in (("least", min), ("most", max)):
            values[f"{name}.pressure.{end}"] = Number(extreme(turn["between"]), "MPa", error=0.005)
            values[f"{name}.temperature.{end}"] = Number(extreme(turn["temperature"]), "K", error=0.5)
        values[f"{name}.open"] = Number(1e6 * turn["open"], "·\u00a010⁻⁶", error=50.0)
        for stage, column in (("first", 0), ("second", 1)):
            coldest = turn["temperatures"][:, column].min() - 273.15
            values[f"{name}.coldest_{stage}"] = Number(coldest, "°C", error=0.5)
            values[f"{name}.peak_{stage}"] = Number(turn["pressures"][:, column].max(), "MPa", error=0.005)
    one = _run(_machine(3.0, 1), sample="0.1 ms").traces["cylinder_temperature"].values[-1000:].min()
    return values | {"one.coldest": Number(one - 273.15, "°C", error=0.5)}


# Figures -----------------------------------------------------------------------------------------------------------


def _draw_work(stated, suited):
    figure = Figure(figsize=(6.5, 4.2), layout="constrained")
    ax = figure.subplots()
    for stages, colour, marker in ((1, RED, "o"), (2, BLUE, "s")):
        name = ("one stage", "two stages")[stages - 1]
        look = {"color": colour, "marker": marker, "ms": 5}
        ax.plot(PRESSURES, stated[stages], ls="--", mfc="white", **look, label=f"{name}, cams end at 70°")
        ax.plot(LOW_PRESSURES, [work for _, work in suited[stages]], **look, label=f"{name}, cut-offs that suit")
    ax.set(xlabel="supply pressure [MPa gauge]", ylabel="brake work over all air [J/g]", xlim=(0.0, 6.2))
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


def _draw_sizes(one, exchangers, bores):
    figure = Figure(figsize=(6.5, 7.6), layout="constrained")
    left, right = figure.subplots(2, 1)
    left.plot(PRESSURES, one, color=RED, ls="--", marker="o", mfc="white", ms=4, label="one stage")
    for number, (effectiveness, works) in enumerate(exchangers.items()):
        look = {"color": colours_of(4)[number], "ls": STYLES[number], "marker": MARKERS[number + 1]}
        left.plot(PRESSURES, works, **look, ms=4, label=f"two stages, effectiveness {effectiveness:g}")
    left.set(xlabel="supply pressure [MPa gauge]", ylabel="brake work over all air [J/g]")
    left.legend(loc="lower right")
    for number, (pressure, works) in enumerate(bores.items()):
        look = {"color": colours_of(4)[number], "ls": STYLES[number], "marker": MARKERS[number]}
        name = "3 MPa, cut-offs that suit" if pressure == "suited" else f"{pressure:g} MPa, cams end at 70°"
        right.plot(BORES, works, **look, label=name)
    right.set(xlabel="bore of the second cylinder [mm]", ylabel="brake work over all air [J/g]")
    right.legend(loc="lower right")
    return figure


def _draw_indicator(turns):
    """Pressure over volume of both cylinders at 3 MPa, logarithmic."""
    figure = Figure(figsize=(6.5, 3.9), layout="constrained")
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, turn in zip(axes, turns.values(), strict=True):
        for column, (stage, colour, ls) in enumerate((("first", RED, "-"), ("second", BLUE, "--"))):
            ax.loglog(
                turn["volumes"][:, column],
                turn["pressures"][:, column],
                color=colour,
                ls=ls,
                lw=1.4,
                label=f"{stage} cylinder",
            )
        ends = " and ".join(f"{angle:.0f}°" for angle in turn["cut_offs"])
        ax.set(title=f"cams end at {ends}", xlabel="volume [L]")
    axes[0].set_ylabel("pressure [MPa abs]")
    for ax in axes:
        ax.set_xticks([0.05, 0.1, 0.2, 0.5, 1.0], ["0.05", "0.1", "0.2", "0.5", "1"])
        ax.set_yticks([0.1, 0.2, 0.5, 1.0, 2.0, 4.0], ["0.1", "0.2", "0.5", "1", "2", "4"])
        ax.minorticks_off()
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


def _draw_between(turns):
    """Pressure and temperature of the inter-receiver over a turn at 3 MPa."""
    figure = Figure(figsize=(6.5, 4.8), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True)
    for turn, colour, ls in zip(turns.values(), (RED, BLUE), ("-", "--"), strict=True):
        ends = " and ".join(f"{angle:.0f}°" for angle in turn["cut_offs"])
        axes[0].plot(turn["angle"], turn["between"], color=colour, ls=ls, label=f"cams end at {ends}")
        axes[1].plot(turn["angle"], turn["temperature"], color=colour, ls=ls)
    axes[0].set(ylabel="pressure [MPa abs]")
    axes[1].set(
        xlabel="angle of the first cylinder [°]", ylabel="temperature [K]", xlim=(0, 360), xticks=range(0, 361, 60)
    )
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure
