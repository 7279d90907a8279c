"""The EPV paper (doi 10.1631/jzus.A0820373), judged claim by claim: statement, numbers, verdict, range of areas."""

import apesim
from apesim.studies.paper.claims.claim import range_in_words
from apesim.studies.paper.figures import paper_figures
from apesim.studies.paper.friction.friction_map import PAPERS
from apesim.studies.paper.friction.statements import STATEMENTS
from docs.results import HERE, Number, Table

LONG = True
FIGURES = HERE / "paper"
ORDER = ["contradicted", "reproduced", "not computable"]
HEADS = ["the paper says", "the model gives", "the verdict holds for"]


def compute():
    """Tables of the claims by verdict, the map of friction in words, and the figures beside this file."""
    machine = apesim.Machine()
    paper = apesim.repeat_paper(machine)
    FIGURES.mkdir(exist_ok=True)
    for path in paper_figures(paper.model, paper.map, paper.tests, paper.frictions, FIGURES):
        if path.suffix != ".png":
            path.unlink()
    values = {"claims": Number(len(paper.claims))}
    judged = {verdict: [] for verdict in ORDER}
    for claim in paper.claims:
        judged[str(claim.verdict)].append(claim)
    for verdict, claims in judged.items():
        key = verdict.replace(" ", "_")
        values[key] = Number(len(claims))
        values[f"{key}_table"] = Table(HEADS, [_row(claim) for claim in claims])
        values[f"{key}_turning"] = Number(sum(bool(claim.depends_on) for claim in claims))
    frictions = paper.frictions
    values["friction_at_once"] = Number(frictions.max_at_once(PAPERS))
    values["friction_statements"] = Number(len(STATEMENTS))
    values["friction_table"] = Table(
        [
            "the text",
            "what counts as that",
            f"share of conditions at {PAPERS:g} N·s/m [%]",
            "in all conditions up to",
            "in any condition up to",
        ],
        [_friction_row(frictions, statement) for statement in STATEMENTS],
    )
    for key in ("stroke_time", "pressure_inversion"):
        for name, end in (("everywhere", frictions.everywhere(key)), ("anywhere", frictions.anywhere(key))):
            values[f"friction_{key}_{name}"] = Number(float("nan") if end is None else end, "N·s/m")
    values["frictions"] = Number(len(frictions.frictions))
    values["area_lowest"] = Number(float(frictions.areas[0]) * 1e6, "mm²", error=0.05)
    values["area_highest"] = Number(float(frictions.areas[-1]) * 1e6, "mm²", error=0.05)
    return values


def _row(claim):
    """Cells of a claim: what is said and where, what is computed and how it was judged, and for which areas."""
    return [
        f"{_md(claim.claim)}\n\n*{_md(claim.where)}: {_md(claim.paper)}*",
        f"{_md(claim.ours)}\n\n*{_md(claim.remark)}*",
        range_in_words(claim).replace("-", "–"),
    ]


def _md(text):
    """Text that Markdown leaves as it is."""
    return text.translate({ord(mark): f"\\{mark}" for mark in "|<*_"})


def _friction_row(frictions, statement):
    share = 100.0 * float(frictions.holds[statement.key][frictions.row_of(PAPERS)].mean())
    ends = frictions.everywhere(statement.key), frictions.anywhere(statement.key)
    texts = ["at no friction" if end is None else f"{end:g} N·s/m" for end in ends]
    return [_md(statement.text), _md(statement.criterion), Number(share, "%", error=0.5), *texts]
