"""Page in an FMU: what its variables are, and what was fixed at export."""

from collections.abc import Iterable, Sequence
from html import escape

from apesim.studies.fmu.description import identifier_of, si_name
from apesim.studies.fmu.model import Model
from apesim.studies.fmu.parameters import Parameter


def page(model: Model, parameters: Sequence[Parameter], fixed: Sequence[Parameter], machine: str, version: str) -> str:
    """Write the page of a model as HTML, with the machine file as text."""
    name = identifier_of(model)
    inputs = _table(
        ("input", "unit", "start", "what"), ((v.name, v.unit, f"{v.start:.9g}", v.text) for v in model.inputs)
    )
    outputs = _table(("output", "unit", "what"), ((v.name, v.unit, v.text) for v in model.outputs))
    free = _table(("parameter", "unit", "value"), map(_row, parameters))
    kept = _table(("key", "unit", "value"), map(_row, fixed))
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title>
<style>body {{ font: 15px sans-serif; max-width: 50em; margin: 2em auto; padding: 0 1em }}
td, th {{ text-align: left; padding: .1em 1em .1em 0; vertical-align: top }}
table {{ margin-bottom: 1em }} pre {{ overflow: auto }}</style></head>
<body><h1>{name}</h1>
<p>Made by apesim {escape(version)}: the {model.kind} of the machine below, for co-simulation. Values are in SI
units, pressures absolute.</p>
<h2>Inputs and outputs</h2>{inputs}{outputs}
<h2>Parameters</h2><p>They can be set before initialization ends.</p>{free}
<h2>Fixed at export</h2><p>These numbers, all curves, and every other key of the machine are as they were at export.</p>
{kept}<h2>Machine</h2><pre>{escape(machine)}</pre></body></html>
"""


def _row(parameter: Parameter) -> tuple[str, str, str]:
    """Cells of a parameter."""
    return parameter.key, si_name(parameter.declaration.unit), f"{parameter.value:.9g}"


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Table of HTML."""
    heads = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{heads}</tr>{body}</table>\n"
