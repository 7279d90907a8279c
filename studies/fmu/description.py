"""Description of an FMU: its `modelDescription.xml`, of either version of FMI."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from apesim.quantities.units import Unit, unit
from apesim.studies.fmu.model import Model, Variable
from apesim.studies.fmu.parameters import Parameter

UNIT_NAMES = ("Pa", "N/m", "N s/m", "N m s", "N m s^2", "N m", "W/K", "W/(m^2 K)", "J/(kg K)", "J", "m/s", "rad/s")
"""Derived SI units that have a usual name; others are written by their base units."""
BASE_NAMES = {"meter": "m", "kilogram": "kg", "second": "s", "kelvin": "K", "radian": "rad"}
"""Base units as the standard names them, by our names."""
STEP = {"valve": 1e-4, "engine": 1e-4}
"""Step that an importer is proposed [s]: short against the strokes of a valve."""
STOP = {"valve": 0.1, "engine": 1.0}
"""End of a run that an importer is proposed [s]."""


class Item(NamedTuple):
    """Variable as it stands in a description."""

    name: str
    text: str
    causality: str
    variability: str
    unit: str
    display_unit: str = ""
    start: float | None = None
    low: float | None = None
    high: float | None = None
    is_whole: bool = False


def items_of(model: Model, parameters: Sequence[Parameter], fixed: Sequence[Parameter]) -> list[Item]:
    """List the variables by their value references, from 0 on."""
    return [
        Item("time", "Time", "independent", "continuous", "s"),
        *(_input(variable) for variable in model.inputs),
        *(Item(v.name, v.text, "output", "continuous", name_of(v.unit)) for v in model.outputs),
        *(_parameter(each, "parameter", "fixed", "") for each in parameters),
        *(_parameter(each, "local", "constant", "; fixed at export") for each in fixed),
    ]


def _input(variable: Variable) -> Item:
    """An input."""
    kind = "discrete" if variable.is_whole else "continuous"
    ends = variable.low, variable.high
    return Item(
        variable.name,
        variable.text,
        "input",
        kind,
        name_of(variable.unit),
        "",
        variable.start,
        *ends,
        variable.is_whole,
    )


def _parameter(parameter: Parameter, causality: str, variability: str, note: str) -> Item:
    """A parameter, or a constant: in SI, shown in the unit of the machine file."""
    declaration = parameter.declaration
    low, high = declaration.ends
    si = si_name(declaration.unit)
    shown = name_of(declaration.unit)
    text = f"{parameter.key} of the machine file{note}"
    return Item(
        parameter.key, text, causality, variability, si, "" if shown == si else shown, parameter.value, low, high
    )


def name_of(text: str) -> str:
    """Name of a unit in a description: without blanks.

    >>> name_of("N s/m"), name_of("mm^2")
    ('N.s/m', 'mm2')
    """
    return text.replace("^", "").replace(" ", ".")


def si_name(text: str) -> str:
    """Name of the SI unit that a unit is a multiple of; "" where it is a mere number.

    >>> si_name("mm^3"), si_name("N s/m"), si_name("")
    ('m3', 'N.s/m', '')
    """
    dimension = unit(text).dimension
    if not dimension:
        return ""
    for usual in UNIT_NAMES:
        if unit(usual).dimension == dimension:
            return name_of(usual)
    return name_of(unit(text).si_text)


def _units(items: Sequence[Item], shown: dict[str, str]) -> Iterator[tuple[str, Unit, list[tuple[str, Unit]]]]:
    """SI units of the variables, each with those that they are shown in."""
    for si in sorted({item.unit for item in items} - {""}):
        displays = sorted({item.display_unit for item in items if item.unit == si} - {""})
        yield si, unit(shown[si]), [(name, unit(shown[name])) for name in displays]


def _add_units(root: ElementTree.Element, items: Sequence[Item], parameters: Sequence[Parameter]) -> None:
    """Add the definitions of the units."""
    texts = {name_of(text): text for text in (*UNIT_NAMES, *BASE_NAMES.values(), "deg", "m^2", "m^3", "kg m^2")}
    texts |= {name_of(each.declaration.unit): each.declaration.unit for each in parameters}
    texts |= {si_name(text): unit(text).si_text for text in tuple(texts.values()) if si_name(text) not in texts}
    definitions = ElementTree.SubElement(root, "UnitDefinitions")
    for si, scale, displays in _units(items, texts):
        entry = ElementTree.SubElement(definitions, "Unit", name=si)
        base = {BASE_NAMES[name]: str(power) for name, power in scale.dimension}
        if scale.factor != 1:
            base["factor"] = repr(float(scale.factor))
        ElementTree.SubElement(entry, "BaseUnit", base)
        for name, display in displays:
            display_factor = scale.factor / display.factor
            attributes = {"name": name, "factor": repr(float(display_factor))}
            if display.offset:
                attributes["offset"] = repr(float(-display.offset * display_factor))
            ElementTree.SubElement(entry, "DisplayUnit", attributes)


def _number(value: float) -> str:
    """Number of XML, to the bit."""
    return repr(float(value))


def _value_attributes(item: Item, integer: bool) -> dict[str, str]:
    """Attributes of the type of a variable: unit, range, start."""
    attributes = {}
    if item.unit and not integer:
        attributes["unit"] = item.unit
        if item.display_unit:
            attributes["displayUnit"] = item.display_unit
    for name, value in (("min", item.low), ("max", item.high), ("start", item.start)):
        if value is not None and abs(value) != float("inf"):
            attributes[name] = str(int(value)) if integer else _number(value)
    return attributes


def describe(
    model: Model, parameters: Sequence[Parameter], fixed: Sequence[Parameter], fmi: int, token: str, version: str
) -> bytes:
    """Write the description of a model for a version of FMI, 2 or 3; the bytes of the XML file."""
    items = items_of(model, parameters, fixed)
    identifier = identifier_of(model)
    root = ElementTree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": identifier,
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": f"apesim's {model.kind}, marched by compiled code",
            "generationTool": f"apesim {version}",
            "variableNamingConvention": "structured",
        },
    )
    state = "FMUstate" if fmi == 2 else "FMUState"
    abilities = {
        "modelIdentifier": identifier,
        "canHandleVariableCommunicationStepSize": "true",
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }
    if fmi == 2:
        abilities["canNotUseMemoryManagementFunctions"] = "true"
    ElementTree.SubElement(root, "CoSimulation", abilities)
    _add_units(root, items, [*parameters, *fixed])
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", name="logStatusError", description="What is wrong, and what to do")
    times = {"startTime": 0.0, "stopTime": STOP[model.kind], "stepSize": STEP[model.kind]}
    ElementTree.SubElement(root, "DefaultExperiment", {name: _number(value) for name, value in times.items()})
    variables = ElementTree.SubElement(root, "ModelVariables")
    for reference, item in enumerate(items):
        (_add_variable_2 if fmi == 2 else _add_variable_3)(variables, reference, item)
    _add_structure(root, items, fmi)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def identifier_of(model: Model) -> str:
    """Name of the model, and of its library."""
    return f"apesim_{model.kind}"


def _common(item: Item, reference: int) -> dict[str, str]:
    """Attributes that a variable has in both versions."""
    return {
        "name": item.name,
        "valueReference": str(reference),
        "description": item.text,
        "causality": item.causality,
        "variability": item.variability,
    }


def _add_variable_2(variables: ElementTree.Element, reference: int, item: Item) -> None:
    """Add a variable of FMI 2."""
    entry = ElementTree.SubElement(variables, "ScalarVariable", _common(item, reference))
    kind = "Integer" if item.is_whole else "Real"
    ElementTree.SubElement(entry, kind, _value_attributes(item, item.is_whole))


def _add_variable_3(variables: ElementTree.Element, reference: int, item: Item) -> None:
    """Add a variable of FMI 3."""
    kind = "Int32" if item.is_whole else "Float64"
    ElementTree.SubElement(variables, kind, _common(item, reference) | _value_attributes(item, item.is_whole))


def _add_structure(root: ElementTree.Element, items: Sequence[Item], fmi: int) -> None:
    """Add which variables are outputs; each may depend on everything at the start, and on no input at once later."""
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs = [i for i, item in enumerate(items) if item.causality == "output"]
    if fmi == 2:
        for name in ("Outputs", "InitialUnknowns"):
            group = ElementTree.SubElement(structure, name)
            for i in outputs:
                entry = {"index": str(i + 1)} | ({"dependencies": ""} if name == "Outputs" else {})
                ElementTree.SubElement(group, "Unknown", entry)
        return
    for name in ("Output", "InitialUnknown"):
        for i in outputs:
            entry = {"valueReference": str(i)} | ({"dependencies": ""} if name == "Output" else {})
            ElementTree.SubElement(structure, name, entry)
