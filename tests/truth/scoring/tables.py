"""Tables of the benchmark, as Markdown."""

from tests.truth.sealed.library import LIBRARY
from tests.truth.sealed.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE
from tests.truth.sealed.second_case import ALIKE
from tests.truth.sealed.second_schedule import FAULTY, TRIPLE

from .figures import figures, rightly_named
from .score import BLAMING, NAMES, clopper_pearson

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
        if one.is_share:
            cells = rate(one.hits, one.cases)
        else:
            cells = ["–" if one.value is None else f"{one.value:.3g}", f"{one.cases} cases", say_interval(one)]
        rows.append([one.what, *cells, one.floor, one.goal])
    return markdown(["figure", "found", "counts", "95 % interval", "floor", "goal"], rows)


def comparison(found):
    """Every figure of several programs, the first with its interval.

    Parameters
    ----------
    found : dict of list of truth.scoring.score.Scored
        By the program's name.
    """
    first, *others = found
    rows = []
    for one, *rivals in zip(*map(figures, found.values()), strict=True):
        rows.append([one.what, short(one), say_interval(one), one.floor, one.goal, *map(short, rivals)])
    return markdown(["figure", first, "95 % interval", "floor", "goal", *others], rows)


def say_interval(figure):
    """The interval of a figure in a few characters."""
    if figure.interval is None:
        return "–"
    return " – ".join(map(percent, figure.interval)) if figure.is_share else between(figure.interval)


def between(interval):
    """Both ends of an interval of a number."""
    return "{:.2f} to {:.2f}".format(*interval)


def short(figure):
    """A figure in a few characters."""
    if not figure.is_share:
        return "–" if figure.value is None else f"{figure.value:.3g} ({figure.cases})"
    return f"{percent(figure.hits / figure.cases)} ({figure.hits} of {figure.cases})"


def spoken(one):
    """What a verdict says, for the confusion matrix; a name beside a faulty file has the file with it."""
    physics = one.physics
    said = physics.first[0] if physics.said in NAMES and len(set(physics.first)) == 1 else physics.said
    return f"file + {said}" if one.rest else said


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
    """How often what is hidden was named right, by stratum, among all cases that hide something of the library."""
    hidden = [one for one in scored if one.hidden and one.kind in (SINGLE, DOUBLE, TRIPLE, FAULTY)]

    def by(what, key, among=hidden):
        values = sorted({key(one) for one in among}, key=str)
        for value in values:
            inside = [one for one in among if key(one) == value]
            named = sum(map(rightly_named, inside))
            wrong = sum(one.wrong for one in inside if one.said in BLAMING)
            yield [what, value, *rate(named, len(inside)), wrong]

    pairs = [one for one in hidden if one.kind in (DOUBLE, TRIPLE)]
    yes = {True: "yes", False: "no"}
    rows = [
        *by("kind", lambda one: one.kind),
        *by("bench", lambda one: one.answer["bench"]),
        *by("cosine above 0.9", lambda one: yes[one.answer["cosine"] > ALIKE], pairs),
        *by("clutter", lambda one: yes[bool(one.clutter)]),
        *by("scatter of runs", lambda one: yes[bool(one.answer.get("scatter"))]),
        *by("known to: stated", lambda one: yes[bool(one.answer.get("stated"))]),
        *by("sensors", lambda one: one.answer["setting"]["suite"]),
        *by("noise", lambda one: f"× {one.answer['setting']['noise']['scale']:g}"),
        *by("colour", lambda one: one.answer["setting"]["noise"]["colour"]),
        *by("points", lambda one: len(one.answer["setting"]["points"])),
        *by("deviations", lambda one: f"{max(e for e in EDGES if e <= one.deviations):5.3g} and more"),
    ]
    return markdown(["stratum", "", "named right", "counts", "95 % interval", "wrong"], rows)


def faults(scored):
    """How often a faulty file was pointed at, and the rest right, by the kind of fault."""
    faulty = [one for one in scored if one.faulty]
    rows = []
    for kind in sorted({one.fault["kind"] for one in faulty}):
        among = [one for one in faulty if one.fault["kind"] == kind]
        right = sum(one.besides for one in among)
        rows.append(
            [kind, *rate(sum(one.pointed for one in among), len(among)), right, sum(one.wrong for one in among)]
        )
    return markdown(
        ["fault, ≥ 10 sigmas", "pointed at", "counts", "95 % interval", "and the rest right", "wrong"], rows
    )


def outside(scored):
    """What was said where the library does not have what is hidden, near ones apart."""
    rows = []
    for kind in (REMOVED, FOREIGNER):
        for near in (False, True):
            among = [one for one in scored if one.kind == kind and bool(one.answer.get("near")) == near]
            unnamed = sum(not one.named for one in among)
            rows.append([kind, "near" if near else "far", *rate(unnamed, len(among)), sum(one.wrong for one in among)])
    return markdown(["outside", "of the library", "not named", "counts", "95 % interval", "wrong"], rows)


def empty(scored):
    """Alarms, names and wrong statements where nothing is hidden, by what else is in the data."""
    rows = []
    for clutter in (False, True):
        for scatter in (False, True):
            for stated in (False, True):
                among = [
                    one
                    for one in scored
                    if one.kind == NONE
                    and bool(one.clutter) == clutter
                    and bool(one.answer.get("scatter")) == scatter
                    and bool(one.answer.get("stated")) == stated
                ]
                flags = ["yes" if flag else "no" for flag in (clutter, scatter, stated)]
                alarms = sum(bool(one.verdict.get("alarm")) for one in among)
                named, wrong = sum(one.named for one in among), sum(one.wrong for one in among)
                rows.append([*flags, *rate(alarms, len(among)), named, wrong])
    head = ["clutter", "scatter", "known to: stated", "alarms", "counts", "95 % interval", "named", "wrong"]
    return markdown(head, rows)


def report(scored, missing):
    """The whole page.

    Parameters
    ----------
    scored : sequence of truth.scoring.score.Scored
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
        "## Faulty files",
        faults(scored),
        "## Outside the library",
        outside(scored),
        "## Nothing hidden",
        empty(scored),
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
