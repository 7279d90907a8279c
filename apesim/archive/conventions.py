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
    """Return the unit of a variable as other programs parse it, and what it is measured from.

    Units are those of the CF conventions [1]_, in the form that pint parses, too.

    Parameters
    ----------
    unit : str
        Unit by its name here, such as "Pa abs".

    Returns
    -------
    unit : str
        Unit as both UDUNITS and pint parse it.
    reference : str
        "absolute" or "gauge" for a pressure that says so; "" for all others.

    References
    ----------
    .. [1] "NetCDF Climate and Forecast (CF) Metadata Conventions", version 1.11, https://cfconventions.org,
       section 3.1.

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
    """Return the name of a unit here, from its form in a file; the inverse of `cf_unit`.

    `reference` is "absolute", "gauge" or "".

    >>> our_unit("Pa", "absolute"), our_unit("min^-1", "")
    ('Pa abs', 'r/min')
    """
    behind = [name for name, word in REFERENCES.items() if word == reference]
    return " ".join([OUR_UNITS.get(unit, unit), *behind])


def flag_word(meaning: str) -> str:
    """Return the meaning of a code as one word of the characters that ``flag_meanings`` may have.

    The characters are those of the CF conventions [1]_.

    Parameters
    ----------
    meaning : str
        Meaning in words.

    Returns
    -------
    str
        Word with underscores for what may not stand in it.

    References
    ----------
    .. [1] "NetCDF Climate and Forecast (CF) Metadata Conventions", version 1.11, https://cfconventions.org,
       section 3.5.

    Examples
    --------
    >>> flag_word("the machine's own")
    'the_machine_s_own'
    """
    return re.sub(r"[^A-Za-z0-9.+@-]+", "_", meaning).strip("_")


def own_attributes(variable: Variable) -> dict[str, Attribute]:
    """Return the attributes of a variable by itself: unit, what it is, meanings of its codes.

    ``units``, ``long_name``, ``flag_values`` and ``flag_meanings`` are attributes of the CF conventions [1]_,
    ``reference`` and ``meanings`` ours.

    Parameters
    ----------
    variable : Variable
        Variable of an archive.

    Returns
    -------
    dict of str to str or tuple of int
        Attributes by name: texts, and the codes of ``flag_values``.

    References
    ----------
    .. [1] "NetCDF Climate and Forecast (CF) Metadata Conventions", version 1.11, https://cfconventions.org, sections
       3.1, 3.2 and 3.5.

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> own_attributes(speed)
    {'units': 'min^-1', 'long_name': 'speed of the crank'}
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
    """Return the attributes of the dataset of a variable.

    ``coordinates`` is an attribute of the CF conventions [1]_; ``axes``, ``finite`` and ``coordinate`` are ours.

    Parameters
    ----------
    name : str
        Name of the variable.
    variables : mapping of str to Variable
        All variables of the archive, by name.

    Returns
    -------
    dict of str to str, int or tuple of int
        Those of `own_attributes`, its axes and coordinates, and 1 for each of `FLAG_ATTRIBUTES` that it has.

    References
    ----------
    .. [1] "NetCDF Climate and Forecast (CF) Metadata Conventions", version 1.11, https://cfconventions.org, chapter 5.

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> dataset_attributes("torque", archive.variables)
    {'units': 'N m', 'long_name': 'brake torque', 'axes': 'run', 'coordinates': 'speed'}
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
    """Return the names of the coordinates that lie over axes of a variable, of all `variables` of its archive."""
    return [name for name, other in variables.items() if other.coordinate and set(other.dims) <= set(variable.dims)]


def variable_from(values: np.ndarray, attributes: Mapping[str, Attribute]) -> Variable:
    """Return the variable that the values and attributes of a dataset stand for, its unit by our name.

    Texts are decoded. Raises ValueError where an attribute is missing.
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
    """Return the attributes of a whole file, from the provenance of its archive.

    The attributes are those of the CF conventions [1]_.

    Parameters
    ----------
    provenance : mapping of str to str
        Where the results come from; ``created``, ``command``, ``apesim``, ``commit`` and ``title`` are used.

    Returns
    -------
    dict of str to str
        ``Conventions``, ``title``, ``source`` and ``history``; one that is longer than `ATTRIBUTE_BYTES` is left out.

    References
    ----------
    .. [1] "NetCDF Climate and Forecast (CF) Metadata Conventions", version 1.11, https://cfconventions.org,
       section 2.6.

    Examples
    --------
    >>> global_attributes({"apesim": "0.2.0"})["source"]
    'apesim 0.2.0'
    """
    known = {key: provenance.get(key, "") for key in ("created", "command", "apesim", "commit")}
    commit = f", commit {known['commit']}" if known["commit"] else ""
    texts = {
        "Conventions": CONVENTIONS,
        "title": provenance.get("title") or DEFAULT_TITLE,
        "source": f"apesim {known['apesim']}{commit}".strip(),
        "history": f"{known['created']} {known['command']}".strip(),
    }
    return {key: text for key, text in texts.items() if text and len(text.encode()) <= ATTRIBUTE_BYTES}
