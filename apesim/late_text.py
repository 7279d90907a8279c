"""Texts that are written when they are first read."""

from collections.abc import Callable


class LateText:
    """Text of a machine in a dataclass; a function that writes it is called when the text is first read.

    To write a machine takes as long as many marches of its valve, and most results are never asked for it.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, holder: object, owner: type | None = None) -> str:
        if holder is None:  # the default of the dataclass's field
            return ""
        held = vars(holder)[self.name]
        if not isinstance(held, str):
            held = vars(holder)[self.name] = held()
        return held

    def __set__(self, holder: object, text: str | Callable[[], str]) -> None:
        vars(holder)[self.name] = text
