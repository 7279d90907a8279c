"""Effects from outside: files of a user that are like those of the library."""

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from apesim.effect import contact, law, sensed
from apesim.engine import cylinder
from apesim.engine.cycle.cylinder_laws import TRACE as ENGINE_TRACE
from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.effect_trial import sample_state, strong
from apesim.engine.effects import ALL_EFFECTS, ENGINE_EFFECTS, Effects, EngineLaws, library_of
from apesim.engine.machine import Machine
from apesim.engine.outside_machine import load_machine
from apesim.engine.steady import run_steady
from apesim.quantities import InputError
from apesim.quantities.settings import dumps
from apesim.reading import Reading
from apesim.valve import solenoid_flow, terms
from apesim.valve.bench import run_bench
from apesim.valve.effects import ValveLaws
from tests.folders import ROOT

EXAMPLE = ROOT / "docs" / "examples" / "data" / "tapered_bore.py"
ENGINE_NAMES = {effect.name for effect in ENGINE_EFFECTS}
FRICTION = 60.0
"""Strength of the example's effect [N s/m]."""
HEAD = '''
from typing import Annotated, NamedTuple

from apesim.effect import Effect, contact, law
from apesim.kernel import kernel
from apesim.quantities import Quantity


class Mine(NamedTuple):
    """Mine."""

    force: Annotated[float, Quantity("N", 0, 10, "mine")] = 0.0

'''
LAW = """
@law.for_type(Mine)
@kernel
def mine(effect, state, balance):
    balance[0] += effect.force
"""
TAIL = """
EFFECT = Effect("mine", Mine, equation="", source="", seen_in="", isolated_by="", layer="valve")
"""


def tapered(friction=FRICTION, path=EXAMPLE):
    return load_machine(None, [f"effects.files={path}", f"effects.tapered_bore.friction={friction:g} N s/m"])


def written(folder, text, name="mine.py"):
    path = folder / name
    path.write_text(text)
    return path


def refusal(path):
    with pytest.raises(InputError) as caught:
        Machine().with_effects(path)
    (fault,) = caught.value.faults
    assert "\n" not in str(fault)
    return str(fault)


# --- which file ---


def test_an_effect_that_was_loaded_needs_no_file_any_more(tmp_path):
    first, second = (written(tmp_path, HEAD + LAW + TAIL, f"{name}.py") for name in ("first", "second"))
    effect = Machine().with_effects(first).outside_effects[0].effect
    first.unlink()
    assert Machine().with_effects(effect).outside_effects[0].effect is effect
    Machine().with_effects(second)  # the same content
    assert Machine().with_effects(effect).outside_effects[0].path == second


def test_an_effect_is_the_one_that_is_given_though_its_file_was_edited(tmp_path):
    path = written(tmp_path, HEAD + LAW + TAIL + "# before")
    effect = Machine().with_effects(path).outside_effects[0].effect
    path.write_text(HEAD + LAW.replace("+=", "-=") + TAIL)
    assert Machine().with_effects(effect).outside_effects[0].effect is effect


# --- what it does ---


def net_force(machine, trace, friction):
    """Force on the piston by Eq. 1 and the example's law, written out by hand [N]; lift and velocity in the trace."""
    lift, velocity, pressure_a, pressure_b = trace
    valve = machine.valve
    return (
        (pressure_b - pressure_a) * valve.piston_area
        + valve.spring_rate * (valve.stroke - 2.0 * lift)
        - (valve.viscous_friction + friction * lift / valve.stroke) * velocity
    )


def test_the_law_of_the_example_by_hand():
    """Half open, at 1.5 m/s towards open: 60 N s/m times 1/2 times 1.5 m/s are 45 N against it."""
    state = type("State", (), {"position": 4.5e-3, "speed": -1.5, "valve": Machine().valve})
    balance = np.zeros(16)
    law(tapered().effects.tapered_bore, state, balance)
    assert balance[0] == pytest.approx(45.0, rel=1e-12)
    assert not balance[1:].any()


def test_the_valve_moves_as_the_forces_written_out_by_hand_say():
    sample = np.arange(0.0, 0.02, 1e-5)
    stroke_times = []
    for friction in (0.0, FRICTION):
        machine = tapered(friction)
        run = run_bench(machine, 50e-3, 0.02, sample=sample)
        stroke_times.append(run.opening.stroke_time)
        lift, velocity = run.trace[:, 0], run.trace[:, 1]
        flight = np.flatnonzero((lift > 1e-3) & (lift < 8e-3))[1:-1]
        measured = (velocity[flight + 1] - velocity[flight - 1]) / 2e-5 * machine.valve.moving_mass
        said = net_force(machine, run.trace[flight, :4].T, friction)
        other = net_force(machine, run.trace[flight, :4].T, FRICTION - friction)
        assert np.abs(measured - said).max() < 0.5
        assert np.abs(measured - other).max() > 20.0
    assert stroke_times[1] > 1.04 * stroke_times[0]


def test_the_engine_moves_its_valve_as_the_forces_written_out_by_hand_say():
    machine, speed = tapered(), 1000.0 * np.pi / 30.0
    angles = machine.command.energise + speed * np.arange(0.0, 0.014, 1e-5)
    run = run_steady(machine, speed, angles=angles)
    columns = {header.split(" [")[0]: column for column, header in enumerate(ENGINE_TRACE)}
    trace = run.trace[:, [columns[name] for name in ("lift", "velocity", "pressure_a", "pressure_b")]]
    flight = np.flatnonzero((trace[:, 0] > 1e-3) & (trace[:, 0] < 8e-3) & (trace[:, 1] > 0.5))[1:-1]
    measured = (trace[flight + 1, 1] - trace[flight - 1, 1]) / 2e-5 * machine.valve.moving_mass
    assert len(flight) > 300
    assert np.abs(measured - net_force(machine, trace[flight].T, FRICTION)).max() < 0.5


COPIES = ("slow_ramp", "supply_droop", "bounce", "ring_leakage", "lift_sensor_lag", "exhaust_timing", "blow_by")
"""Some of ours, for each slot and layer."""


@pytest.mark.parametrize("name", COPIES)
def test_a_copy_of_one_of_ours_from_outside_does_what_ours_does(tmp_path, name):
    layer = "engine" if name in ENGINE_NAMES else "valve"
    (ours,) = (effect for effect in ALL_EFFECTS if effect.name == name)
    text = Path(sys.modules[ours.parameters.__module__].__file__).read_text()
    head, tail = text.rstrip().removesuffix(")").split("EFFECT = Effect(")
    text = f'{head}EFFECT = Effect({tail.replace(name, "theirs", 1)}    layer="{layer}",\n)\n'
    machine = Machine().with_effects(written(tmp_path, text))
    values = strong(ours)
    one, other = (
        cycle_of(machine._replace(effects=machine.effects._replace(**{key: kind._make(values)})), 100.0)
        for key, kind in ((name, ours.parameters), ("theirs", type(machine.effects.theirs)))
    )
    assert [leaf.tobytes() for leaf in leaves(one[:2])] == [leaf.tobytes() for leaf in leaves(other[:2])]
    marched = {"law", "contact"} & set(ours.slots)
    for p, key in ((one[0], name), (other[0], "theirs")):
        own = p.effects if layer == "engine" else p.actuator.effects
        assert not marched or getattr(own, key) == values
    state = sample_state(layer)
    if "law" in ours.slots:
        balances = np.zeros((2, 20))
        law(values, state, balances[0])
        law(type(machine.effects.theirs)._make(values), state, balances[1])
        assert balances[0].any() and balances[0].tobytes() == balances[1].tobytes()
    if "contact" in ours.slots:
        assert contact(values, 1.0) == contact(type(machine.effects.theirs)._make(values), 1.0) > 0.0
    if "sensor" in ours.slots:
        times = np.linspace(0.0, 0.01, 5)
        shown = (
            sensed(
                library_of(machine.effects),
                machine.effects._replace(**{key: kind._make(values)}),
                Reading(lambda times: {"lift": np.sin(300.0 * times)}),
            ).at(times)["lift"]
            for key, kind in ((name, ours.parameters), ("theirs", type(machine.effects.theirs)))
        )
        first, second = shown
        assert first.tobytes() == second.tobytes() != np.sin(300.0 * times).tobytes()


def leaves(tree):
    """Numbers and arrays of a tree, the laws apart."""
    for name, value in zip(getattr(tree, "_fields", range(len(tree))), tree, strict=True):
        if name == "effects":
            continue
        if isinstance(value, tuple):
            yield from leaves(value)
        else:
            yield np.asarray(value, dtype=float)


# --- off, nothing changes ---


def test_without_effects_from_outside_a_machine_is_of_the_class_it_always_was():
    assert type(load_machine()) is Machine
    assert type(load_machine().effects) is Effects
    assert "\n[effects]\n\n#" in dumps(load_machine())


@pytest.mark.compiled
def test_one_that_is_off_changes_no_bit_and_has_nothing_compiled():
    machine, base = tapered(0.0), Machine()
    assert type(machine) is not Machine
    own, others = (run_bench(each, 20e-3, 0.03) for each in (machine, base))
    assert own.trace.tobytes() == others.trace.tobytes()
    for given in ({}, {"side_force": 1.0}):
        effects = machine.effects
        if given:
            effects = effects._replace(side_force=effects.side_force._replace(force=1.0))
        own = cycle_of(machine._replace(effects=effects), 100.0)[0]
        assert (type(own.actuator.effects) is ValveLaws) == bool(given)
        assert (type(own.effects) is EngineLaws) == bool(given)


def test_one_that_is_on_leaves_the_list_of_ours_and_other_machines_as_they_are():
    names = [effect.name for effect in ALL_EFFECTS]
    tapered()
    assert [effect.name for effect in ALL_EFFECTS] == names
    assert not hasattr(Machine().effects, "tapered_bore")


# --- machine file, settings, Python ---


def test_a_machine_file_names_it_by_a_path_from_its_own_folder(tmp_path, monkeypatch):
    shutil.copy(EXAMPLE, tmp_path / "bore.py")
    text = '[effects]\nfiles = ["bore.py"]\n[effects.tapered_bore]\nfriction = "60 N s/m"\n'
    path = written(tmp_path, text, "machine.toml")
    monkeypatch.chdir("/")
    machine = load_machine(path)
    assert machine.effects == tapered().effects
    kinds = {type(each.effects.tapered_bore) for each in (machine, tapered())}
    marches = {each.effects.libraries["valve"].marches for each in (machine, tapered())}
    assert (len(kinds), len(marches)) == (1, 1), "the same content is the same effect, wherever it stands"
    assert [str(each.outside_effects[0].path) for each in (machine, tapered())] == [
        str(tmp_path / "bore.py"),
        str(EXAMPLE),
    ]


def test_what_a_machine_prints_it_reads(tmp_path):
    machine = tapered()
    shutil.copy(EXAMPLE, tmp_path)
    for folder in (None, ROOT, tmp_path):
        place = tmp_path if folder is None else folder
        text = dumps(machine, folder)
        path = written(tmp_path, text.replace('files = ["docs', f'files = ["{ROOT}/docs'), "machine.toml")
        assert dumps(load_machine(path), folder) == text, place


def test_a_record_that_does_not_fit_its_file_is_refused(tmp_path):
    written(tmp_path, EXAMPLE.read_text() + "\n", EXAMPLE.name)
    path = written(tmp_path, dumps(tapered()), "machine.toml")
    with pytest.raises(InputError, match="another file than the one with the sha256 that stands here"):
        load_machine(path)


def test_misspelt_keys_are_refused_with_the_nearest_right_one(tmp_path):
    files = f"effects.files={EXAMPLE}"
    with pytest.raises(InputError, match=r"did you mean effects\.tapered_bore\.friction\?"):
        load_machine(None, [files, "effects.tapered_bore.fricton=60 N s/m"])
    with pytest.raises(InputError, match="201 N s/m' is out of range; allowed: 0 to 200 N s/m"):
        load_machine(None, [files, "effects.tapered_bore.friction=201 N s/m"])
    path = written(tmp_path, f'[effects]\nfiles = ["{EXAMPLE}"]\n[effects.taperd_bore]\nfriction = "60 N s/m"\n')
    with pytest.raises(InputError, match=r"did you mean effects\.tapered_bore\?"):
        load_machine(path)


@pytest.mark.parametrize("files", ['"one.py"', "[1]", '[""]', '[{ path = "one.py" }]', '[{ sha256 = "ab" }]'])
def test_files_that_are_no_list_of_paths_are_refused(tmp_path, files):
    path = written(tmp_path, f"[effects]\nfiles = {files}\n", "machine.toml")
    with pytest.raises(InputError, match=r'effects\.files: .*write files = \["my_effect.py"\]'):
        load_machine(path)


def test_python_gives_a_machine_effects_by_path_or_as_they_are(tmp_path, monkeypatch):
    base = Machine(groove=Machine().groove._replace(lap=1.5e-3))
    by_path = base.with_effects(EXAMPLE)
    assert type(base) is Machine and by_path.groove.lap == 1.5e-3
    assert by_path.effects.tapered_bore.friction == 0.0
    as_it_is = base.with_effects(by_path.outside_effects[0].effect)
    assert type(as_it_is.effects.tapered_bore) is type(by_path.effects.tapered_bore)
    twice = by_path.with_effects(EXAMPLE)
    assert type(twice) is type(by_path)
    more = by_path.with_effects(written(tmp_path, HEAD + LAW + TAIL))
    assert more.effects.mine.force == 0.0 and [one.name for one in more.outside_effects] == ["tapered_bore", "mine"]


def test_an_effect_in_no_file_is_refused():
    from apesim.effect import Effect

    class Nowhere(tuple):
        __module__ = "nowhere"

    with pytest.raises(InputError, match="stands in no file"):
        Machine().with_effects(Effect("nowhere", Nowhere, "", "", "", ""))


def test_an_installed_package_offers_effects_by_an_entry_point(tmp_path):
    shutil.copy(EXAMPLE, tmp_path / "their_bore.py")
    about = tmp_path / "their_bore-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their_bore\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[apesim.effects]\ntapered_bore = their_bore\n")
    code = (
        "from apesim.engine.outside_machine import load_machine\n"
        "print(load_machine(None, ['effects.tapered_bore.friction=60 N s/m']).effects.tapered_bore.friction)"
    )
    assert python(code, ROOT, tmp_path) == "60.0\n"
    (about / "entry_points.txt").write_text("[apesim.effects]\ntapered_bore = no_such_module\n")
    code = code.replace("print", "from apesim.quantities import InputError\ntry: print").replace(
        ".friction)", ".friction)\nexcept InputError as error: print(error)"
    )
    said = "entry point tapered_bore of their_bore: there is no Python file no_such_module; mend the package or"
    assert python(code, ROOT, tmp_path).startswith(said)


def python(code, *folders):
    """What a new process prints that finds modules in these folders."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([*map(str, folders), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.stderr == ""
    return done.stdout


# --- edited files, other processes ---


PROBE = """
from apesim.effect import law
from apesim.kernel import entry

@entry
def force(p, state, balance):
    law(p.effects.tapered_bore, state, balance)
    return balance[0]
"""
"""An entry of a law alone, which is compiled sooner than a march."""


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_an_edited_file_never_gives_the_old_answer(tmp_path, monkeypatch):
    """Each process finds what was compiled for the content of its file, and nothing of another."""
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path / "cache"))
    written(tmp_path, PROBE, "probe.py")
    path = tmp_path / "bore.py"
    code = (
        "import numpy as np\nfrom probe import force\nfrom apesim.engine.effect_trial import sample_state\n"
        "from apesim.engine.outside_machine import load_machine\nfrom apesim.valve.bench import bench_of\n"
        f"machine = load_machine(None, ['effects.files={path}', 'effects.tapered_bore.friction=60 N s/m'])\n"
        "p = bench_of(machine, [0.0, 20e-3])[0].actuator\n"
        "print(force(p, sample_state('valve'), np.zeros(16)), sum(force.stats.cache_hits.values()))"
    )
    text = EXAMPLE.read_text()
    edited = text.replace("balance[FORCE] -=", "balance[FORCE] -= 2.0 *")
    told = []
    for content in (text, text, edited, edited, text):
        path.write_text(content)
        force, hits = python(code, ROOT, tmp_path).split()
        told.append((float(force), int(hits)))
    force = told[0][0]
    assert force != 0.0
    assert told == [(force, 0), (force, 1), (2.0 * force, 0), (2.0 * force, 1), (force, 1)]


def test_an_edited_file_is_another_effect_in_the_same_process(tmp_path):
    path = written(tmp_path, HEAD + LAW + TAIL)
    first = Machine().with_effects(path)
    path.write_text(HEAD + LAW.replace("+= effect", "+= 2.0 * effect") + TAIL)
    second = Machine().with_effects(path)
    assert type(first) is not type(second)
    balance = np.zeros(1)
    for machine in (first, second):
        law(machine.effects.mine._replace(force=1.0), None, balance)
    assert balance[0] == 3.0
    assert type(pickle.loads(pickle.dumps(first))) is type(first)


def test_a_process_that_begins_after_an_edit_refuses_the_file(tmp_path):
    path = written(tmp_path, HEAD + LAW + TAIL)
    (tmp_path / "machine.pickle").write_bytes(pickle.dumps(Machine().with_effects(path)))
    path.write_text(HEAD + LAW + TAIL + "\n")
    code = (
        "import pickle\nfrom apesim.quantities import InputError\n"
        f"try: pickle.load(open({str(tmp_path / 'machine.pickle')!r}, 'rb'))\n"
        "except InputError as error: print(error)"
    )
    assert python(code, ROOT) == f"{path}: was edited while it was in use; start the work again\n"


def test_another_process_finds_the_machine_and_its_types_again(tmp_path):
    machine = tapered()
    (tmp_path / "machine.pickle").write_bytes(pickle.dumps((machine, machine.effects, machine.effects.tapered_bore)))
    code = (
        f"import pickle\nmachine, effects, bore = pickle.load(open({str(tmp_path / 'machine.pickle')!r}, 'rb'))\n"
        "assert type(machine.effects) is type(effects) and type(effects.tapered_bore) is type(bore)\n"
        "print(machine.effects.tapered_bore.friction, bore.friction)"
    )
    assert python(code, ROOT) == "60.0 60.0\n"


# --- what is refused ---


def test_what_is_no_effect_is_refused_in_one_line(tmp_path):
    right = {
        "no such file": (None, "cannot be read: No such file"),
        "a syntax error": ("def f(:\n", "line 1: no Python: invalid syntax; mend the file"),
        "an error": ("x = 1\ny = x / 0\n", "line 2: ZeroDivisionError: division by zero"),
        "an exit": ("import sys\nsys.exit()\n", "line 2: SystemExit: "),
        "no EFFECT": (HEAD, "defines no EFFECT; write EFFECT = Effect("),
        "another EFFECT": ("EFFECT = 3\n", "its EFFECT is no apesim.effect.Effect"),
        "no layer": (HEAD + LAW + TAIL.replace(', layer="valve"', ""), 'says no layer; give layer="valve" or'),
        "a strange layer": (HEAD + LAW + TAIL.replace('layer="valve"', 'layer="crank"'), "'crank' is no layer"),
        "no slot": (HEAD + TAIL, "it fills no slot and would do nothing"),
        "one of ours": (HEAD + LAW + TAIL.replace('"mine"', '"blow_by"'), "'blow_by' is the name of one of ours"),
        "no name": (HEAD + LAW + TAIL.replace('"mine"', '"My Effect"'), "'My Effect' is no name for an effect"),
        "a table": (HEAD + LAW + TAIL.replace('equation=""', 'equation="", tabulated="heat"'), "it is a table"),
        "no unit": (
            HEAD.replace('Annotated[float, Quantity("N", 0, 10, "mine")]', "float") + LAW + TAIL,
            "Mine.force has no declared unit, range and default; write class MyParameters",
        ),
        "no parameter": (
            HEAD.partition("    force:")[0] + LAW + TAIL,
            "Mine has no parameter; write class MyParameters",
        ),
        "no default": (HEAD.replace(" = 0.0", "") + LAW + TAIL, "Mine.force has no declared unit, range and default"),
        "no end": (HEAD.replace("0, 10", "0, float('inf')") + LAW + TAIL, "no parameter with a range that has two"),
        "on": (HEAD.replace("= 0.0", "= 1.0") + LAW + TAIL, "it is on by default"),
        "off its range": (HEAD.replace("0, 10", "1, 10") + LAW + TAIL, "the default of Mine.force: 0 N is out of"),
        "its own volume": (
            HEAD + LAW + TAIL.replace('layer="valve"', 'layer="valve", volume=3'),
            "its volume is no function",
        ),
        "a contact in the engine": (
            HEAD
            + "@contact.for_type(Mine)\n@kernel\ndef rebound(effect, speed):\n    return effect.force / 10.0\n"
            + TAIL.replace('"valve"', '"engine"'),
            "the engine has no room for a contact; it has for adjust, law, sensor, volume",
        ),
        "on while it is off": (
            HEAD + LAW.replace("effect.force", "1.0") + TAIL,
            "its law adds to FORCE of the balance while it is off",
        ),
        "a branch while it is off": (
            HEAD + LAW.replace("balance[0] += effect.force", "balance[10] = 7.0 * balance[10] + 1.0") + TAIL,
            "its law adds to BRANCH of the balance while it is off; note a branch only where its strength is not zero",
        ),
        "no such state": (
            HEAD + LAW.replace("effect.force", "effect.force * state.angle") + TAIL,
            "its law fails: AttributeError: 'ValveState' object has no attribute 'angle'",
        ),
        "an import": ("import my_helpers\n" + HEAD + LAW + TAIL, "line 1: imports 'my_helpers'; an effect is one file"),
        "a relative import": ("from . import x\n" + HEAD + LAW + TAIL, "line 1: imports '.'; an effect is one file"),
        "an adjustment of nothing": (
            HEAD
            + "def adjust(effect, machine, tables):\n    return machine\n"
            + TAIL.replace("seen", "adjust=adjust, seen"),
            "its adjust does not return a pair of Actuator and ActuatorTables",
        ),
    }
    for number, (kind, (text, expected)) in enumerate(right.items()):
        path = tmp_path / f"mine_{number}.py"
        if text is not None:
            path.write_text(text)
        assert refusal(path).startswith(f"{path}: "), kind
        assert expected in refusal(path), kind


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_a_law_that_python_runs_and_the_compiler_does_not_is_refused(tmp_path):
    text = HEAD + LAW.replace("+= effect.force", "+= effect.force * len(vars())") + TAIL
    assert "its law fails: it cannot be compiled: " in refusal(written(tmp_path, text))


def test_two_files_with_effects_of_one_name_are_refused(tmp_path):
    one = written(tmp_path, HEAD + LAW + TAIL)
    two = written(tmp_path, HEAD + LAW + TAIL + "\n", "other.py")
    with pytest.raises(InputError, match=f"'mine' is the name of the effect in {one}, too"):
        Machine().with_effects(one, two)


def test_a_second_gas_volume_is_refused_while_both_are_on(tmp_path):
    text = HEAD + "def volume(effect):\n    return 1e-4, effect.force * 1e-6\n" + TAIL
    path = written(tmp_path, text.replace('layer="valve"', 'layer="valve", volume=volume'))
    settings = [f"effects.files={path}", "effects.mine.force=5 N"]
    assert load_machine(None, settings).effects.mine.force == 5.0
    with pytest.raises(InputError, match=r"effects\.mine: is a second gas volume beside supply_droop"):
        load_machine(None, [*settings, "effects.supply_droop.feed_area=5 mm^2"])


def test_the_names_of_the_elements_are_those_of_their_constants():
    for layer, names in ((terms, terms.TERM_NAMES[: terms.FLOW_SHARE]), (cylinder, cylinder.TERM_NAMES)):
        assert [getattr(layer, name) for name in names] == list(range(len(names)))
    flows = [name.removeprefix("FLOW_SHARE + ") for name in terms.TERM_NAMES[terms.FLOW_SHARE :]]
    assert [getattr(solenoid_flow, name) for name in flows] == list(range(solenoid_flow.FLOWS))
    assert (len(terms.TERM_NAMES), len(cylinder.TERM_NAMES)) == (terms.TERMS, cylinder.TERMS)
