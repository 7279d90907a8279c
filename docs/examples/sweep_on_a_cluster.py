"""
One sweep in parts, and on a cluster
====================================

A long sweep can be shared: in parts on machines that know nothing of each other, or on the workers of a dask cluster.
This example computes one sweep in three ways and shows that the results are the same to the last bit.

It needs dask: ``python -m pip install ".[dask]"`` in the top folder of the source code.
"""

from pathlib import Path

import matplotlib.pyplot as plt
from distributed import LocalCluster

import apesim

machine, speeds = apesim.Machine(), "400:2000:200 rpm"
out = Path("out")
out.mkdir(exist_ok=True)

# %%
# Worker processes import this script, so everything that computes stands below ``if __name__ == "__main__":``.
#
# First the whole sweep in one process. Then in three parts: ``shard="1/3"`` computes the 1st, 4th, 7th … point into an
# archive of its own. On three machines the three calls would run at the same time. ``merge_archives`` joins the parts.
# On the command line these are ``apesim engine sweep --shard 1/3 --out part1.h5`` and ``apesim archive merge``.

if __name__ == "__main__":
    apesim.sweep(machine, speeds, intake="cam", out=out / "whole.h5", overwrite=True)
    parts = [out / f"part{number}.h5" for number in (1, 2, 3)]
    for number, part in enumerate(parts, start=1):
        apesim.sweep(machine, speeds, intake="cam", shard=f"{number}/3", out=part, overwrite=True)
    merged = apesim.merge_archives(parts, out / "merged.h5", overwrite=True)
    print(merged)

# %%
# On a cluster, ``dask`` is the address of its scheduler. ``LocalCluster`` starts scheduler and workers on this machine;
# on a cluster they are there already. Whoever reaches a scheduler can run code on its workers: keep it on the loopback
# address or behind TLS.

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        apesim.sweep(machine, speeds, intake="cam", dask=address, out=out / "cluster.h5", overwrite=True)

# %%
# Archives are compared by the coordinates of their runs, bit by bit unless a tolerance is given. Only the provenance
# differs, such as date and call.

if __name__ == "__main__":
    for other in ("merged.h5", "cluster.h5"):
        compared = apesim.compare_archives(out / "whole.h5", out / other)
        same, runs = "the same" if compared.is_same else "different", compared["runs_compared"]
        print(f"whole.h5 and {other}: {same} in {runs} runs and {compared['variables_same']} variables")

    figure, axis = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    axis.plot(merged.traces["speed_rpm"], merged.traces["brake_torque"], color="0.7", label="merged", zorder=1)
    for number, path in enumerate(parts, start=1):
        part = apesim.read_archive(path)
        axis.plot(part.traces["speed_rpm"], part.traces["brake_torque"], "o", label=f"part {number} of 3")
    axis.set(xlabel="speed [r/min]", ylabel="brake torque [N m]", title="cam, 1.0 MPa gauge, 287 K")
    axis.legend()
    plt.show()

# %%
# The points of the parts alternate, so that each part covers the whole range of speeds and takes about the same time.
#
# The figure does not show how much time this saves. For a sweep as short as this one it saves none: starting the
# workers takes longer than the computation. On one machine, ``jobs=4`` shares the work among four processes without a
# cluster. More in :doc:`/guide/sweeps`.
