"""Thresholds that decide a verdict, each with its reason.

Whoever changes one has to score fresh sealed cases, see `python -m tests.truth`: on cases that were looked at, any
threshold looks good.
"""

from math import log

ALARM = 0.01
"""Chance with which noise alone may raise an alarm: the nominal rate of false alarms."""
TOLERANCE = 0.15
"""Size of a gap over the noise, where it is largest, below which it does not matter, unless the user says otherwise: it
adds 1 % to the noise of a sample. Too tight a tolerance leads to refusals, not to wrong names."""
MAX_CORRECTED = 3
"""Numbers of the machine that an explanation may pull beyond `apesim.studies.estimation.model.MAX_PULL`: with more of
them it is the machine file that does not fit the rig."""
MAX_CORRECTION = 10.0
"""Prior standard deviations beyond which a number of the machine is not believed beside a name: where each of twenty
numbers is Student's t, and known half as well as is said, 6 rigs of 100 have one so far."""
MAX_EXCESS = 3.0
"""Standard deviations by which a size has to be beyond its range to be implausible."""
MIN_REMOVED = 0.6
"""Share of the gap's energy that a name has to take away where nothing was fitted: with less, most of
the gap would be something else."""
MAX_LEFT = 0.05
"""Share of the gap's size that may be left, where that is more than the tolerance: strengths are found to some per
cent, so that a large gap leaves more than the tolerance of a small one."""
MIN_SHOWN = 3.0
"""Sigmas by which gate runs have to show an explanation, so that they judge it alone: what shows by less is hidden by
noise in one case of fifteen or more."""
TERM_CHANCE = 0.01
"""Chance of a term that is not there: 2 ln(n/p) is its penalty in a library of n effects (PASTIS)."""
AMBIGUOUS_COST = 2.0 * log(100.0)
"""Penalised cost within which two models are indistinguishable: the data are a hundred times as probable."""
ALIKE = 0.9
"""Cosine between what two effects do to the data, from which they are of one class."""
DOUBTFUL = 0.25
"""Chance of noise alone to leave what a single effect leaves, below which large sizes and sets are tried, too."""
MIN_LOG_ODDS = 10.0
"""Log odds of each effect of a set, over all models, from which the set is named: odds of 22 000, so
that noise that is far from what it is taken for names none. Chosen; no sealed case has been counted for it yet."""
MIN_SURE_ODDS = 99.0
"""Odds of an effect, over all models, from which it is said to be missing where it stays open what is with it: as for
each model without it alone, see `AMBIGUOUS_COST`, the data are a hundred times as probable with it as by all others
together. Below `MIN_LOG_ODDS`, as it is asked beside that every explanation that is left has the effect."""
MIN_TWIN_ODDS = 4.0
"""Odds of an effect of a set against what these data do not distinguish from it, from which the set is named."""
TABLE_MARGIN = 2.0 * log(10.0)
"""Penalised cost by which a table has to beat a name to refuse it: the data are ten times as probable."""
SURE = 1.64
"""Standard deviations by which what is left has to stand out of noise to count: noise alone does in one case of
twenty."""
N_SIGMA_VISIBLE = 5.0
"""Sigmas at which an effect counts as visible: noise alone gives a single score as large with a chance of 6e-7."""
WINDOWS = 50
"""Windows of each channel of each run: of some ms each, they average noise out and still show each phase."""
MIN_ODD_SIGMA = 5.0
"""Standard deviations of noise alone from which a channel of one file is explained worse than noise allows: of the some
hundred sums of squares of a folder, noise alone makes none so large."""
MAX_ODD_SIZE = 0.3
"""Size over the noise up to which a channel of one file may be explained worse than the others: twice the tolerance of
a gap, as a file has a part of the data alone."""
