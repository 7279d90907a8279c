"""Verdicts held against answers: what of them is right."""

import re
from math import sqrt
from typing import NamedTuple

from scipy.stats import beta

from tests.truth.sealed.library import CALIBRATED
from tests.truth.sealed.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE
from tests.truth.sealed.second_schedule import FAULTY, TRIPLE

NAMES = ("NAMED", "NAMED_CLASS", "TWO_EFFECTS", "SEVERAL")
BLAMING = (*NAMES, "CALIBRATION", "MEASUREMENT")
"""Verdicts that say what it is."""
STATEMENTS = (*BLAMING, "NO_GAP", "REFUSED")
"""Verdicts that claim something; the others leave it open."""
CLEARING = ("NO_GAP", "CALIBRATION")
"""Verdicts by which nothing is missing."""
BAD_INPUT, NO_VERDICT = "BAD_INPUT", "NO_VERDICT"
"""In place of a verdict: the program takes the data for impossible, and says where; or it says nothing in time."""
CONFIDENT = 0.9
"""Stated probability from which a wrong statement counts as confident."""
SEEN, CLEAR, PLAIN = 5.0, 10.0, 20.0
"""Deviations of what is hidden."""
TOLERANCE = 0.15
"""Share of the noise; a gap smaller than this may be called none."""
NEARLY = 0.8
"""Share of the largest part of a gap that another part may have and still count as the largest."""
ROUNDING = 1e-9
"""Share of an interval's end that a change of units may take off."""
OFF = 2.0
"""Standard deviations, as a program knows or assumes them, from which a number of the rig counts as off."""
TWINS = CALIBRATED | {
    "dead_volume": ("valve.clearance_volume",),
    "moving_mass_error": ("valve.moving_mass",),
    "spring_rate_error": ("valve.spring_rate",),
    "clearance_error": ("engine.compression_ratio",),
}
"""Effects and the keys of numbers that say the same."""
MASKED = ("spikes", "stuck")
"""Faults that may be masked as data are read: the file then has to stand in a warning."""
MORE_LEFT = ("more than noise", "still there", "is left", "takes more of the gap")
"""What a reason or a warning says where an explanation leaves a gap."""
UNITS = {"": 1.0, "N": 1.0, "m/s": 1.0, "L": 1e-3, "mm": 1e-3, "mm^2": 1e-6, "cm^3": 1e-6, "mm^3": 1e-9, "ms": 1e-3}
"""Units of second parameters, over SI."""


class Scored(NamedTuple):
    """A case and what was said of it."""

    answer: dict
    verdict: dict

    @property
    def kind(self):
        return self.answer["kind"]

    @property
    def hidden(self):
        """Names of what is hidden."""
        return [one["name"] for one in self.answer["hidden"]]

    @property
    def deviations(self):
        """Deviations of the smallest effect that is hidden; 0: none is."""
        return min((one["deviations"] for one in self.answer["hidden"]), default=0.0)

    @property
    def clutter(self):
        """What a good model leaves out; cases of the first benchmark had it among what is hidden."""
        return self.answer.get("clutter") or (self.kind == NONE and self.answer["hidden"])

    @property
    def fault(self):
        """Fault of one file; None: there is none."""
        return self.answer.get("fault")

    @property
    def faulty(self):
        """Whether a fault of one file is plain to see."""
        return bool(self.fault) and self.fault["deviations"] >= CLEAR

    @property
    def visible(self):
        """Whether all that is hidden, and the largest part of it, is plain to see and matters."""
        if self.kind == NONE or not self.hidden:
            return False
        largest = max(one["deviations"] for one in self.answer["hidden"])
        return min(largest, self.answer["deviations"]) >= CLEAR and self.answer["rms"] >= TOLERANCE

    @property
    def said(self):
        """The verdict's word."""
        return self.verdict["verdict"]

    @property
    def rest(self):
        """What is said once a file is left out as faulty, as a verdict on the same case."""
        return Scored(self.answer | {"fault": None}, self.verdict["rest"]) if self.verdict.get("rest") else None

    @property
    def physics(self):
        """The part of what is said that speaks of the rig: the rest, where a file is blamed."""
        return self.rest.physics if self.rest else self

    @property
    def first(self):
        """Names of the explanation that stands first, named or not, each once; faults of files are none of them."""
        found = self.verdict.get("effects") or self.verdict.get("nearest")
        if found:
            return list(dict.fromkeys(one["name"] for one in found if not one.get("file")))
        return next((list(one["effects"]) for one in self.verdict.get("alternatives", ())), [])

    @property
    def listed(self):
        """Whether what is hidden stands first, or among what is said to be indistinguishable from it."""
        others = (one["effects"] for one in self.verdict.get("alternatives", ()))
        return any(set(names) == set(self.hidden) for names in (self.first, *others))

    @property
    def blamed(self):
        """Keys that a verdict of CALIBRATION blames."""
        rows = [one for part in ("effects", "nearest") for one in self.verdict.get(part, ())]
        keys = [one["key"] for one in self.verdict.get("nuisances", ())[:1]] if self.said == "CALIBRATION" else []
        return [*keys, *(one["name"] for one in rows), *(one["key"] for one in rows if "key" in one)]

    @property
    def calibrated(self):
        """Whether the verdict blames a number of the machine or a sensor that is what is hidden."""
        if self.said != "CALIBRATION" or len(self.hidden) != 1:
            return False
        return any(wanted in key for key in self.blamed for wanted in TWINS.get(self.hidden[0], ()))

    @property
    def really_off(self):
        """Whether a number that the verdict blames is off by more than a program has reason to believe."""
        return any(self.is_off(key) for key in self.blamed)

    def is_off(self, key):
        """Whether a number of the rig is off by more than a program has reason to believe."""
        return abs(self.answer.get("pulls", {}).get(key, 0.0)) >= OFF

    @property
    def geometric(self):
        """Effects that say no more than what the geometry, of which nothing is stated, is plainly off by."""
        off = [key for key, size in self.answer.get("geometry", {"by": {}})["by"].items() if size >= SEEN]
        return {name for name, keys in TWINS.items() if set(keys) & set(off)}

    @property
    def named(self):
        """Whether a name is given, to the whole or to what is left without a faulty file."""
        return self.physics.said in NAMES and bool(self.physics.first)

    @property
    def probability(self):
        """That the verdict states for itself; None: it states none."""
        return self.verdict.get("probability")

    @property
    def wrong(self):
        """Whether the verdict claims what is not so."""
        return self.right is False

    @property
    def right(self):
        """Whether the verdict is right in what it claims; None where it claims nothing.

        `REFUSED` claims a gap that nothing of the library closes.
        """
        if self.said not in STATEMENTS:
            return None
        if self.said == "REFUSED":
            return self.rightly_refused
        if self.said == "NO_GAP":
            return not self.visible and (not self.faulty or self.masked)
        if self.said == "CALIBRATION":
            clear = not self.visible and not self.faulty
            return self.calibrated or (clear and self.really_off)
        if self.said == "MEASUREMENT":
            blames = set(self.files)
            return bool(self.fault) and blames == {self.fault["file"]} and (self.rest is None or not self.rest.wrong)
        if not all(self.is_off(one["name"]) or self.is_off(one["key"]) for one in self.verdict.get("numbers", ())):
            return False
        first = set(self.first) - (self.geometric - set(self.hidden))
        if self.kind == NONE:
            return bool(self.first) and not first
        if self.kind not in (SINGLE, DOUBLE, TRIPLE, FAULTY):
            return False
        members = self.verdict.get("class", ()) if self.said == "NAMED_CLASS" else ()
        return any(self.is_enough(names) for names in (first, *({name} for name in members)))

    def is_enough(self, names):
        """Whether some names are all that is hidden, or all of it that would be seen if they were known."""
        return names == set(self.hidden) or (bool(names) and names < set(self.hidden) and self.unseen(names))

    @property
    def rightly_refused(self):
        """Whether there is a gap that nothing of the library, and no fault with a name, closes."""
        if self.fault:
            return not self.fault["name"]
        if self.hidden and self.kind != NONE:
            return self.kind in (REMOVED, FOREIGNER)
        off = self.answer.get("geometry", {}).get("deviations", 0.0) >= SEEN
        return bool(self.clutter or self.answer.get("scatter") or off)

    def unseen(self, named):
        """Whether those of several that are not named would not be seen if the others were known."""
        alone = sqrt(max(0.0, 1.0 - self.answer["cosine"] ** 2))
        others = [one["deviations"] for one in self.answer["hidden"] if one["name"] not in named]
        return max(others) * alone < SEEN

    @property
    def files(self):
        """Files whose record the verdict says is wrong."""
        return [*self.verdict.get("files", ()), *(self.rest.files if self.rest else ())]

    @property
    def accused(self):
        """Files that the verdict points at: as wrong, else in its reason, else as those that are not explained."""
        spoken = re.findall(r"\brun\d+\.csv", str(self.verdict.get("reason", "")))
        odd = [one["file"] for one in self.verdict.get("odd_channels", ())]
        return {file.rsplit("/", 1)[-1] for file in self.files or spoken or odd}

    @property
    def masked(self):
        """Whether what is wrong with a file was taken out as it was read, and the file told."""
        warnings = self.verdict.get("warnings", ())
        return bool(self.fault) and self.fault["kind"] in MASKED and any(self.fault["file"] in one for one in warnings)

    @property
    def pointed(self):
        """Whether the file that is faulty, and no other one, is pointed at."""
        return bool(self.fault) and (self.masked or self.accused == {self.fault["file"]})

    @property
    def found_all(self):
        """Whether what is said of the rig is right and whole: all that is hidden is named, and nothing else is."""
        physics = self.physics
        if self.hidden and self.kind != NONE:
            return physics.calibrated or (physics.said in NAMES and bool(physics.right) and physics.complete)
        return bool(physics.right) and physics.said in (*CLEARING, *NAMES)

    @property
    def complete(self):
        """Whether all that is hidden is named, or the class of it."""
        return set(self.hidden) <= {*self.first, *(self.verdict.get("class", ()) if self.said == "NAMED_CLASS" else ())}

    @property
    def besides(self):
        """Whether the faulty file is pointed at, and what is said beside it is right."""
        if not self.pointed:
            return False
        return self.found_all if self.said == "MEASUREMENT" or self.masked else False

    @property
    def several(self):
        """Whether three are named, or two of them with a statement that more is left."""
        first, hidden = set(self.first), set(self.hidden)
        if self.said in NAMES and first == hidden:
            return True
        said = [str(self.verdict.get("reason", "")), *self.verdict.get("warnings", ())]
        return len(first) == 2 and first < hidden and any(words in one for one in said for words in MORE_LEFT)

    @property
    def class_first(self):
        """Whether what stands first is the hidden single, or what no data like these tell from it."""
        if self.calibrated:
            return True
        alike = {*self.answer["class"], *self.hidden}
        return len(set(self.first)) == 1 and self.first[0] in alike

    @property
    def localised(self):
        """Whether the largest part of the gap is put where it is; None where nothing is said."""
        place = self.verdict.get("localised") or {}
        parts = self.answer["gap"]
        if not place.get("signal") or not parts:
            return None
        here = (place["signal"], place.get("phase") or "")
        share = next((one["share"] for one in parts if (one["signal"], one["phase"]) == here), 0.0)
        return share >= NEARLY * parts[0]["share"]

    @property
    def intervals(self):
        """Whether each interval of a rightly named strength holds the truth."""
        return self.held(lambda true, parameter: parameter == true["parameter"])

    @property
    def second_intervals(self):
        """Whether each interval of a parameter beside the strength holds the truth."""
        return self.held(lambda true, parameter: parameter != true["parameter"])

    def held(self, wanted):
        """Whether each interval of a wanted parameter of what is rightly named holds the truth."""
        found = []
        for one, value in self.match(self.right_rows, wanted):
            low, high = one["interval_95"]
            rounding = ROUNDING * max(abs(low), abs(high))
            found.append(low - rounding <= value <= high + rounding)
        return found

    @property
    def right_rows(self):
        """Rows of the parameters of what is rightly named."""
        physics = self.physics
        return physics.verdict["effects"] if physics.said in NAMES and physics.right else ()

    @property
    def strengths(self):
        """Rows of strengths of what is rightly named, or is rightly sure, that have intervals, each with the truth."""
        rows = (*self.right_rows, *self.physics.verdict.get("sure", ()))
        return list(self.match(rows, lambda true, parameter: parameter == true["parameter"]))

    def match(self, rows, wanted):
        """Rows of wanted parameters of what is hidden that have an interval, each with the truth in its unit."""
        truth = {one["name"]: one for one in self.answer["hidden"]}
        for one in rows:
            true = truth.get(one["name"])
            value = true and wanted(true, one["parameter"]) and value_of(true, one["parameter"], one["unit"])
            if isinstance(value, float) and one["interval_95"]:
                yield one, value

    @property
    def statements(self):
        """Every stated probability, and whether what it is of is so: the verdict, and each effect."""
        found = [] if None in (self.probability, self.right) else [(float(self.probability), bool(self.right))]
        stated = {label: p for label, p in (self.verdict.get("inclusion") or {}).items() if p is not None}
        return found + [(float(p), self.is_there(label.split(" or "))) for label, p in stated.items()]

    def is_there(self, names):
        """Whether one of some effects, numbers of the machine or faults of a file is what the case hides, or is off."""
        fault = self.answer.get("fault") or {"name": None}
        hidden = self.hidden if self.kind not in (NONE, REMOVED, FOREIGNER) else []
        sought = {*hidden, *self.geometric}
        keys = [key for name in hidden for key in CALIBRATED.get(name, ())]
        return any(
            name in sought
            or any(key in name for key in keys)
            or self.is_off(name)
            or bool(fault["name"] and name.startswith(fault["name"]) and name.endswith(f" in {fault['file']}"))
            for name in names
        )


def value_of(true, parameter, unit):
    """The truth of a parameter in a unit; None: nothing is known of it."""
    if parameter == true["parameter"]:
        return float(true["value"]) if true["unit"] == unit else None
    value = true.get("parameters", {}).get(parameter)
    return None if value is None or unit not in UNITS else float(value) / UNITS[unit]


def clopper_pearson(hits, cases, level=0.95):
    """Interval of a share."""
    tail = 0.5 * (1.0 - level)
    low = beta.ppf(tail, hits, cases - hits + 1) if hits else 0.0
    high = beta.ppf(1.0 - tail, hits + 1, cases - hits) if hits < cases else 1.0
    return float(low), float(high)
