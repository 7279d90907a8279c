"""Archives: results in HDF5 files that outlive the program.

In the order in which they build on one another: records (what an archive holds in memory), columns (a value for each
run), digests, conventions (attributes for other programs), surroundings (where results are computed), errors,
untrusted (guards against damaged and strangers' files), loading (datasets as they are stored), migration (older format
versions), writing (files for users, complete or absent), file (write and read), grid (named axes), comparison, lock,
shards (of a running sweep), merge (of parts), completeness (which runs are missing), inspection.
"""

from apesim.archive.file import (
    Archive,
    ArchiveError,
    DamagedError,
    IncompleteError,
    Variable,
    command_line,
    read,
    read_about,
    read_digest,
    sha256,
    validate,
    write,
)
from apesim.archive.writing import find_target, remove_file, write_file

__all__ = [
    "Archive",
    "ArchiveError",
    "DamagedError",
    "IncompleteError",
    "Variable",
    "command_line",
    "find_target",
    "read",
    "read_about",
    "read_digest",
    "remove_file",
    "sha256",
    "validate",
    "write",
    "write_file",
]
