"""The engine's cycle, marched together with its valve.

state (what is integrated, and the numbers of volumes and ports), gas_exchange (ports, their regimes and flows),
cylinder_laws (what a cylinder and its valve do at an instant), rates (the coupled march), operating_point (a machine
and a speed as the march takes them).

A port more is its number in `state` with PORTS, its entry in `gas_exchange.ports_at` and its line in `port_flows`, and
room in `apesim.march.adaptive.EVENTS`: modes, regimes, events and balances follow from there. One into or out of the
cylinder that is neither groove nor exhaust also needs its place in the ledger and in `apesim.engine.exergy`.
`engine.exhaust_2` is one: it counts with the exhaust.

A volume more is its entry in `state.VOLUMES`, its air in `gas_exchange.airs_at`, its gas at rest in
`operating_point.charged_at_rest`, its balance in `cylinder_laws.cylinder_rates` with the check of its domain, and what
is stored in it in `state.gas_held` and `apesim.engine.exergy`.
"""
