"""Platforms that an FMU runs on."""

from typing import NamedTuple


class Platform(NamedTuple):
    """Platform, by its names in the standards."""

    name: str
    """Name of LLVM's target."""
    fmi2: str
    """Folder in an FMU of FMI 2."""
    fmi3: str
    """Folder in an FMU of FMI 3."""
    ending: str
    """Ending of the library's name."""
    zig: str
    """Name of Zig's target."""


LINUX = Platform("x86_64-unknown-linux-gnu", "linux64", "x86_64-linux", ".so", "x86_64-linux-gnu.2.17")
WINDOWS = Platform("x86_64-pc-windows-gnu", "win64", "x86_64-windows", ".dll", "x86_64-windows-gnu")
PLATFORMS = LINUX, WINDOWS
"""All of them."""
