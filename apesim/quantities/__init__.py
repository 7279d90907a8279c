"""Quantities: numbers with their units, read strictly and printed without loss.

A parameter is declared once, in the annotation of a field of a parameter class::

    class Valve(NamedTuple):
        stroke: Annotated[float, Quantity("mm", 1, 50, "Table 1")] = 9e-3

Inside, all values are SI. A text is converted in exact rational arithmetic and rounded once: "9 mm^2" is the
very float that ``9.0e-6`` is in code, and every float has a text that reads back as itself.

The files, each of which imports only those before it: `input_errors` (what is reported of bad input), `names` (single
names of units), `units`, `files` (their text and columns), `old_names` (words that are still read), `declarations`
(what a parameter may be), `curves` (two columns of numbers), `ranges` (single texts, ranges, lists), `lists` (several
numbers in one key), `arguments` (of a call from Python), `trees` (parameter classes in one another), `uncertainties`
(how far a number is known), `toml_text` (what is wrong with a text that is no TOML), `printing`, `reading` (a tree from
parsed TOML), `checking` (a tree made in Python) `settings` (a tree from a file, a command line or another tree) and
`overrides` (tables with other values for some keys of a tree). Whoever reads or prints whole trees imports
`apesim.quantities.settings`.
"""

from apesim.quantities.arguments import Arguments
from apesim.quantities.curves import NO_CURVE, Curve
from apesim.quantities.declarations import Choice, Pressure, Quantity
from apesim.quantities.files import split_header, text_of
from apesim.quantities.input_errors import Fault, InputError, InvalidValue, make_fault, quoted
from apesim.quantities.lists import NO_LIST, QuantityList
from apesim.quantities.ranges import parse, parse_range
from apesim.quantities.units import unit

__all__ = [
    "NO_CURVE",
    "NO_LIST",
    "Arguments",
    "Choice",
    "Curve",
    "Fault",
    "InputError",
    "InvalidValue",
    "Pressure",
    "Quantity",
    "QuantityList",
    "make_fault",
    "parse",
    "parse_range",
    "quoted",
    "split_header",
    "text_of",
    "unit",
]
