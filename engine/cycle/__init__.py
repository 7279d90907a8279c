"""The engine's cycle, marched together with its valve.

exchange (the list of its flows), state (what is integrated), flows (through intake pipe, groove, exhaust and feed),
rates (the coupled march), operating_point (a machine and a speed as the march takes them).

A second exhaust valve would touch, in this order:

1. its keys: an `Exhaust` more in `apesim.engine.cylinder.Engine`, its rows in `apesim.engine.proportions`, and whether
   it is among `apesim.engine.first_keys`;
2. the list of flows, `exchange`, its field and its number: modes, regimes, events and ledger follow from there;
3. `flows`: its line in `exchange_sides`, `exchange_areas`, `exchange_flows`, `with_past_groove` and `open_flows`, and
   its share of the open area, as `apesim.engine.breathing.exhaust_area`;
4. `operating_point.breakpoints_of_cycle`: the corners of its window;
5. `rates.cycle_rates`: what leaves the cylinder, and in `state` the back-flow, are sums of both; `rates.observe_cycle`
   and `TRACE`: a column of its own, whose name `apesim.studies` then knows in `engine_run`, `sweep.results` and
   `measured.sensors`;
6. `apesim.engine.exergy.add_exergy_rates` and `apesim.engine.indicators`: what it destroys, closure, exhaust air; each
   a sum over both valves;
7. the effects of the exhaust, which act on one valve or on both: in `apesim.engine.effects` `exhaust_timing`,
   `exhaust_restriction`, `exhaust_back_pressure` and `tabulated_cylinder_leak`;
8. in `apesim.studies` `estimation.priors` (how well its area is known), `measured.prediction` (when it opens),
   `measured.plausibility.impossible` (from where the cylinder is closed) and `gap.search.phases` (which of both begins
   the exhaust).

What shows the sum of both stays as it is: `assessment.causes`, `assessment.summary`, `figures.assessment`,
`figures.gap.overlays` and `commands.engine.run`, all in `apesim.studies`.
"""
