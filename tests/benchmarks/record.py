"""What was measured, a line for each row and release, in ``performance.csv``."""

import csv
import datetime
import os
from pathlib import Path

from tests.folders import find_commit

FILE = Path(__file__).with_name("performance.csv")
NOW = "now"
"""Label of the code that is checked out."""
MEASURED = ("seconds", "processor_seconds", "cycles", "evaluations", "contacts_off", "why")
COLUMNS = ("name", "group", "words", "code", *MEASURED, "date", "commit", "processor", "cores", "load")


def describe_run():
    """Day, commit of "now", processor, and other load before anything is measured: columns of each line."""
    from apesim.archive.surroundings import processor

    date, load = datetime.date.today().isoformat(), f"{os.getloadavg()[1]:.1f}"
    return {"date": date, "commit": find_commit(), "processor": processor(), "cores": str(os.cpu_count()), "load": load}


def read_record(file: Path = FILE) -> list[dict[str, str]]:
    """Lines of the record, by column; none where there is no file."""
    if not file.exists():
        return []
    with file.open(newline="") as lines:
        return list(csv.DictReader(lines))


def update_record(lines: list[dict[str, object]], file: Path = FILE) -> None:
    """Put lines in the place of those with the same name and code, or at the end."""
    kept = {(line["name"], line["code"]): line for line in read_record(file)}
    kept |= {(line["name"], line["code"]): line for line in lines}
    with file.open("w", newline="") as out:
        writer = csv.DictWriter(out, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept.values())
