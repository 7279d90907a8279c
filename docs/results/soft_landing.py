"""Brakes that land the valve's piston softly, at 0.4, 1.0 and 1.6 MPa gauge and 287 K, at a cost of at most 1 ms."""

import apesim
from docs.results import Number, Table
from docs.results._figures import keep

LONG = True


def compute():
    """Softest and sturdiest brakes within 4.17 ms between edges and with any, and how many need both solenoids."""
    machine = apesim.Machine()
    landings = apesim.find_soft_landing(machine)
    keep(landings.draw, fronts="landing_fronts", traces_opening="landing_opening", robustness="landing_robustness")
    both = apesim.find_soft_landing(machine, solenoids="both")
    points = landings.to_dict()["points"]
    return {
        "table": _table(points, machine.ambient.pressure, "within_spacing"),
        "any_table": _table(points, machine.ambient.pressure, "any_spacing"),
        "strokes": Number(len(points)),
        "both.not_found": Number(sum(not point["reachable"] for point in both.to_dict()["points"])),
        **_shares(points),
    }


def _table(points, ambient, spacing):
    heads = ["control pressure [MPa gauge], stroke", "unbraked v_e [m/s]", "lowest speed before contact [m/s]"]
    heads += ["softest brake [ms]", "added [ms]", "v_e [m/s]", "worst v_e [m/s]", "worst added [ms]"]
    heads += ["sturdiest brake [ms]", "v_e [m/s]", "worst v_e [m/s]", "worst added [ms]"]
    rows = []
    for point in points:
        pressure = (point["supply_pressure_Pa"] - ambient) / 1e6
        free, found = point["unbraked"], point[spacing]
        row = [
            f"{pressure:.1f}, {point['stroke']}",
            _speed(free["seating_speed_m_s"]),
            _speed(free["lowest_speed_m_s"]),
        ]
        softest, sturdy = found["softest"], found["sturdy"]
        row += [_edges(softest), _time(softest["added_ms"]), _speed(softest["seating_speed_m_s"]), *_worst(softest)]
        row += [_edges(sturdy), _speed(sturdy["seating_speed_m_s"]), *_worst(sturdy)]
        rows.append(row)
    return Table(heads, rows)


def _edges(brake):
    begin, end = brake["edges_ms"][1:]
    return f"{brake['solenoids'].upper() if len(brake['solenoids']) == 1 else 'both'}, {begin:.2f}…{end:.2f}"


def _worst(brake):
    strays = brake["robustness"]
    return [_speed(max(s["seating_speed_m_s"] for s in strays)), _time(max(s["added_ms"] for s in strays))]


def _speed(value):
    return Number(value, "m/s", error=0.005)


def _time(value):
    return Number(value, "ms", error=0.005)


def _shares(points):
    """Smallest and largest share over all strokes: of speed and energy that is left, nominal and at worst."""
    shares = {"fluctuation_speed": [], "fluctuation_energy": [], "softest_energy": [], "softest_worst_energy": []}
    shares |= {"sturdy_worst_speed": [], "any_speed": [], "any_sturdy_worst_speed": []}
    for point in points:
        free = point["unbraked"]
        speed = free["seating_speed_m_s"]
        softest, sturdy = (point["within_spacing"][key] for key in ("softest", "sturdy"))
        any_softest, any_sturdy = (point["any_spacing"][key] for key in ("softest", "sturdy"))
        left = free["lowest_speed_m_s"] / speed
        if point["stroke"] == "opening":
            shares["fluctuation_speed"].append(1e2 * (1.0 - left))
            shares["fluctuation_energy"].append(1e2 * (1.0 - left**2))
        worst = {name: _worst(brake)[0].value / speed for name, brake in (("softest", softest), ("sturdy", sturdy))}
        shares["softest_energy"].append(1e2 * (softest["seating_speed_m_s"] / speed) ** 2)
        shares["softest_worst_energy"].append(1e2 * worst["softest"] ** 2)
        shares["sturdy_worst_speed"].append(worst["sturdy"])
        shares["any_speed"].append(any_softest["seating_speed_m_s"])
        shares["any_sturdy_worst_speed"].append(_worst(any_sturdy)[0].value / speed)
    units = {"speed": ("", 0.005), "energy": ("%", 0.5)}
    values = {}
    for name, found in shares.items():
        unit, error = units[name.rpartition("_")[2]]
        if name in ("any_speed", "fluctuation_speed"):
            unit, error = ("m/s", 0.005) if name == "any_speed" else ("%", 0.5)
        values |= {
            f"{name}.least": Number(min(found), unit, error=error),
            f"{name}.most": Number(max(found), unit, error=error),
        }
    return values
