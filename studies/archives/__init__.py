"""Archives of results: what they hold, whether they are whole, how two differ, and joining and exporting them.

Files in the order in which an archive meets them: result_kinds (by their names), archive_result (what every result of
an archive is), description, verification, comparison, machines (beside one that is given), grid_result (over a grid),
pressure_axes (of such a grid), run_result (of one run), joining.
"""
