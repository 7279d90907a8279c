"""The paper's figures and claims on one page."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from typing import Any

import jinja2

from apesim.archive import write_file
from apesim.studies.paper.claims.claim import Claim, range_in_words
from apesim.studies.paper.friction.friction_map import PAPERS, FrictionMap, conditions_in_words
from apesim.studies.paper.friction.statements import STATEMENTS, Statement

TEMPLATE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>The paper, repeated and judged</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(30rem, 100%), 1fr)); gap: 1.5rem; }
figure { margin: 0; } img { width: 100%; } figcaption { font-size: .9rem; color: #444; }
table { border-collapse: collapse; font-size: .92rem; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .4rem .6rem; border-bottom: 1px solid #ddd; }
.verdict { white-space: nowrap; font-weight: 600; }
.reproduced { color: #1b7837; } .contradicted { color: #b2182b; }
.other { border-left: 4px solid #b2182b; padding-left: .8rem; }
.not { color: #666; } small { color: #555; } .depends { background: #fff4d6; }
</style>
<h1>The paper, repeated and judged</h1>
<p><i>Simulation and experimental study of electro-pneumatic valve used in air-powered engine</i>,
<a href="https://doi.org/10.1631/jzus.A0820373">doi 10.1631/jzus.A0820373</a>. Pressures of the control air are
gauge, as in the paper; the equations are used with absolute ones. apesim {{ version }},
<a href="machine.toml">machine.toml</a>.</p>
{% if different %}
<p class="other"><b>Judged on another valve than the paper's:</b> {{ different | join("; ") }}. "Reproduced" means that
this valve does what the paper says of its own, "contradicted" that it does not: that is no verdict on the paper.</p>
{% else %}
<p>Judged on the paper's valve (Table 1), as the machine has it by default.</p>
{% endif %}
<h2>Claims</h2>
<p>
{% for verdict, count in counts.items() %}{{ count }} {{ verdict }}{{ ", " if not loop.last else "." }}{% endfor %}
</p>
<p>The paper does not print the effective area of the solenoids; 9 mm² are chosen. The last column says for which areas,
from a quarter of their 4 mm bore to all of it, a verdict holds; a dash: it has nothing to do with the area.</p>
<table>
<tr><th>where</th><th>the paper</th><th>its number or trend</th><th>the model</th><th>verdict</th>
<th>holds for</th></tr>
{% for claim, held in rows %}
<tr><td>{{ claim.where }}</td><td>{{ claim.claim }}<br><small>{{ claim.remark }}</small></td><td>{{ claim.paper }}</td>
<td>{{ claim.ours }}</td><td class="verdict {{ claim.verdict.split()[0] }}">{{ claim.verdict }}</td>
<td{% if claim.depends_on %} class="depends"{% endif %}>{{ held }}</td></tr>
{% endfor %}
</table>
<h2>What the published friction does not give</h2>
<p>{{ friction.words }}</p>
<table>
<tr><th>the text</th><th>what counts as that</th><th>share of conditions at {{ friction.papers }} N s/m</th>
<th>in all conditions up to [N s/m]</th><th>in any condition up to [N s/m]</th></tr>
{% for row in friction.rows %}
<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}
</table>
<h2>Figures</h2>
<div class="figures">
{% for name, caption in captions.items() %}
<figure><img src="{{ name }}.png" alt="{{ caption }}">
<figcaption>{{ caption }} <a href="{{ name }}.pdf">PDF</a></figcaption></figure>
{% endfor %}
</div>
</html>
"""


def write_page(
    claims: Sequence[Claim],
    captions: Mapping[str, str],
    different: Sequence[str],
    frictions: FrictionMap,
    folder: str | PathLike[str],
) -> Path:
    """Write the page, ``index.html``, beside its figures, into a folder that exists.

    Raises ArchiveError where it cannot be written. `captions` are by name of the figure; `different` has what makes the
    valve another one than the paper's, see `apesim.studies.paper.subject.differences`.
    """
    verdicts = [claim.verdict for claim in claims]
    text = (
        jinja2.Environment(autoescape=True)
        .from_string(TEMPLATE)
        .render(
            rows=[(claim, range_in_words(claim)) for claim in claims],
            friction=_friction(frictions),
            captions=captions,
            different=different,
            counts={verdict: verdicts.count(verdict) for verdict in dict.fromkeys(verdicts)},
            version=version("apesim"),
        )
    )
    path = Path(folder) / "index.html"
    write_file(path, text)
    return path


def _friction(frictions: FrictionMap) -> dict[str, Any]:
    """What the page says of the map of frictions."""
    row = frictions.row_of(PAPERS)

    def cells(statement: Statement) -> tuple[str, ...]:
        share = frictions.holds[statement.key][row].mean()
        ends = frictions.everywhere(statement.key), frictions.anywhere(statement.key)
        return (
            statement.text,
            statement.criterion,
            f"{share:.0%}",
            *("-" if end is None else f"{end:g}" for end in ends),
        )

    return {
        "papers": f"{PAPERS:g}",
        "words": conditions_in_words(frictions),
        "rows": [cells(statement) for statement in STATEMENTS],
    }
