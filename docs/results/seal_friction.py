"""Force on a pneumatic cylinder that a laboratory measured: which friction is missing, and what is left unexplained."""

from pathlib import Path

import numpy as np

import apesim
from apesim.studies.drawing.panels import label_axes, open_panels
from apesim.studies.drawing.style import BLUE, GREY, RED
from apesim.studies.measured import read_measured
from docs.results import Number, Table

LONG = True
DOCS = Path(__file__).parent.parent
DATA = DOCS / "examples" / "data"
FOLDERS = {"o_ring": DATA / "cylinder_o_ring", "x_ring": DATA / "cylinder_x_ring"}
FIGURES = DOCS / "missing_effect"
FITTED = "1_bar.csv", "5_bar.csv"
"""Records that the friction is fitted to; nothing is fitted to the others."""
AGAIN = "reconnected"
"""Beginning of the records of the rig that was taken apart and set up again."""
MODELS = {
    "pressure alone": (),
    "load cell": ("offset", "gain"),
    "Coulomb": ("offset", "gain", "coulomb"),
    "seal": ("offset", "gain", "seal"),
    "Coulomb and seal": ("offset", "gain", "coulomb", "seal"),
    "Stribeck and seal": ("offset", "gain", "stribeck", "seal"),
    "viscous and seal": ("offset", "gain", "seal", "viscous"),
}
"""Terms of each model that is fitted by least squares, without the workflow."""
CHOSEN = "Coulomb and seal"
STRIBECK_SPEED = 0.05
"""Speed of the Stribeck friction, the default of the effect [m/s]."""
UNITS = {"offset": (1.0, "N", 0.005), "gain": (100.0, "%", 0.005), "coulomb": (1.0, "N", 0.005)}
UNITS |= {"stribeck": (1.0, "N", 0.005), "seal": (1e5, "N/bar", 0.005), "viscous": (1.0, "N s/m", 0.5)}
"""Factor, unit and error of each term as it is shown."""
NAMES = {"coulomb": "Coulomb", "stribeck": "Stribeck"}
"""Terms that begin with the name of a person."""
SHOWN = "1_bar.csv", "3_bar.csv", "7_bar.csv", "reconnected_7_bar.csv"
"""Records of the O-ring that are drawn over the stroke."""


def compute():
    """What the records hold by least squares, and what the workflow says of them."""
    values, all_records = {}, {}
    for name, folder in FOLDERS.items():
        machine = apesim.Machine.load(folder / "machine.toml")
        all_records[name] = records = read_records(folder, machine)
        values |= {f"{name}.{key}": value for key, value in describe_records(records).items()}
        values |= {f"{name}.{key}": value for key, value in describe_workflow(machine, folder).items()}
    draw_strokes(all_records["o_ring"])
    draw_friction(all_records)
    return values


def read_records(folder, machine):
    """The ways to and fro of each record, by its file: what is given, the force, and that of the pressure alone."""
    records = {}
    for run in read_measured(folder, machine.ambient.pressure).runs:
        pressure = run.given["pressure"] - machine.ambient.pressure
        way = {"stroke": run.given["stroke"], "velocity": run.given["velocity"], "pressure": pressure}
        way |= {"force": run.channels["force"], "ideal": machine.rig.piston_area * pressure}
        records.setdefault(run.data, []).append(way)
    return records


def columns(ways, terms):
    """Columns of a linear model, one below the other for all ways, and the force that it has to explain."""
    way = {key: np.concatenate([each[key] for each in ways]) for key in ways[0]}
    sign = np.sign(way["velocity"])
    all_columns = {
        "offset": np.ones(len(sign)),
        "gain": way["ideal"],
        "coulomb": sign,
        "stribeck": sign * np.exp(-((way["velocity"] / STRIBECK_SPEED) ** 2)),
        "seal": sign * way["pressure"],
        "viscous": way["velocity"],
    }
    return np.array([all_columns[term] for term in terms]).reshape(len(terms), len(sign)).T, way["force"] - way["ideal"]


def fit(ways, terms):
    """Least squares, and standard errors by leaving one way after the other out (jackknife), as ways drift."""
    best, n = solve(ways, terms), len(ways)
    others = [solve(ways[:k] + ways[k + 1 :], terms) for k in range(n)]
    return best, np.sqrt((n - 1) * np.mean((np.array(others) - best) ** 2, axis=0))


def solve(ways, terms):
    """Weights of the terms by least squares."""
    if not terms:
        return np.empty(0)
    matrix, force = columns(ways, terms)
    scale = np.linalg.norm(matrix, axis=0)
    return np.linalg.lstsq(matrix / scale, force, rcond=None)[0] / scale


def fitted_ways(records):
    """Ways of the records that the models are fitted to."""
    return [way for file in FITTED for way in records[file]]


def remainder(ways, terms, weights):
    """What a model leaves, one way behind the other [N]."""
    matrix, force = columns(ways, terms)
    return force - matrix @ weights


def rms(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def describe_records(records):
    """Numbers and tables of the records, by least squares."""
    fitted = fitted_ways(records)
    fits = {model: fit(fitted, terms) for model, terms in MODELS.items()}
    matrix, _ = columns(fitted, ("coulomb", "viscous", "stribeck"))
    cosines = (matrix.T @ matrix)[0] / np.linalg.norm(matrix, axis=0) / np.linalg.norm(matrix[:, 0])
    terms, (weights, errors) = MODELS[CHOSEN], fits[CHOSEN]
    values = {"ways": Number(len(records[FITTED[0]])), "what_is_there": describe_what_is_there(records)}
    values |= {"gap": describe_gap(records, fits), "weights": describe_weights(fits)}
    values |= {"left": describe_left(records, terms, weights)}
    values |= {"cosine_viscous": Number(cosines[1], error=0.005), "cosine_stribeck": Number(cosines[2], error=0.0005)}
    for term, weight, error in list(zip(terms, weights, errors, strict=True))[2:]:
        factor, unit, digits = UNITS[term]
        values |= {term: Number(factor * weight, unit, digits), f"{term}_error": Number(factor * error, unit, digits)}
    for name in ("3_bar", "7_bar"):
        ways = records[f"{name}.csv"]
        values[f"{name}.before"] = Number(rms(remainder(ways, (), np.empty(0))), "N", 0.005)
        values[f"{name}.after"] = Number(rms(remainder(ways, terms, weights)), "N", 0.005)
    return values | describe_set_up(records, terms, weights)


def describe_what_is_there(records):
    """Half of the difference between the directions, their mean, and the speeds, of each record."""
    rows = []
    for file, ways in records.items():
        pushed = ways[0]["velocity"] > 0.0
        gap = remainder(ways, (), np.empty(0)).reshape(len(ways), -1)
        speed = 1e3 * np.array([way["velocity"] for way in ways])
        pressure = 1e-5 * np.array([way["pressure"] for way in ways])
        halves = 0.5 * (gap[:, pushed].mean(axis=1) - gap[:, ~pushed].mean(axis=1))
        means = 0.5 * (gap[:, pushed].mean(axis=1) + gap[:, ~pushed].mean(axis=1))
        rows.append(
            [
                name_record(file),
                f"{Number(pressure[:, pushed].mean(), error=0.005).digits}; "
                f"{Number(pressure[:, ~pushed].mean(), error=0.005).digits}",
                f"{Number(speed[:, pushed].mean(), error=0.05).digits}; "
                f"{Number(-speed[:, ~pushed].mean(), error=0.05).digits}",
                Number(halves.mean(), error=0.005),
                Number(halves[-1] - halves[0], error=0.005),
                Number(means.mean(), error=0.005),
            ]
        )
    heads = ["record", "pressure against it; with it [bar gauge]", "speed against it; with it [mm/s]"]
    heads += ["friction [N]", "friction, last less first way [N]", "mean of both directions [N]"]
    return Table(heads, rows)


def name_record(file):
    """A record in words."""
    pressure = file.removesuffix(".csv").removeprefix(f"{AGAIN}_").replace("_", " ")
    return f"{pressure}, set up again" if file.startswith(AGAIN) else pressure


def describe_gap(records, fits):
    """What each model leaves of each record; all are fitted to the same records."""
    rows = []
    for file, ways in records.items():
        use = "fitted" if file in FITTED else "nothing fitted"
        left = [rms(remainder(ways, terms, fits[model][0])) for model, terms in MODELS.items()]
        rows.append([name_record(file), use, *(Number(value, error=0.005) for value in left)])
    return Table(["record", "use", *(f"{model} [N]" for model in MODELS)], rows)


def describe_weights(fits):
    """The terms of each model, with their standard errors."""
    rows = []
    for model, (weights, errors) in fits.items():
        cells = dict.fromkeys(UNITS, "–")
        for term, weight, error in zip(MODELS[model], weights, errors, strict=True):
            factor, _, digits = UNITS[term]
            shown, spread = (Number(factor * number, error=digits).digits for number in (weight, error))
            cells[term] = f"{shown} ± {spread}"
        if MODELS[model]:
            rows.append([model, *cells.values()])
    return Table(["model", *(f"{NAMES.get(term, term)} [{unit}]" for term, (_, unit, _) in UNITS.items())], rows)


def describe_left(records, terms, weights):
    """What is left of each record, and its parts, whose squares add up."""
    rows = []
    for file, ways in records.items():
        left = remainder(ways, terms, weights).reshape(len(ways), -1)
        pushed = ways[0]["velocity"] > 0.0
        middles = left[:, pushed].mean(), left[:, ~pushed].mean()
        pattern = left.mean(axis=0) - np.where(pushed, *middles)
        parts = [rms(left), 0.5 * abs(middles[0] - middles[1]), 0.5 * abs(middles[0] + middles[1])]
        parts += [rms(pattern), rms(left - left.mean(axis=0))]
        rows.append([name_record(file), *(Number(part, error=0.005) for part in parts)])
    heads = ["left [N]", "friction [N]", "mean of both directions [N]", "pattern over the stroke [N]"]
    return Table(["record", *heads, "differs from way to way [N]"], rows)


def describe_set_up(records, terms, weights):
    """The other set-up with the friction held: its load cell alone fitted anew, and its own friction beside."""
    ways = [way for file, each in records.items() if file.startswith(AGAIN) for way in each]
    if not ways:
        return {}
    held = [way | {"force": way["force"] - force} for way, force in zip(ways, friction_of(ways, weights), strict=True)]
    tare = solve(held, terms[:2])
    own = solve(ways, terms)
    values = {
        "set_up.before": Number(rms(remainder(ways, (), np.empty(0))), "N", 0.005),
        "set_up.as_fitted": Number(rms(remainder(ways, terms, weights)), "N", 0.005),
        "set_up.load_cell_anew": Number(rms(remainder(held, terms[:2], tare)), "N", 0.005),
        "set_up.all_anew": Number(rms(remainder(ways, terms, own)), "N", 0.005),
    }
    for term, weight in list(zip(terms, own, strict=True))[2:]:
        factor, unit, digits = UNITS[term]
        values[f"set_up.{term}"] = Number(factor * weight, unit, digits)
    return values


def friction_of(ways, weights):
    """Friction of each way by the fitted model [N]."""
    _, _, *friction = MODELS[CHOSEN]
    return [columns([way], friction)[0] @ weights[2:] for way in ways]


def describe_workflow(machine, folder):
    """What the workflow says, and what it tried."""
    found = apesim.explain(machine, folder)
    tried = [
        [" with ".join(f"`{name}`" for name in choice.names), Number(choice.cost, error=5.0)]
        for choice in found.fits[:6]
    ]
    noises = [noise.deviation for sensors in found.noise.values() for noise in sensors.values()]
    scores = [[f"`{score.name}`", Number(score.n_sigma, error=0.5)] for score in found.scores[:4]]
    return {
        "verdict": Table(["verdict", "reason"], [[f"`{found.verdict}`", str(found.reason)]]),
        "tried": Table(["effects added", "penalised sum of squares"], tried),
        "scores": Table(["effect", "score [sigmas]"], scores),
        "noise_least": Number(min(noises), "N", 0.005),
        "noise_most": Number(max(noises), "N", 0.005),
    }


def draw_strokes(records):
    """Draw the force less that of the pressure over the stroke, with the model before and after."""
    weights = solve(fitted_ways(records), MODELS[CHOSEN])
    figure, panels = open_panels(2, 2, (9.2, 6.4), sharex=True, sharey=True)
    for axis, file in zip(panels.flat, SHOWN, strict=True):
        for number, way in enumerate(records[file]):
            matrix, gap = columns([way], MODELS[CHOSEN])
            labels = ("measured", "pressure alone", "with Coulomb and seal friction") if not number else (None,) * 3
            axis.plot(1e3 * way["stroke"], gap, ".", ms=2, color="0.55", label=labels[0])
            for part in (way["velocity"] > 0.0, way["velocity"] < 0.0):
                axis.plot(1e3 * way["stroke"][part], 0.0 * gap[part], color=RED, lw=1.2, label=labels[1])
                axis.plot(1e3 * way["stroke"][part], (matrix @ weights)[part], color=BLUE, lw=0.8, label=labels[2])
                labels = (None,) * 3
        axis.set_title(f"{name_record(file)} ({'fitted' if file in FITTED else 'nothing fitted'})", loc="left")
    for axis in panels[-1]:
        label_axes(axis, x=("stroke", "mm"))
    for axis in panels[:, 0]:
        label_axes(axis, y=("force less p A", "N"))
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, markerscale=4)
    figure.savefig(FIGURES / "seal_friction_stroke.png", dpi=120)


def draw_friction(all_records):
    """Draw half of the difference between the directions, and their mean, over the pressure, with the models."""
    figure, panels = open_panels(1, 2, (9.2, 4.2))
    looks = {
        ("o_ring", False): ("o", BLUE, "O-ring"),
        ("o_ring", True): ("^", GREY, "O-ring, set up again"),
        ("x_ring", False): ("s", RED, "X-ring"),
    }
    for name, records in all_records.items():
        weights = solve(fitted_ways(records), MODELS[CHOSEN])
        area = next(way["ideal"][0] / way["pressure"][0] for way in fitted_ways(records))
        bars = np.array([0.5, 7.5])
        colour = looks[name, False][1]
        panels[0, 0].plot(bars, weights[2] + weights[3] * 1e5 * bars, color=colour, lw=1.0)
        panels[0, 1].plot(bars, weights[0] + weights[1] * 1e5 * area * bars, color=colour, lw=1.0)
        for file, ways in records.items():
            mark, colour, _ = looks[name, file.startswith(AGAIN)]
            pushed = ways[0]["velocity"] > 0.0
            gap = remainder(ways, (), np.empty(0)).reshape(len(ways), -1)
            inward, outward = gap[:, pushed].mean(axis=1), gap[:, ~pushed].mean(axis=1)
            bar = 1e-5 * np.mean([way["pressure"].mean() for way in ways])
            for axis, each in zip(panels[0], (0.5 * (inward - outward), 0.5 * (inward + outward)), strict=True):
                ends = np.array([[each.mean() - each.min()], [each.max() - each.mean()]])
                fill = colour if file in FITTED else "white"
                axis.errorbar(bar, each.mean(), ends, fmt=mark, color=colour, mfc=fill, ms=6, capsize=2, lw=1.0)
    label_axes(panels[0, 0], x=("pressure", "bar gauge"), y=("friction", "N"))
    label_axes(panels[0, 1], x=("pressure", "bar gauge"), y=("mean of both directions", "N"))
    for axis in panels[0]:
        axis.set_xlim(0.0, 7.8)
        axis.set_ylim(bottom=0.0)
    for mark, colour, label in looks.values():
        panels[0, 0].plot([], [], mark, color=colour, mfc="white", label=f"{label}, nothing fitted")
        if "again" not in label:
            panels[0, 0].plot([], [], mark, color=colour, label=f"{label}, fitted")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(FIGURES / "seal_friction_pressure.png", dpi=120)
