"""Attributes of the CF conventions, by which other programs understand a variable (https://cfconventions.org).

Units are written as both UDUNITS and pint parse them; a pressure says in an attribute of its own what it is measured
from. Codes carry ``flag_values`` and ``flag_meanings``, results the ``coordinates`` that locate their runs. What
archives of format versions 1 and 2 have, units by our names and axes in the attribute ``dimensions``, is read, too.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from apesim.archive.digests import Attribute
from apesim.archive.records import ATTRIBUTE_BYTES, Variable, codes_of

__all__ = ["CONVENTIONS", "dataset_attributes", "global_attributes", "own_attributes", "variable_from"]

CONVENTIONS = "CF-1.11"
UNITS = {"deg": "degree", "r/min": "min^-1", "kg/kWh": "kg kW^-1 h^-1", "m3": "m^3"}
"""Units that only one of UDUNITS and pint knows by our name, as both parse them; UDUNITS also takes min-1, pint does
not. All others are written by our name."""
OUR_UNITS = {unit: name for name, unit in UNITS.items()}
REFERENCES = {"abs": "absolute", "gauge": "gauge"}
"""What pressures are measured from: behind the unit here, in the attribute ``reference`` there."""
DEFAULT_TITLE = "Simulated runs of an air-powered engine or its electro-pneumatic valve"


def cf_unit(unit: str) -> tuple[str, str]:
    """Unit of a variable as others parse it, and what it is measured from ("" for all but pressures).

    Examples
    --------
    >>> cf_unit("Pa abs"), cf_unit("r/min")
    (('Pa', 'absolute'), ('min^-1', ''))
    """
    name, _, reference = unit.rpartition(" ")
    if name.strip() and reference in REFERENCES:
        return UNITS.get(name, name), REFERENCES[reference]
    return UNITS.get(unit, unit), ""


def our_unit(unit: str, reference: str) -> str:
    """Name of a unit here, from its form in a file; the inverse of `cf_unit`."""
    behind = [name for name, word in REFERENCES.items() if word == reference]
    return " ".join([OUR_UNITS.get(unit, unit), *behind])


def flag_word(meaning: str) -> str:
    """Meaning of a code as one word of the characters that ``flag_meanings`` may have.

    Examples
    --------
    >>> flag_word("the machine's own")
    'the_machine_s_own'
    """
    return re.sub(r"[^A-Za-z0-9.+@-]+", "_", meaning).strip("_")


def own_attributes(variable: Variable) -> dict[str, Attribute]:
    """Attributes of a variable by itself: unit, what it is, meanings of its codes.

    Parameters
    ----------
    variable : Variable

    Returns
    -------
    dict of str
        Texts, and the numbers of ``flag_values``.
    """
    unit, reference = cf_unit(variable.unit)
    attributes: dict[str, Attribute] = {"units": unit, "long_name": variable.description}
    if reference:
        attributes["reference"] = reference
    if variable.meanings:
        codes = codes_of(variable.meanings)
        attributes["meanings"] = variable.meanings
        attributes["flag_values"] = tuple(codes)
        attributes["flag_meanings"] = " ".join(map(flag_word, codes.values()))
    return attributes


def dataset_attributes(name: str, variables: Mapping[str, Variable]) -> dict[str, Attribute]:
    """Attributes of the dataset of a variable.

    Parameters
    ----------
    name : str
    variables : mapping of str to Variable
        All of the archive.

    Returns
    -------
    dict of str
        Those of `own_attributes`, its axes and coordinates, and 1 for each of `FLAG_ATTRIBUTES` that it has.
    """
    variable = variables[name]
    attributes = own_attributes(variable) | {"axes": " ".join(variable.dims)}
    if variable.finite:
        attributes["finite"] = 1
    if variable.coordinate:
        attributes["coordinate"] = 1
    elif variable.dims != (name,) and (located := coordinates_of(variable, variables)):
        attributes["coordinates"] = " ".join(located)
    return attributes


def coordinates_of(variable: Variable, variables: Mapping[str, Variable]) -> list[str]:
    """Names of the coordinates over axes of a variable."""
    return [name for name, other in variables.items() if other.coordinate and set(other.dims) <= set(variable.dims)]


def variable_from(values: np.ndarray, attributes: Mapping[str, Attribute]) -> Variable:
    """Variable of the values of a dataset, texts decoded, and of its attributes.

    Raises
    ------
    ValueError
        An attribute is missing.
    """
    axes = attributes.get("axes", attributes.get("dimensions"))
    if axes is None:
        raise ValueError("has no attribute axes")
    for name in ("long_name", "units"):
        if name not in attributes:
            raise ValueError(f"has no attribute {name}")
    return Variable(
        dims=tuple(str(axes).split(" ")),
        values=values,
        unit=our_unit(str(attributes["units"]), str(attributes.get("reference", ""))),
        description=str(attributes["long_name"]),
        meanings=str(attributes.get("meanings", "")),
        finite="finite" in attributes,
        coordinate="coordinate" in attributes,
    )


def global_attributes(provenance: Mapping[str, str]) -> dict[str, str]:
    """Attributes of a whole file, from the provenance of its archive."""
    known = {key: provenance.get(key, "") for key in ("created", "command", "apesim", "commit")}
    commit = f", commit {known['commit']}" if known["commit"] else ""
    texts = {
        "Conventions": CONVENTIONS,
        "title": provenance.get("title") or DEFAULT_TITLE,
        "source": f"apesim {known['apesim']}{commit}".strip(),
        "history": f"{known['created']} {known['command']}".strip(),
    }
    return {key: text for key, text in texts.items() if text and len(text.encode()) <= ATTRIBUTE_BYTES}
