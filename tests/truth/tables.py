"""Tables of the benchmark, as Markdown."""

from .library import LIBRARY
from .schedule import DOUBLE, SINGLE
from .score import BLAMING, NAMES, clopper_pearson, figures

EDGES = (0.0, 2.5, 5.0, 10.0, 20.0, 50.0, float("inf"))


def markdown(header, rows):
    """A table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def percent(share):
    return f"{100.0 * share:.1f} %"


def rate(hits, cases):
    """A share with its counts and interval."""
    if not cases:
        return ["–", "0 of 0", "–"]
    low, high = clopper_pearson(hits, cases)
    return [percent(hits / cases), f"{hits} of {cases}", f"{percent(low)} – {percent(high)}"]


def figures_table(scored):
    """Every figure beside its floor and goal."""
    rows = []
    for one in figures(scored):
        if one.value is not None or one.cases == 0:
            cells = ["–" if one.value is None else f"{one.value:.3g}", f"{one.cases} cases", "–"]
        else:
            cells = rate(one.hits, one.cases)
        rows.append([one.what, *cells, one.floor, one.goal])
    return markdown(["figure", "found", "counts", "95 % interval", "floor", "goal"], rows)


def comparison(found):
    """Every figure of several programs, the first with its interval.

    Parameters
    ----------
    found : dict of list of truth.score.Scored
        By the program's name.
    """
    first, *others = found
    rows = []
    for one, *rivals in zip(*map(figures, found.values()), strict=True):
        interval = "–" if one.value is not None or one.cases == 0 else rate(one.hits, one.cases)[2]
        rows.append([one.what, short(one), interval, one.floor, one.goal, *map(short, rivals)])
    return markdown(["figure", first, "95 % interval", "floor", "goal", *others], rows)


def short(figure):
    """A figure in a few characters."""
    if figure.cases == 0:
        return "–"
    if figure.value is not None:
        return f"{figure.value:.3g} ({figure.cases})"
    return f"{percent(figure.hits / figure.cases)} ({figure.hits} of {figure.cases})"


def spoken(one):
    """What a verdict says, for the confusion matrix."""
    return one.first[0] if one.said in NAMES and len(set(one.first)) == 1 else one.said


def confusion(scored):
    """Counts of what was hidden against what was said: names of rows and columns, and rows of counts."""
    cases = [(row_of(one), spoken(one)) for one in scored]
    rows, columns = (
        [*dict.fromkeys(sorted(each, key=order))] for each in ({a for a, _ in cases}, {b for _, b in cases})
    )
    return rows, columns, [[sum(case == (a, b) for case in cases) for b in columns] for a in rows]


def row_of(one):
    """What was hidden, for the confusion matrix."""
    return one.hidden[0] if one.kind == SINGLE else one.kind


def order(name):
    """The library's order, then the rest."""
    names = list(LIBRARY)
    return (names.index(name), "") if name in names else (len(names), name)


def confusion_table(scored):
    """The confusion matrix with a row for each case's kind or effect; what never occurs is left out of the cells."""
    rows, columns, counts = confusion(scored)
    cells = [[name, *(n or "" for n in line)] for name, line in zip(rows, counts, strict=True)]
    return markdown(["hidden \\ said", *columns], cells)


def strata(scored):
    """How often what is hidden was named right, by stratum, among single effects and pairs."""
    hidden = [one for one in scored if one.kind in (SINGLE, DOUBLE)]

    def by(what, key):
        values = sorted({key(one) for one in hidden}, key=str)
        for value in values:
            among = [one for one in hidden if key(one) == value]
            blamed = [one for one in among if one.said in BLAMING]
            named, wrong = sum(bool(one.right) for one in blamed), sum(one.wrong for one in blamed)
            yield [what, value, *rate(named, len(among)), wrong]

    rows = [
        *by("kind", lambda one: one.kind),
        *by("bench", lambda one: one.answer["bench"]),
        *by("sensors", lambda one: one.answer["setting"]["suite"]),
        *by("noise", lambda one: f"× {one.answer['setting']['noise']['scale']:g}"),
        *by("colour", lambda one: one.answer["setting"]["noise"]["colour"]),
        *by("points", lambda one: len(one.answer["setting"]["points"])),
        *by("deviations", lambda one: f"{max(e for e in EDGES if e <= one.deviations):5.3g} and more"),
    ]
    return markdown(["stratum", "", "named right", "counts", "95 % interval", "named wrong"], rows)


def report(scored, missing):
    """The whole page.

    Parameters
    ----------
    scored : sequence of truth.score.Scored
    missing : dict
        Why a seed has no verdict, by seed.
    """
    kinds = {kind: sum(one.kind == kind for one in scored) for kind in dict.fromkeys(one.kind for one in scored)}
    engines = sum(one.answer["bench"] == "engine" for one in scored)
    seeds = [one.answer["seed"] for one in scored]
    parts = [
        "# Blind benchmark",
        f"{len(scored)} cases, seeds {min(seeds)} to {max(seeds)}, {engines} of an engine: "
        + ", ".join(f"{number} {kind}" for kind, number in kinds.items())
        + "."
        + (f" Without a verdict: {', '.join(f'{seed} ({why})' for seed, why in missing.items())}." if missing else ""),
        figures_table(scored),
        "## Named right, by stratum",
        strata(scored),
        "## What was hidden, what was said",
        confusion_table(scored),
    ]
    wrong = [one for one in scored if one.wrong]
    if wrong:
        rows = [
            [
                one.answer["seed"],
                one.kind,
                ", ".join(one.hidden),
                f"{one.deviations:.1f}",
                one.said,
                ", ".join(one.first),
                "–" if one.probability is None else f"{one.probability:.2f}",
            ]
            for one in wrong
        ]
        header = ["seed", "kind", "hidden", "deviations", "verdict", "first", "probability"]
        parts += ["## Wrong", markdown(header, rows)]
    return "\n\n".join(parts) + "\n"
