"""The commands of archives, a file each; machine_differences is what several of them show."""

from apesim.studies.commands.archive.diff import compare_archives
from apesim.studies.commands.archive.export import export_archive
from apesim.studies.commands.archive.info import show_info
from apesim.studies.commands.archive.merge import merge_archives
from apesim.studies.commands.archive.verify import verify_archive
from apesim.studies.commands.options import group

archive = group(
    "Archives of results. With --machine or --set, commands also say whether they were made with it.",
    {
        "info": show_info,
        "verify": verify_archive,
        "diff": compare_archives,
        "export": export_archive,
        "merge": merge_archives,
    },
)
