"""What is called from Python, each in a function that prepares it: run in the environment of the code that is measured.

``python -P calls.py NAME SECONDS`` calls it once, then for so many seconds, and prints the shortest time, as JSON. All
releases have to run it, so that it knows their names for the same thing; what one has not is said, not an error.
"""

import importlib
import json
import sys
import time
from math import pi

RPM = pi / 30.0
SPEEDS = 300, 600, 1000, 1600, 2400
"""Speeds of the operating points [r/min], from the lowest of use to beyond the valve's limit."""


def find(name, *modules):
    """An object by its name, from the first of the modules that there is."""
    for module in modules:
        try:
            return getattr(importlib.import_module(module), name)
        except (ImportError, AttributeError):
            continue
    raise LookupError(f"{name} is not in {', '.join(modules)}")


def default_machine():
    """The default machine; release 0.1.0 has its layers as packages of their own."""
    return find("Machine", "apesim.engine.machine", "engine.machine")()


def no_carry():
    """What hands nothing on between calls of a march: an argument of newer releases, none of older ones."""
    try:
        return (find("NO_CARRY", "apesim.march.adaptive"),)
    except LookupError:
        return ()


def one_litre():
    """The default machine with a receiver of 1 L."""
    machine = default_machine()
    receiver = machine.engine.receiver._replace(volume=1e-3)
    return machine._replace(engine=machine.engine._replace(receiver=receiver))


def bench_march():
    """March of the bench over 100 ms, tolerance 1e-6"""
    import numpy as np

    bench = find("__name__", "apesim.valve.bench", "valve.bench")
    march, log_head = (find(name, "apesim.march.adaptive", "apesim.march") for name in ("march", "LOG_HEAD"))
    bench_of, accuracy_of, closed, columns, states = (
        find(name, bench) for name in ("bench_of", "accuracy_of", "closed_at_start", "TRACE", "STATES")
    )
    p, tables = bench_of(default_machine(), [0.0, 50e-3])
    breakpoints, accuracy = np.array([1.5e-3, 3e-3, 50e-3, 51.5e-3, 53e-3, 100e-3]), accuracy_of(p, 1e-6)
    (start, modes), log, trace = closed(p), np.empty((0, log_head + states)), np.empty((0, len(columns)))
    carry = no_carry()

    def run():
        y, mode = start.copy(), modes.copy()
        return march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, np.empty(0), trace, *carry)

    return run


def bench_run():
    """`run_bench`, one pulse of 50 ms"""
    run_bench, machine = find("run_bench", "apesim.valve.bench", "valve.bench"), default_machine()
    return lambda: run_bench(machine, 50e-3)


def public_valve():
    """`apesim.run_valve`, one pulse of 50 ms"""
    run_valve, machine = find("run_valve", "apesim"), default_machine()
    return lambda: run_valve(machine)


def public_valves():
    """`apesim.run_valve` of 100 different machines"""
    run_valve, machine = find("run_valve", "apesim"), default_machine()
    machines = [machine.with_(valve_stroke=8e-3 + 2e-5 * i) for i in range(100)]
    return lambda: [run_valve(each) for each in machines]


def revolution():
    """March of the engine over a periodic revolution at 1000 r/min"""
    import numpy as np

    march, log_head = (find(name, "apesim.march.adaptive", "apesim.march") for name in ("march", "LOG_HEAD"))
    cycle_of, accuracy_at = (
        find(name, "apesim.engine.cycle.operating_point", "engine.operating_point")
        for name in ("cycle_of", "accuracy_at")
    )
    states = find("STATES", "apesim.engine.cycle.state", "engine.cycle_state")
    columns = find("TRACE", "apesim.engine.cycle.cylinder_laws", "apesim.engine.cycle.rates", "engine.cycle")
    run_steady, machine, speed = find("run_steady", "apesim.engine.steady", "engine.steady"), one_litre(), 1000.0 * RPM
    p, tables, breakpoints = cycle_of(machine, speed)
    orbit, accuracy = run_steady(machine, speed).orbit, accuracy_at(p)
    log, trace, carry = np.empty((0, log_head + states)), np.empty((0, len(columns))), no_carry()

    def run():
        y, mode = orbit.y.copy(), orbit.mode.copy()
        return march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, np.empty(0), trace, *carry)

    return run


def public_engine():
    """`apesim.run_engine` at 1000 r/min"""
    run_engine, machine = find("run_engine", "apesim"), default_machine()
    return lambda: run_engine(machine, "1000 rpm")


def changed_machine():
    """`Machine.with_`, two keys"""
    machine = default_machine()
    if not hasattr(machine, "with_"):
        raise LookupError("Machine has no with_")
    return lambda: machine.with_(engine_bore="90 mm", supply_pressure="0.8 MPa gauge")


def operating_point(speed):
    """`run_steady`, receiver of 1 L"""
    run_steady, machine = find("run_steady", "apesim.engine.steady", "engine.steady"), one_litre()
    return lambda: run_steady(machine, speed * RPM)


def cycles_of(result):
    """Cycles to the periodic state, where a result has one."""
    return getattr(getattr(result, "orbit", None), "cycles", None)


def valve_steps():
    """`apesim.Stepper` of the valve, 1000 steps of 0.1 ms"""
    stepper = find("Stepper", "apesim")(default_machine(), "valve")
    start = stepper.snapshot()

    def run():
        stepper.restore(start)
        for step in range(1, 1001):
            stepper.advance(1e-4 * step, command=int(step <= 500))

    return run


CALLS = {
    each.__name__: each
    for each in (
        bench_march,
        bench_run,
        public_valve,
        public_valves,
        valve_steps,
        revolution,
        public_engine,
        changed_machine,
    )
}


def main(name, seconds):
    """Print what a call takes, or why there is none."""
    try:
        run = CALLS[name]() if name in CALLS else operating_point(float(name))
    except LookupError as error:
        print(json.dumps({"missing": str(error)}))
        return
    result, times = run(), []
    end = time.perf_counter() + seconds
    while not times or time.perf_counter() < end:
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    print(json.dumps({"seconds": min(times), "cycles": cycles_of(result)}))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
