"""Archives of results: what they hold, whether they are whole, how two differ, and joining and exporting them.

Files in the order in which an archive meets them: description, verification, comparison, machines (beside one that is
given), joining.
"""
