"""Progress bars, by the optional package tqdm."""

from __future__ import annotations

from types import TracebackType
from typing import Any

__all__ = ["Progress"]


class Progress:
    """Bar from 0 to 1 as a context manager; without `shown`, it does nothing."""

    def __init__(self, title: str, shown: bool) -> None:
        """Makes the bar.

        Args:
            title: Text in front of the bar.
            shown: True to show it.

        Raises:
            ImportError: If it is to be shown and tqdm is not installed.
        """
        self._bar: Any = None
        if shown:
            try:
                from tqdm.auto import tqdm
            except ImportError as error:
                words = "progress=True needs tqdm: pip install 'brood-brdf[notebook]'"
                raise ImportError(words) from error
            # Thousandths: tqdm prints the share of a total, and sums of floats would drift.
            self._bar = tqdm(total=1000, desc=title, bar_format="{l_bar}{bar}| {elapsed}{postfix}")

    def show(self, share: float, words: str) -> None:
        """Moves the bar to a share of 0 to 1, and shows words behind it."""
        if self._bar is not None:
            self._bar.set_postfix_str(words, refresh=False)
            self._bar.update(round(1000 * share) - self._bar.n)

    def __enter__(self) -> Progress:
        """Returns itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()
