"""Header of the C sources: what they know of the machine, as constants."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from apesim.march.adaptive import REMEDIES, Status
from apesim.studies.fmu.flat import flatten
from apesim.studies.fmu.model import Model
from apesim.studies.fmu.parameters import Order, Parameter


def header(
    model: Model,
    example: Any,
    parameters: Sequence[Parameter],
    fixed: Sequence[Parameter],
    orders: Sequence[Order],
    token: str,
) -> str:
    """Write the header `model.h` of a model, with its numbers to the bit."""
    places = {each.key: i for i, each in enumerate(parameters)}
    numbers = flatten(example)
    effects = [
        f"{{{places[each.key]}, {number}, {factor.hex()}, {int(is_value)}}}"
        for each in parameters
        for number, factor, is_value in each.effects
    ]
    ranges = [_range(each.key, *each.declaration.ends) for each in parameters]
    remedies = [_text(REMEDIES[status]) for status in Status]
    sizes = {
        "INPUT_COUNT": len(model.inputs),
        "OUTPUT_COUNT": len(model.outputs),
        "PARAMETER_COUNT": len(parameters),
        "CONSTANT_COUNT": len(fixed),
        "NUMBER_COUNT": len(numbers),
        "STATE_SIZE": model.state_size,
        "EFFECT_COUNT": len(effects),
        "ORDER_COUNT": len(orders),
        "REMEDY_COUNT": len(remedies),
    }
    return "\n".join(
        [
            "/* What the sources know of the machine; whole numbers of its arrays stand by their bits. */",
            "#include <math.h>",
            "#include <stdint.h>",
            *(f"#define {name} {value}" for name, value in sizes.items()),
            f"#define TOKEN {_text(token)}",
            "typedef struct { const char *name; double low, high; } Range;",
            "typedef struct { int parameter, number; double factor; int is_value; } Effect;",
            "typedef struct { int low, high; const char *text; } Order;",
            _array("Range", "input_ranges", [_range(v.name, v.low, v.high) for v in model.inputs]),
            _array("int", "input_is_whole", [str(int(v.is_whole)) for v in model.inputs]),
            _array("double", "input_starts", [_number(v.start) for v in model.inputs]),
            _array("Range", "parameter_ranges", ranges),
            _array("double", "parameter_starts", [_number(each.value) for each in parameters]),
            _array("double", "constants", [_number(each.value) for each in fixed]),
            _array("Effect", "effects", effects),
            _array("Order", "orders", [f"{{{o.low}, {o.high}, {_text(' and '.join(o.keys))}}}" for o in orders]),
            _array("char *const", "remedies", remedies),
            _array("uint64_t", "machine_numbers", _bits(numbers)),
            _array("uint64_t", "start_state", _bits(model.start_state)),
            "",
        ]
    )


def _array(kind: str, name: str, items: Iterable[str]) -> str:
    """Definition of an array of constants; one that has no items has room for one."""
    items = list(items) or ["0" if kind in ("int", "double", "uint64_t") else "{0}"]
    return f"static const {kind} {name}[] = {{\n    " + ",\n    ".join(items) + "\n};"


def _bits(numbers: np.ndarray) -> list[str]:
    """Numbers by their bits."""
    return [f"0x{bits:016x}u" for bits in np.ascontiguousarray(numbers).view(np.uint64).tolist()]


def _number(value: float) -> str:
    """Number of C, to the bit."""
    return float(value).hex() if np.isfinite(value) else ("INFINITY" if value > 0.0 else "-INFINITY")


def _range(name: str, low: float, high: float) -> str:
    """Item of an array of ranges."""
    return f"{{{_text(name)}, {_number(low)}, {_number(high)}}}"


def _text(text: str) -> str:
    """String of C."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ") + '"'
