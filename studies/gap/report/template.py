"""The page of a verdict, as a template of Jinja."""

TEMPLATE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ data.verdict }}: {{ data.sentence | unit }}</title>
<style>
body { font: 16px/1.5 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; color: #222; background: #fff;
  max-width: 56rem; margin: 2.5rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.9rem; line-height: 1.25; font-weight: 600; margin: .3rem 0 1rem; text-wrap: balance; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .5rem; border-bottom: 2px solid #222; padding-bottom: .2rem; }
.verdict { font-size: .85rem; font-weight: 700; letter-spacing: .08em; color: #c1440e; }
.facts { display: flex; flex-wrap: wrap; gap: .8rem 2.4rem; margin: 1.2rem 0; }
.fact b { display: block; font-size: 1.5rem; font-weight: 600; line-height: 1.25; }
.fact span { color: #555; font-size: .88rem; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .22rem .9rem .22rem 0; border-bottom: 1px solid #ddd; vertical-align: top; }
th { font-weight: 600; color: #444; }
th:first-child, td:first-child, .left { text-align: left; }
figure { margin: 1rem 0; } figure img { width: 100%; height: auto; }
figcaption, .small { font-size: .88rem; color: #555; }
.columns { columns: 2; column-gap: 2.5rem; } .columns table { break-inside: avoid; width: 100%; }
.warning { border-left: 4px solid #c1440e; padding-left: .8rem; }
.next { border-left: 4px solid #2a6f97; padding-left: .8rem; }
.far { font-weight: 700; color: #c1440e; }
code { font-size: .85em; overflow-wrap: anywhere; }
@media (max-width: 40rem) { .columns { columns: 1; } table { display: block; overflow-x: auto; } }
@media print { body { max-width: none; margin: 0; font-size: 10.5pt; } figure, tr, .fact { break-inside: avoid; }
  h2 { break-after: avoid; } @page { margin: 16mm; } }
</style>
</head>
<body>
<p class="verdict">{{ data.verdict | words }}</p>
<h1>{{ data.sentence | unit }}</h1>
<div class="facts">
{% for row in data.effects %}
<div class="fact"><b>{{ (row | value | unit) or "–" }}</b>
<span>{{ row.key | key }}, {{ row | interval | unit }}</span></div>
{% endfor %}
{% if check %}
<div class="fact"><b>{{ "%.2f" | format(check[0]) }}{% if added %} → {{ "%.2f" | format(check[1]) }}{% endif %}</b>
<span>gap over noise on runs that were never used{{ ", " ~ added if added }}; noise alone: 1.00</span></div>
{% endif %}
</div>
<p>No probability of this statement is given: none has been calibrated.</p>
<p>Why: {{ data.reason }}. Looked at: {{ runs }} runs, {{ sensors | map("words") | join(", ") }}. The chance that noise
alone leaves as much as the model does is {{ data.p_value | chance }}.
{% if data.alarm and data.localised.shares %}
{{ "%.0f" | format(100 * data.localised.shares[0].share) }} % of the gap lives in {{ data.localised.signal | words
}}{% if data.localised.phase %}, {{ data.localised.phase }}{% endif %}.
{% endif %}
</p>
{% if data.nearest %}
<p>What comes nearest:
{% for row in data.nearest %}
{{ row.key | key }} {{ (row | value | unit) or "not held by these data" }}{{ ", " if not loop.last }}
{%- endfor %}.</p>
{% endif %}
{% if data.tabulated %}
{% set table = data.tabulated %}
<p>Added to the machine without a name: {{ table.kind | words }}, as values at fixed nodes. The gap over noise is
{{ "%.2f" | format(table.gap.before) }} without it and {{
"%.2f" | format(table.gap.after) }} with it{% if table.held_out %},
on runs that it was not fitted to {{ "%.2f" | format(table.held_out.before) }} and {{
"%.2f" | format(table.held_out.after) }}{% endif %}.
{% if table.verified is false %}It does not close the gap: {{ table.reason }}.
{% elif table.verified is none %}There are no runs to hold it against.{% endif %}
{% if table.suggestion %}Its form suggests, no more: {{ table.suggestion }}.{% endif %}</p>
{% if figures.latent %}
<figure><img alt="What the table says" src="data:image/svg+xml;base64,{{ figures.latent }}">
<figcaption>What the table says, at its nodes with 95 % intervals; branches that stay at nothing are left out. A node
that the runs do not reach follows its neighbours.</figcaption></figure>
{% endif %}
{% endif %}
{% if data.alternatives %}
<p>Not told from it by these data:
{% for other in data.alternatives %}
<b>{{ other.effects | map("key") | join(" with ") }}</b>
({% for row in other.parameters %}
{{ row.parameter }} {{ row.value | number(row.unit) }}{{ ", " if not loop.last }}
{%- endfor %}){{ "; " if not loop.last else "." }}
{% endfor %}
</p>
{% endif %}
{% for warning in data.warnings %}
<p class="warning">{{ warning }}</p>
{% endfor %}

{% if data.next_test %}
<h2>Next test</h2>
<p class="next">{{ data.next_test.text }}</p>
{% if data.next_test.experiments %}
<table>
<tr><th>experiment</th>
{% for name in data.next_test.experiments[0].deviations %}<th>{{ name | key }}</th>{% endfor %}</tr>
{% for row in data.next_test.experiments[:5] %}
<tr><td>{{ row.text }}</td>
{% for value in row.deviations.values() %}<td>{{ value | number }}</td>{% endfor %}</tr>
{% endfor %}
</table>
<p class="small">Deviations of the noise by which each would be told from {{ data.next_test.truth | key }}, were that
the truth, everything else fitted anew; from 5 on it is told.</p>
{% endif %}
{% endif %}

<h2>The gap{{ ", before and after" if added }}</h2>
<figure><img alt="The gap of each run over the noise" src="data:image/svg+xml;base64,{{ figures.gap }}">
<figcaption>{{ "Runs that were never used are opened once, at the end; nothing is fitted to them."
if unseen else "No run is marked role = \\"check\\": there are no data here that nothing was fitted to." }}
{% if not added %}Nothing was added to the model.{% endif %}</figcaption></figure>
{% if data.held_out and added %}
<p>With the noise taken off, the gap on the runs never used is {{ data.held_out.size_before | number }} of the noise
before and {{ data.held_out.size_after | number }} after.</p>
{% endif %}
{% if means %}
<table>
<tr><th>mean over the cycle</th><th class="left">run</th><th>measured</th><th>calibrated model</th>
{% if added %}<th>{{ added }}</th>{% endif %}<th>noise</th></tr>
{% for label, shown, one in means %}
<tr><td>{{ shown.name }} [{{ shown.unit }}]</td><td class="left">{{ label }}</td>
<td>{{ "%.4g" | format(shown.of(one.block.values[0])) }}</td><td>{{ "%.4g" | format(shown.of(one.before[0])) }}</td>
{% if added %}<td>{{ "%.4g" | format(shown.of(one.after[0])) }}</td>{% endif %}
<td>{{ shown.of(one.noise) | number }}</td></tr>
{% endfor %}
</table>
{% endif %}

{% if figures.overlays %}
<h2>Where they differ most</h2>
<figure><img alt="Measured, and the model"
src="data:image/svg+xml;base64,{{ figures.overlays }}">
<figcaption>Measured, and the model; below what it leaves, over the noise; the grey band is ± 2 deviations of a
sample, the strong line the mean over nine. Shaded: the phases.</figcaption></figure>
{% endif %}

<h2>What is left, signal by signal</h2>
<figure><img alt="Maps of what is left" src="data:image/svg+xml;base64,{{ figures.maps }}">
<figcaption>Each row a signal of a run, each cell the mean of its samples. Noise alone stays pale, within ± 2. * never
used, † used to judge.</figcaption></figure>

<h2>What was tried</h2>
{% if figures.candidates %}
<figure><img alt="Candidates, expected and realised" src="data:image/svg+xml;base64,{{ figures.candidates }}">
<figcaption>The score says beforehand how much of the gap an effect may explain; fitting it, with everything that is
uncertain about the machine, says how much it does.{% if not explanations %} There was no gap to explain, so nothing was
fitted.{% endif %}</figcaption></figure>
{% else %}
<p>Nothing: the whole library was left out.</p>
{% endif %}
{% if explanations %}
<table>
<tr><th>explanation</th><th>part of the gap explained [deviations]</th>
<th>penalised cost above the least{{ ", fitted runs" if judged }}</th>
{% if judged %}<th>with the runs that judge</th>{% endif %}</tr>
{% for row in explanations %}
<tr><td>{{ row.names | map("key") | join(" with ") }}</td><td>{{ row.realised | number }}</td>
<td>{{ "%.1f" | format(row.cost) }}</td>
{% if judged %}<td>{{ "%.1f" | format(row.judged) if row.judged is not none else "-" }}</td>{% endif %}</tr>
{% endfor %}
</table>
<p class="small">Within 9.2 of the least an explanation counts as not told from it{{
", by the last column where it has a number" if judged }}.</p>
{% endif %}

{% if hidden or visible %}
<h2>What these data could not have shown</h2>
{% endif %}
{% if hidden %}
<p>Even at the end of their range these would stay below 5 deviations here, so nothing is said of them:
{% for row in hidden %}
{{ row.effect | words }} ({{ row.range | unit }}){{ "; " if not loop.last else "." }}
{% endfor %}</p>
{% endif %}
{% if visible %}
<p>All others would be seen from these sizes on (5 deviations; kept: the share that is left once the uncertain
numbers of the machine have been fitted):</p>
<div class="columns">
{% for part in visible | slice(2) %}
<table>
<tr><th>effect</th><th>seen from</th><th>kept</th></tr>
{% for row in part %}
<tr><td>{{ row.effect | words }}</td><td>{{ row.limit | number(row.unit) }}</td>
<td>{{ "%.0f" | format(100 * row.kept) }}&nbsp;%</td></tr>
{% endfor %}
</table>
{% endfor %}
</div>
{% if visible | selectattr("class") | list %}
<p>Whatever the data say, these sensors and runs hardly tell (cosine above 0.9):
{% for row in visible | selectattr("class") %}
{{ row.effect | words }} from {{ row["class"] | map("words") | join(", ") }}{{ "; " if not loop.last else "." }}
{% endfor %}</p>
{% endif %}
{% endif %}

<h2>What was calibrated</h2>
<p>Numbers of the machine that are known only so well were fitted within what is known of them. A pull is their shift in
standard deviations of that knowledge; beyond 4 it is itself a finding. Each operating point alone has to lead to the
same value: told is the one that leads farthest from it, and by how many deviations of noise.</p>
<table>
<tr><th>number</th><th>value</th><th>pull</th><th>one point alone</th><th class="left"></th></tr>
{% for row in data.nuisances %}
<tr><td><code>{{ row.key }}</code></td><td>{{ "%.5g" | format(row.value) }} {{ row.unit | unit }}</td>
<td{% if row.deviations | abs > pull %} class="far"{% endif %}>{{ "%+.1f" | format(row.deviations) }}</td>
<td>{{ "%+.1f" | format(row.apart.deviations) if row.apart else "-" }}</td>
<td class="left">{{ row.apart.run if row.apart }}</td></tr>
{% endfor %}
</table>

<h2>Noise</h2>
<table>
<tr><th>sensor</th><th>standard deviation</th><th>colour</th><th>hum</th><th class="left">from</th></tr>
{% for row in data.noise %}
<tr><td>{{ row.sensor | words }}</td>
<td>{{ units[row.sensor].of(row.deviation) | number(units[row.sensor].unit) }}</td>
<td>{{ "of order %d" | format(row.order) if row.order else "white" }}</td>
<td>{{ (row.hum_hz | map("int") | join(" or ") ~ " Hz") if row.hum_hz else "none" }}</td>
<td class="left">{{ row.source }}</td></tr>
{% endfor %}
</table>
<p class="small">The simulator's own error is {{ data.own_error | number }} of the noise of a sample.</p>

<h2>Where this comes from</h2>
<table>
<tr><td>apesim</td><td class="left">{{ version }}, {{ data.simulations }} simulations</td></tr>
{% for name, digest in data.lineage.items() %}
<tr><td>{{ name | words }}</td><td class="left"><code>{{ digest }}</code></td></tr>
{% endfor %}
</table>
<p class="small"><code>machine.toml</code> beside this page is the machine with what was named, or with the table; else
as it was,
<code>verdict.json</code> all numbers, <code>figures/</code> the figures as PDF and PNG.</p>
</body>
</html>
"""
