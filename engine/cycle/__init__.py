"""The engine's cycle, marched together with its valve.

state (what is integrated, and the numbers of volumes and ports), gas_exchange (ports, their regimes and flows), rates
(the coupled march), operating_point (a machine and a speed as the march takes them).

A port more is its number in `state` and its entry in `gas_exchange.ports_at`: modes, regimes, events, balances, trace,
ledgers and exergy follow from there. `engine.exhaust_2` is one. A volume more is its entry in `state.VOLUMES`, its gas
at rest in `operating_point.charged_at_rest` and its balance in `rates.cycle_rates`.
"""
