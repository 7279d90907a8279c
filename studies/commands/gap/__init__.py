"""The commands of what measurements show and the model does not, a file each; inputs is what they read first."""

from apesim.studies.commands.gap.effects import list_effects
from apesim.studies.commands.gap.explain import explain_gap
from apesim.studies.commands.gap.isolability import show_isolability
from apesim.studies.commands.options import group

gap = group(
    "Effects that the model leaves out.",
    {"effects": list_effects, "explain": explain_gap, "isolability": show_isolability},
)
