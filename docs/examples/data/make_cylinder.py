"""Make the folders ``cylinder_o_ring`` and ``cylinder_x_ring`` from the records of a laboratory.

The records are those of E. Zillen, H. Vallery and G. Smit, TU Delft 2021, "3D printed pneumatic actuator", GitHub
EvaZillen/3D-printed-pneumatic-actuator, CC0 1.0: a cylinder of 25.7 mm bore, one chamber pressurised, moved slowly to
and fro by a drive. They have no header and seven columns: time [ms], laser [V], pressure [V], force [V], stroke [mm],
pressure [bar gauge] and force [N].

Each is thinned to means of three rows (30 ms, 0.2 to 0.4 mm of the stroke), and the start-up is left out. Call it with
the folder of the records: ``python docs/examples/data/make_cylinder.py seal-friction``.
"""

import sys
from pathlib import Path

import numpy as np

START_UP = 15
"""Rows at the beginning in which the recorder starts."""
MEANS_OF = 3
"""Rows that are averaged."""
ROLES = {1: "fit", 3: "gate", 5: "fit", 7: "gate"}
"""Role of each pressure [bar gauge]: fitted in the middle and near the lower end, held out between and above."""
RECORDS = {
    "cylinder_o_ring": [("O-ring257_{}bar", ""), ("O-ring257_{}bar_reconnected", "reconnected_")],
    "cylinder_x_ring": [("X-ring257_{}bar", "")],
}
"""Records of each folder, and how ours begin; the rig that was taken apart and set up again is kept for the check."""
CITATION = "# E. Zillen, H. Vallery, G. Smit, TU Delft 2021, 3D printed pneumatic actuator, CC0 1.0"
FORMATS = "%.1f", "%.3f", "%.4f", "%.2f"
HEADER = "time [ms],stroke [mm],pressure [bar gauge],force [N]"


def thin(record: np.ndarray) -> np.ndarray:
    """Average the rows of a record in groups, without the start-up.

    Parameters
    ----------
    record : (n, 7) float array
        As the laboratory wrote it.

    Returns
    -------
    (m, 4) float array
        Columns of `HEADER`.

    Examples
    --------
    >>> thin(np.tile(np.arange(18.0)[:, None], 7)).tolist()
    [[16.0, 16.0, 16.0, 16.0]]
    """
    rows = record[START_UP:, [0, 4, 5, 6]]
    whole = len(rows) // MEANS_OF * MEANS_OF
    return rows[:whole].reshape(-1, MEANS_OF, rows.shape[1]).mean(axis=1)


def main(source: Path, target: Path) -> None:
    """Write the folders.

    Parameters
    ----------
    source : path
        Folder of the records.
    target : path
        Folder in which ours are made.
    """
    for folder, records in RECORDS.items():
        (target / folder).mkdir(exist_ok=True)
        about = [CITATION, 'bench = "cylinder"']
        for pattern, begin in records:
            for pressure, role in ROLES.items():
                name = f"{begin}{pressure}_bar.csv"
                rows = thin(np.loadtxt(source / f"{pattern.format(pressure)}.csv"))
                np.savetxt(target / folder / name, rows, FORMATS, ",", header=HEADER, comments="")
                about += ["", "[[run]]", f'data = "{name}"', f'supply = "{pressure} bar gauge"']
                about += [f'role = "{"check" if begin else role}"']
        (target / folder / "measured.toml").write_text("\n".join(about) + "\n")
        (target / folder / "machine.toml").write_text('[rig]\nbore = "25.7 mm"\n')


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(__file__).parent)
