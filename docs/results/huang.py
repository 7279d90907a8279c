"""A published engine run on air (doi 10.3390/en6031731): computed numbers, and what each assumption is worth."""

import shlex

from docs.results import Number, Table
from tests.acceptance.huang import POWER_SPEED, SPEEDS, TORQUE_SPEED, point

TORQUE, POWER, COLDEST = 9.99, 0.95, 17.0
"""Published values: N·m, kW, degrees Celsius."""
OUTLET = ['ambient.pressure="1.5 bar abs"'], ['ambient.pressure="1.9 bar abs"']
"""The outlet's pressure as measured, on a line through both published numbers, at the two speeds."""
WOSCHNI = ["effects.cylinder_wall_heat.factor=1"]
ASSUMPTIONS = {
    "intake area, half": 'groove.effective_area="49 mm^2"',
    "intake area, half as much again": 'groove.effective_area="147 mm^2"',
    "exhaust area, half": 'engine.exhaust.effective_area="41 mm^2"',
    "exhaust area, half as much again": 'engine.exhaust.effective_area="123 mm^2"',
    "intake closes 30° earlier": 'engine.cam.closes="90 deg" engine.cam.flank="47.5 deg"',
    "intake closes 30° later": 'engine.cam.closes="150 deg" engine.cam.flank="77.5 deg"',
    "intake opens 15° earlier": 'engine.cam.opens="-20 deg"',
    "intake opens 15° later": 'engine.cam.opens="10 deg" engine.cam.flank="55 deg"',
    "intake lobe with steep flanks": 'engine.cam.flank="25 deg"',
    "exhaust opens 20° earlier": 'engine.exhaust.opens="150 deg"',
    "exhaust opens 20° later": 'engine.exhaust.opens="190 deg" engine.exhaust.flank="77.5 deg"',
    "exhaust closes 40° earlier": 'engine.exhaust.closes="305 deg" engine.exhaust.flank="67.5 deg"',
    "exhaust lobe with steep flanks": 'engine.exhaust.flank="25 deg"',
    "compression ratio, lower": "engine.compression_ratio=7",
    "compression ratio, higher": "engine.compression_ratio=12",
    "bore and stroke": 'engine.bore="52 mm" engine.stroke="47 mm"',
    "rod": 'engine.rod_length="80 mm"',
    "friction, less": 'engine.friction.constant="0.2 bar"',
    "friction, more": 'engine.friction.constant="0.8 bar"',
    "Woschni's wall heat": WOSCHNI[0],
    "wall heat, constant": 'effects.cylinder_wall_heat.h="200 W/(m^2 K)"',
    "blow-by": 'effects.blow_by.area="0.5 mm^2"',
    "a pipe before the valve": 'engine.receiver.volume="0.1 L" engine.receiver.feed_area="50 mm^2"',
    "supply 10 K colder": 'supply.temperature="283.15 K"',
    "outlet as measured near 465 r/min": OUTLET[0][0],
    "outlet as measured near 1320 r/min": OUTLET[1][0],
}
"""One change at a time, as `--set` takes it."""


def torque_at(settings=()):
    """Brake torque at the speed of the highest torque [N·m]."""
    return point(TORQUE_SPEED, settings)[0]["brake_torque_Nm"]


def power_at(settings=()):
    """Brake power at the speed of the highest power [kW]."""
    return point(POWER_SPEED, settings)[0]["brake_power_W"] / 1e3


def share(found, of):
    """What a number is more than another [%]."""
    return Number(100.0 * (found / of - 1.0), "%", error=0.05)


def compute():
    """Comparison with what is published, and the table of assumptions."""
    base_torque, base_power = torque_at(), power_at()
    rows = []
    for words, torque, power in (
        ("", base_torque, base_power),
        (", outlet as measured", torque_at(OUTLET[0]), power_at(OUTLET[1])),
    ):
        rows += [
            _row(f"brake torque at 465 r/min{words} [N·m]", TORQUE, torque, 0.005),
            _row(f"brake power at 1320 r/min{words} [kW]", POWER, power, 0.0005),
        ]
    best = max(SPEEDS, key=lambda rpm: point(rpm)[0]["brake_power_W"])
    rows.append(["speed of the highest power [r/min]", "1320", Number(best), f"{best - 1320:+d} r/min"])
    for words, settings in (("", ()), (", with Woschni's wall heat", WOSCHNI)):
        coldest = point(TORQUE_SPEED, settings)[1].trace[:, 1].min() - 273.15
        rows.append(
            [
                f"coldest air in the cylinder at 465 r/min{words} [°C]",
                f"{COLDEST:.0f}",
                Number(coldest, error=0.5),
                f"{coldest - COLDEST:+.0f} K".replace("-", "\u2212"),
            ]
        )
    changed = [(shlex.split(text), text, what) for what, text in ASSUMPTIONS.items()]
    torques, powers = [torque_at(each) for each, _, _ in changed], [power_at(each) for each, _, _ in changed]
    heads = ["assumption", "changed to", "torque [N·m]", "change [%]", "power [kW]", "change [%]"]
    lines = [
        [
            what,
            f"`{text}`",
            Number(torque, error=0.005),
            share(torque, base_torque),
            Number(power, error=0.0005),
            share(power, base_power),
        ]
        for (_, text, what), torque, power in zip(changed, torques, powers, strict=True)
    ]
    return {
        "published": Table(["", "published", "computed", "difference"], rows),
        "assumptions": Table(heads, lines),
        "torque_difference": share(base_torque, TORQUE),
        "power_difference": share(base_power, POWER),
        "lowest_torque": Number(min(torques), "N·m", error=0.05),
        "highest_torque": Number(max(torques), "N·m", error=0.05),
        "lowest_power": Number(min(powers), "kW", error=0.05),
        "highest_power": Number(max(powers), "kW", error=0.05),
    }


def _row(what, published, computed, error):
    number = Number(computed, error=error)
    difference = f"{100.0 * (computed / published - 1.0):+.1f} %".replace("-", "\u2212")
    return [what, f"{published:g}", number, difference]
