"""Names and units as pages show them: short words, and units in which numbers have few digits."""

from typing import NamedTuple

import numpy as np

from apesim.results import SI_SUFFIXES, UNIT_SUFFIXES

SUFFIXES = ("_kg_per_kWh", "_L_per_min_ANR", "_mm2", "_J_per_g", *SI_SUFFIXES, *UNIT_SUFFIXES.values())
"""How names of archives say their units; the figure says it beside the name."""
SHOWN_UNITS = {
    "Pa abs": (1e-6, "MPa abs"),
    "Pa": (1e-3, "kPa"),
    "m": (1e3, "mm"),
    "m3": (1e6, "cm³"),
    "m^2": (1e6, "mm²"),
    "kg": (1e3, "g"),
    "kg/s": (1e3, "g/s"),
    "W": (1e-3, "kW"),
    "N m": (1.0, "N·m"),
    "1": (1.0, ""),
}
"""Factor and text of the unit in which a page shows numbers of an archive's unit; any other is shown as it is."""
MIN_SPREAD = 1e-5
"""Range of numbers over their size below which they count as equal."""
MAX_MILLISECONDS = 0.5
"""Longest time that is shown in milliseconds [s]."""


class Axis(NamedTuple):
    """What an axis of a figure shows."""

    label: str
    unit: str = ""
    range: tuple[float, float] | None = None
    """Ends of the axis; those of the numbers where None."""

    @property
    def named(self) -> str:
        """Label with its unit in brackets."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    @property
    def data(self) -> dict[str, object]:
        """The axis as the script takes it."""
        return {"label": self.label, "unit": self.unit} | ({"range": list(self.range)} if self.range else {})


class Frames(NamedTuple):
    """What a slider chooses among, such as speeds: a figure shows one at a time."""

    name: str
    texts: tuple[str, ...]
    start: int
    """Frame that is shown first, and in the still picture."""


ONE_FRAME = Frames("", ("",), 0)
"""Frames of a figure that has nothing to choose."""


def find_shown_unit(unit: str, values: np.ndarray | None = None) -> tuple[float, str]:
    """Find factor and text of the unit in which numbers are shown.

    >>> find_shown_unit("Pa abs"), find_shown_unit("s", np.array([6e-3])), find_shown_unit("K")
    ((1e-06, 'MPa abs'), (1000.0, 'ms'), (1.0, 'K'))
    """
    if unit == "s" and values is not None:
        longest = np.max(np.abs(values), where=np.isfinite(values), initial=0.0)
        return (1e3, "ms") if 0.0 < longest < MAX_MILLISECONDS else (1.0, "s")
    return SHOWN_UNITS.get(unit, (1.0, unit))


OWN_WORDS = {
    "pressure_a": "pressure of chamber A",
    "pressure_b": "pressure of chamber B",
    "valve_open_deg": "opening of the valve",
    "valve_close_deg": "closing of the valve",
    "air_L_per_min_ANR": "air flow (ANR)",
}
"""Names that their variable does not say well."""


def shorten_name(name: str) -> str:
    """Write the name of a variable in words, without its unit.

    >>> shorten_name("specific_air_kg_per_kWh"), shorten_name("brake_torque_Nm"), shorten_name("limit_hz")
    ('specific air', 'brake torque', 'limit')
    """
    if name in OWN_WORDS:
        return OWN_WORDS[name]
    suffix = next((suffix for suffix in SUFFIXES if name.endswith(suffix) and name != suffix), "")
    return name.removesuffix(suffix).replace("_", " ")


def format_number(value: float, digits: int = 4) -> str:
    """Write a number in so many digits, with a true minus; "–" where there is none.

    >>> format_number(29.3341), format_number(-0.5), format_number(1480.21), format_number(float("nan"))
    ('29.33', '−0.5', '1480', '–')
    """
    if not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    if "e+" in text:
        text = f"{value:.0f}"
    return text.replace("-", "−")


def spread_ranges(values: np.ndarray, share: float = 0.05) -> tuple[float, float] | None:
    """Find the ends of an axis that shows all finite numbers with some room; None where there are none."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return None
    low, high = float(finite.min()), float(finite.max())
    size = max(abs(low), abs(high))
    if high - low < MIN_SPREAD * size:  # nothing but rounding: an axis of its digits would mislead
        return low - share * size, high + share * size
    room = share * (high - low or abs(high) or 1.0)
    return low - room, high + room
