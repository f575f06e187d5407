"""Errors of materials."""

from __future__ import annotations

__all__ = ["GenomeError"]


class GenomeError(ValueError):
    """Error of reading a genome; the message says what is wrong.

    Attributes:
        line: Line of the text, from 1; None if the error has no place in a text.
        column: Column of the text in characters, from 1; None as above.
        pointer: JSON pointer to the value of a genome as JSON; None for other forms.
    """

    line: int | None
    column: int | None
    pointer: str | None

    def __init__(
        self,
        message: str,
        line: int | None = None,
        column: int | None = None,
        pointer: str | None = None,
    ) -> None:
        """Makes an error at a place of the text, or of the JSON.

        Args:
            message: Description.
            line: Line of the text, from 1.
            column: Column of the text, from 1.
            pointer: JSON pointer.
        """
        super().__init__(message, line, column, pointer)
        self.line = line
        self.column = column
        self.pointer = pointer

    def __str__(self) -> str:
        """Returns the message."""
        return str(self.args[0])
