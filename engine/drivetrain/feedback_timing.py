"""Feedback on the timing of the valves: a controller that needs no map, only a sensor on each valve."""

from math import isnan

from apesim.engine.angles import DEGREE
from apesim.engine.drivetrain.control import ANGLES, EngineCommands, SensorReadings
from apesim.engine.drivetrain.preparing import machines_of
from apesim.engine.machine import Machine

GAIN = 0.25
"""Share of an error that is corrected in a revolution: the largest that does not swing, see `FeedbackTiming`."""
MIN_WINDOW_DEG, MAX_WINDOW_DEG = 1.0, 359.0
"""Shortest and longest pulse that is commanded [deg]; chosen, so that none is empty or as long as a turn."""
MAX_LEAD_DEG = 180.0
"""Angle by which a command comes before or after its target at most [deg]; chosen: half a turn."""
MAX_MISSED = 1
"""Revolutions without a stroke for which nothing is changed; chosen: a stroke may end just behind its revolution."""
LENGTHENING = 1e-3
"""Time by which the pulse is made longer in each further revolution without a stroke [s]; chosen."""


class FeedbackTiming:
    """Controller that moves the commands of each valve until it opens and closes at its targets.

    It knows the speed, and the angles at which each valve opened and closed in its last stroke. In each revolution the
    lead times t of both commands before their targets change by a share g of the error of the angle:
    ``t_new = t + g (measured - target) / (6 n)``, with angles in degrees and the mean speed n in r/min (chosen). A
    valve needs much the same time at all speeds, so that lead times have less to change in a ramp than angles. What is
    measured of a stroke acts on the one after the next: at a constant speed the error follows ``e_2 = e_1 - g e_0``
    (defined here), which is stable below a gain of 1, and does not swing up to 0.25.

    It begins with the commands that hold. No pulse is shorter than 1 deg or `min_pulse_s`, or longer than 359 deg, and
    no command is farther from its target than 180 deg; a lead time beyond that is not gathered. In a revolution in
    which no stroke ended nothing changes; from the second in turn on the release comes 1 ms later each time, as the
    pulse may be too short for the valve to open at all. While the shaft turns backwards nothing changes.

    Parameters
    ----------
    machine : Machine
        Machine whose `command.open_target` and `close_target` are the targets, of each cylinder or stage.
    gain : float
        Share g of an error that is corrected in a revolution, above 0 and below 1.
    min_pulse_s : float
        Shortest pulse [s].

    Examples
    --------
    At a constant speed the valve comes to open at -5 deg; with fixed commands it opens much later:

    >>> import apesim
    >>> machine = apesim.Machine()
    >>> speed = "0 s: 900 rpm, 1.5 s: 900 rpm"
    >>> run = apesim.run_transient(machine, speed=speed, controller=apesim.FeedbackTiming(machine, gain=0.25))
    >>> [round(run.march.cylinders["open"][k, 0] * 57.2958) for k in (0, -1)]
    [36, -5]
    """

    def __init__(self, machine: Machine, gain: float = GAIN, min_pulse_s: float = 0.0) -> None:
        commands = [each.command for each in machines_of(machine)]
        self.targets = [(command.open_target / DEGREE, command.close_target / DEGREE) for command in commands]
        self.gain, self.min_pulse = gain, min_pulse_s
        self.leads: list[tuple[float, float]] = []
        self.missed = [0] * len(commands)

    def __call__(self, readings: SensorReadings) -> EngineCommands | None:
        """Change the commands of all cylinders after a revolution."""
        if readings.mean_speed_rpm <= 0.0:
            return None
        turning = 6.0 * readings.mean_speed_rpm  # deg/s
        held = list(zip(readings.energise_deg, readings.release_deg, strict=True))
        if not self.leads:
            pairs = zip(self.targets, held, strict=True)
            self.leads = [((a - energise) / turning, (b - release) / turning) for (a, b), (energise, release) in pairs]
        windows = [self._window_of(i, readings, turning) for i in range(len(held))]
        return EngineCommands([energise for energise, _ in windows], [release for _, release in windows])

    def _window_of(self, i: int, readings: SensorReadings, turning: float) -> tuple[float, float]:
        """Next command of a cylinder [deg], whose lead times are changed; the shaft turns by `turning` a second."""
        (open_target, close_target), (open_lead, close_lead) = self.targets[i], self.leads[i]
        opened, closed = readings.valve_open_deg[i], readings.valve_close_deg[i]

        # The integral law; without a stroke there is no error to go by.
        if isnan(opened) or isnan(closed):
            self.missed[i] += 1
            close_lead -= LENGTHENING if self.missed[i] > MAX_MISSED else 0.0
        else:
            self.missed[i] = 0
            open_lead += self.gain * (opened - open_target) / turning
            close_lead += self.gain * (closed - close_target) / turning

        # Limits; the lead times are those of what is commanded, so that none grows while a limit holds.
        energise = open_target - _clipped(open_lead * turning, -MAX_LEAD_DEG, MAX_LEAD_DEG)
        energise = _clipped(energise, *ANGLES["energise_deg"])
        release = close_target - _clipped(close_lead * turning, -MAX_LEAD_DEG, MAX_LEAD_DEG)
        shortest = _clipped(self.min_pulse * turning, MIN_WINDOW_DEG, MAX_WINDOW_DEG)
        release = energise + _clipped(release - energise, shortest, MAX_WINDOW_DEG)
        self.leads[i] = (open_target - energise) / turning, (close_target - release) / turning
        return energise, release


def _clipped(value: float, low: float, high: float) -> float:
    """Value within two limits."""
    return min(max(value, low), high)
