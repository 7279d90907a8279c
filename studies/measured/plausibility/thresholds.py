"""Thresholds of plausibility, each with its reason.

A fault has to be out of reach of all effects of the library at the ends of their ranges, and of sensors a few times
worse than usual; a test runs every effect at its ends through the checks.
"""

from math import radians

MIN_SAMPLES = 8
"""Samples of a channel below which nothing is judged by it: the reader wants as many rows."""
LEVEL_SHARE = 0.02
"""Share of samples beyond a level: levels are the quantiles 2 and 98 % of a running median, so that neither noise nor
a spike makes one."""

MAX_BELOW, MAX_ABOVE = -0.05, 1.05
"""Lift over the stroke that a closed and an open valve may show: sensors err by 1 %, and stops give by less."""
MIN_MOVED = 0.15
"""Span of a channel over that of the machine, below which it does not move: a valve that leaves its stop at all goes
farther, and chamber pressures follow the solenoids in any case."""
MIN_SLIPPED = 0.03
"""Share of the stroke from which the closed valve's lift is said to have slipped: sensors err by 1 %."""
MIN_OFF_REST, MIN_REST_NOISES = 0.015, 4.0
"""Share of the stroke, and noises, by which a closed valve's lift lies off zero to be told: the zero of a usual sensor
is good to 0.02 mm, 0.2 % of a stroke."""
MAX_OFF_LIFT = 0.12
"""Share of the stroke within which levels of lift agree with the machine once a unit or a sign is mended."""

MAX_OFF_PRESSURE = 60e3
"""Pressure by which a level may be off the machine's [Pa]: back pressure makes up to 50 kPa, the offset of a sensor
some kPa; gauge called absolute makes 101."""
MAX_OFF_PRESSURE_SHARE = {"valve": 0.10, "engine": 0.30}
"""Share of the level to be added to that: leaks and areas change the highest cylinder pressure more than that of a
chamber."""
MAX_OFF_REST, MAX_OFF_REST_SHARE = 15e3, 0.05
"""Pressure, and share of the supply, by which a chamber at rest may be off the supply that is stated [Pa]: there is no
flow, so that gauge and regulator alone make the difference."""
MAX_OFF_FORCE, MAX_OFF_FORCE_SHARE = 20.0, 0.25
"""Force [N], and share of it, by which the mean of both directions may be off that of the pressure: friction cancels in
it, side forces make up to 12 N, a tare some newtons, and 10 % of a bore 20 % of the force."""
MAX_LEFT_OF_SUPPLY = 0.25
"""Share of the difference between stated and seen supply that may be left once a label is mended."""
MAX_OFF_SPAN = 0.6
"""Share by which the span between two levels may miss the machine's once a unit is mended: leaks and a supply that is
off change it by less, and the units that are often confused by a factor of six at least."""
MAX_OFF_SUPPLY_SHARE = 0.5
"""Share of the supply, above ambient, by which it may be off what a chamber at rest shows before it is refused even
where no known reason fits: no regulator is as bad."""
MAX_COLD, MAX_HOT = 120.0, 700.0
"""Temperatures that no chamber and no cylinder of compressed air has [K]."""
MIN_SUPPLY_TEMPERATURE, MAX_SUPPLY_TEMPERATURE = 230.0, 360.0
"""Temperatures of supply air that laboratories have [K]; others are possible."""
MAX_OFF_SUPPLY_TEMPERATURE = 80.0
"""Difference to the supply within which a channel of temperature lies in the middle [K]."""

MIN_ALIKE = 0.7
"""Correlation with the machine from which a trace has its shape, once a sign or a name is mended."""
MIN_BETTER = 0.5
"""Gain in correlation by which a turned sign, or swapped names, have to be better: 2 is the largest there is."""
MAX_TRIED_SHIFT = 20e-3
"""Time by which traces are shifted to compare shapes alone [s]: more than a trigger is mostly off by."""

MAX_OFF_TIME_UNIT = 1.0
"""Share by which the factor between two units of time may be missed: a valve is open for longer or shorter than its
pulse, but not twice as long, and units differ by a thousand."""
MIN_OPENS, MAX_OPENS = 0.2e-3, 60e-3
"""Times after the command between which a valve is half open once a unit of time is mended [s]."""
MIN_SHIFT_WARNED = 1.4e-3
"""Common shift of opening and closing that is warned of [s]: the effects of the library delay one of the two by more,
but hardly both."""
MIN_SHIFT_REFUSED = 5e-3
"""Common shift of opening and closing that is refused [s], where the shape is the machine's but for it."""
MAX_UNEQUAL = 1.5e-3, 0.25
"""Time [s], and share of the shift, by which shifts of opening and closing may differ to be a common one."""
MAX_LEFT_AFTER_SHIFT = 0.25
"""Share of the square of the difference to the machine that may be left after a shift that is refused: friction and
leaks change the shape, a clock does not."""
MIN_ONE_EDGE_LATE = 20e-3
"""Delay of the opening alone that is refused, if the shape is the machine's but for it [s]: the record ends before the
closing, and no effect of the library delays as much."""
MOVED = 0.10
"""Share of a channel's span by which it has left its rest: above noise, drift and hum."""
MIN_NOISES_MOVED = 6.0
"""Noises by which it has left its rest, for the same reason."""
MIN_PULSE_OFF, MIN_PULSE_OFF_SHARE = 5e-3, 0.2
"""Time [s], and share of the pulse, by which the release has to be off before chamber pressures refuse the pulse: air
leaves a chamber within two milliseconds of the command."""
PULSE_FACTOR = 10.0
"""Factor between pulses that a slip of the decimal point makes, which lift alone can show."""
MAX_OFF_FACTOR = 0.3
"""Share by which that factor may be missed."""
MIN_LATE_WARNED = 5e-3
"""Time by which one of opening and closing may be off the machine's before it is warned of [s]."""

MIN_CLIPPED = 8
"""Equal samples in a row at the very end of a channel: noise of three steps of its resolution makes as many with a
chance below 1e-7."""
MAX_SATURATED = 0.05
"""Share of samples at the very largest or smallest value, above which a sensor may be at its end: noise alone puts one
sample there."""
MIN_FOR_SATURATION = 40
"""Samples from which that share says something."""
MIN_CLIPPED_AWAY = 0.03
"""Share of the span by which the machine goes on where a channel without noise stays at its end."""
MAX_STEP_OVER_NOISE = 3.0
"""Step of a channel's values over its noise: up to it, noise still carries the signal between the steps."""
MAX_STEP_SHARE = 0.04
"""Step over the span that is refused: fewer than 25 values tell neither noise nor shape."""
MIN_STEP_SHARE = 0.002
"""Step over the span below which it does not matter."""
CODES = {
    "lift": (-1e3, 1e3),
    "velocity": (-1e6, 1e6),
    "pressure": (-1e12, 1e12),
    "temperature": (-1e6, 1e6),
    "force": (-1e9, 1e9),
    "stroke": (-1e3, 1e3),
}
"""Lowest and highest value [SI] beyond which a number is a code of the recorder, such as 1E+37, whatever the machine
and whatever unit was taken for another, by a part of the channel's name."""
MAX_SPOILT = 0.1
"""Share of impossible samples up to which the rest of a channel is judged without them: above it they are the signal
itself, in a wrong unit or with a wrong zero."""
MAX_OVER_SUPPLY = 3.0
"""Factor on the supply, and on what the crank can compress, above which no pressure is possible: cushions and waves
make up to 1.5, and a supply that is stated as gauge in place of abs hides a third."""
MAX_OVER_SPEED = 2.0
"""Factor on the speed that the whole supply gives the piston over its whole stroke without any loss, for the gain of
the sensor and a mass that is wrong."""
MIN_TEMPERATURE, MAX_TEMPERATURE = 50.0, 1500.0
"""Temperatures that no air here can have, whatever the machine [K]."""
MIN_NOISES_BEYOND = 4.0
"""Noises beyond a limit of a lift or a velocity from which a sample cannot be: with fewer it may be noise of a valve at
the limit, which the levels judge."""
MIN_NOISES_ABOVE_VACUUM = 6.0
"""Noises that the lowest pressure of a trace lies above zero, for what is not above zero to be no noise."""
MAX_NOISE_SHARE = 0.05
"""Noise over what is possible of a channel, from which the channel is in another unit: usual is below a hundredth."""
MIN_SPIKE_NOISES, MIN_SPIKE_SHARE = 10.0, 0.10
"""Height of a spike over the noise and over the span, by which it leaves the samples beside it."""
MIN_SINGLE_SHARE = 0.03
"""Height over the span of a single sample that is a spike in a fine record: where the valve lands and rebounds between
two of its samples, the one at the peak lies half as high."""
MAX_RESOLVED = {"time": 0.5e-3, "crank_angle": radians(1.5)}
"""Step between samples [s, rad] up to which two samples are too short for anything the valve or the air does: a stroke
takes 5 ms."""
MAX_FINE = {"time": 0.2e-3, "crank_angle": radians(0.6)}
"""Step between samples [s, rad] up to which one sample is too short for a rebound as high as a spike: pressed on by
1 kN, the piston of 0.1 kg takes 0.5 ms to come back from 0.3 mm, ten times a usual noise of the lift."""
MIN_CHANGES, MIN_CHANGE_SIZES = 12, 5
"""Changes of a channel, and sizes of them, from which their period says that it was sampled more slowly than its rows:
steps at random stand on one with a chance below 1e-3, and coarse steps are of one or two sizes."""
MAX_OFF_GRID, MAX_OFF_GRID_ROWS, MIN_ON_GRID = 0.26, 1.5, 0.98
"""Share of the period, and rows, by which a change may lie off the grid of the sampler, whose clock is another one, and
share of the changes that have to lie on it."""
MIN_STUCK = 8
"""Equal samples in a row that a recorder has held, for the reason of `MIN_CLIPPED`."""
MAX_REPEATS = 0.1
"""Share of samples equal to the one before, up to which a record is fine enough to see that one is held."""
MAX_MASKED = 0.03
"""Share of the samples of a channel that is masked at most: so much that a disturbance every ten
milliseconds can be masked, and so little that fits keep their data."""
MAX_STRETCH = {"time": 4e-3, "crank_angle": radians(15.0)}
"""Longest stretch that is masked [s, rad]: a third of a stroke, so that in a long record, too, no phase is lost."""
BESIDE_CLIPPED = 3
"""Samples beside a clipped stretch that are masked with it: those alone would stay that noise brings below the end."""
MIN_GAP = 3.0
"""Step between samples over the usual one that is a gap."""
MIN_BLIND = 1e-3
"""Gap from which nothing is said of an edge in it [s]: half of it is well below the smallest shift warned of."""
MAX_UNEVEN = 0.02
"""Share by which steps between samples may differ: the colour of noise is taken as if they did not."""
MIN_UNEVEN_WARNED = 0.5
"""Share of the usual step from which uneven samples are warned of: the jitter of a clock hardly changes a colour."""
MIN_IN_MOTION = 8
"""Samples between the command and the end of the closing that show motion at all: one each 10 ms."""
CLOSES = 30e-3
"""Time after the release by which the valve has closed in most cases [s]."""
MIN_MISSING_WARNED = 0.1
"""Share of missing cells of a channel that is warned of; fewer are a hint."""

MAX_OFF_STROKE_WARNED, MAX_OFF_STROKE = 0.03, 0.05
"""Share of the stroke by which the flat end of the lift may miss it in all runs before it is warned of, and before it
is refused: the usual gain of a sensor is known to 0.5 %, and a calibration follows what is more than usual."""
MAX_GAIN = 0.2
"""Error of a gain that no effect of the library makes: beyond it the stroke is wrong, or the gain is."""
MAX_LEFT_OF_GAIN, MAX_COMPARED = 0.5, 4
"""Share of the square of the difference that another stroke leaves of what another gain does, below which the stroke is
wrong, and runs that are compared for it: a search names a gain by itself, and fails at a wrong stroke."""
MAX_TOPS_APART = 0.015
"""Share of the stroke by which flat ends of runs may differ to be one stop: noise and seats that yield."""
MIN_REACHED_OF_PRIOR = 5.0
"""Standard deviations of a stated stroke or gain within which the fit moves it: no data are refused for that."""
MIN_REACHED = 0.9
"""Share of the stroke from which the machine comes to its stop."""
MIN_FLAT, FLAT_LEVEL = 3e-3, 0.005
"""Time for which a lift stays within a share of its span, and its noise, at its end to lie at a stop [s]: where it
turns in flight it stays for half a millisecond, a small hop for longer."""
MIN_FLAT_SHARE, MIN_NOISES_FLAT = 0.5, 40.0
"""Share of the time above half of its span for which it stays there, and noises that the span is at least: a hop stays
there for sqrt(2 (4 / 40 + 0.005)) = 0.46 of that time at most."""
MAX_FLIGHT_FACTOR = 2.0
"""Factor between flights of machine and rig from which, in all runs, a number of the machine is wrong: all effects of
the library, at the ends of their ranges, make 0.87 to 1.17."""
MIN_FLIGHT_STEPS = 3.0
"""Steps between samples by which flights have to differ: a crossing is known to half of one, and the median blurs."""
MIN_VELOCITY_FACTOR = 5.0
"""Factor by which the fastest motion may differ from the machine's: friction and leaks make up to two."""
MIN_ANGLE_WARNED, MIN_ANGLE_REFUSED = 8.0, 15.0
"""Error of the crank angle [deg] that is warned of, and one that is refused where all runs show it: usual sensors err
by two degrees, and a speed that ripples by 4 % looks like five."""
MIN_ANGLE_ALONE = 45.0
"""Error of the crank angle from which one run is refused by itself [deg]: an intake that is late by 3 ms and an exhaust
that is held up make 20 at some speeds, and none at others."""
MAX_OPEN_TURN, MIN_NOISES_OPEN = 0.05, 5.0
"""Share of a pressure's span, and noises, by which a turn may fail to close: effects of the library leave 0.02 against
the machine, and the ends of two lines through six samples have an error of one noise."""
SEAM = radians(6.0)
"""Angle on both sides of the end of a turn over which lines tell how it goes on [rad]."""
MAX_APART = 10.0
"""Difference of errors of the crank angle up to which they have one reason [deg]."""
MAX_LEFT_AFTER_TURN = 0.4
"""Share of what the correlation lacks to 1 that may be left once the crank angle is turned."""
MIN_TORQUE_PRESSURE = 100e3
"""Mean effective pressure from which the sign and size of a torque are judged [Pa]: effects of friction make 50 kPa."""
MIN_FLOW_FACTOR = 3.0
"""Factor by which torque or air flow may differ from the machine's before a unit is blamed: leaks make up to two."""
MAX_OFF_UNIT = 0.3
"""Share by which the factor between two units may be missed."""
MAX_DOUBTED = 2.0
"""Factor by which torque or air flow may differ from the machine's before it is warned of."""
