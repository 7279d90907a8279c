"""Single names of units, as pint knows them.

To import pint and to read its definitions takes a third of a second. What it once said is kept on disk, as long as
neither pint nor this file is another.
"""

import contextlib
import hashlib
import json
import os
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from pathlib import Path

from apesim.cache import private_folder
from apesim.quantities.culprits import Wrong, quoted


@lru_cache(maxsize=512)
def named(name):
    """What a single name stands for.

    Parameters
    ----------
    name : str
        Letters, nothing else.

    Returns
    -------
    factor : Fraction
        In SI.
    bases : tuple
        Pairs of base unit and exponent.

    Raises
    ------
    Wrong
        It names no unit that numbers are multiplied with.
    """
    kept = _kept()
    if name not in kept:
        kept[name] = _asked(name)
        _keep(kept)
    return kept[name]


@lru_cache(maxsize=1)
def _registry():
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _asked(name):
    """What pint says."""
    wrong = Wrong(f"{quoted(name)} is no known unit")
    if not _registry().parse_unit_name(name):
        raise wrong
    try:
        one, two = (_registry().Quantity(Decimal(n), name).to_base_units() for n in (1, 2))
    except (TypeError, ValueError, ArithmeticError, AttributeError):  # logarithms of Decimals, in many ways
        raise wrong from None
    bases = tuple((str(base), int(power)) for base, power in one.unit_items() if power == int(power))
    linear = abs(two.magnitude / one.magnitude - 2) < 1e-20  # degC is not
    if not linear or len(bases) < len(one.unit_items()):
        raise wrong
    factor = Fraction(one.magnitude)
    # pi is irrational; with the float that math.radians multiplies by, radians(15) and "15 deg" agree.
    return Fraction(float(factor)) if ("radian", 1) in bases else factor, bases


@lru_cache(maxsize=1)
def _said_by():
    """Who said it: this pint, asked by this file."""
    from importlib.metadata import version

    return f"{version('pint')} {hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]}"


@lru_cache(maxsize=1)
def _kept():
    """What is kept on disk, by name; nothing where that cannot be read."""
    folder = private_folder("units")
    try:
        content = json.loads((folder / "units.json").read_text())
        if content["said by"] == _said_by():
            return {name: (Fraction(factor), _pairs(bases)) for name, (factor, bases) in content["units"].items()}
    except Exception:  # there is none, or it is damaged in any way
        pass
    return {}


def _pairs(bases):
    return tuple((str(base), int(power)) for base, power in bases)


def _keep(kept):
    """Keep it on disk, where that can be written."""
    folder = private_folder("units")
    if folder is None:
        return
    content = {"said by": _said_by(), "units": {name: (str(factor), bases) for name, (factor, bases) in kept.items()}}
    own = folder / f"units.{os.getpid()}"
    with contextlib.suppress(OSError):
        own.write_text(json.dumps(content))
        own.replace(folder / "units.json")
