"""Progress bars: by tqdm if it is installed, otherwise as a line of text."""

import sys
import warnings
from typing import Any, Callable, Optional, Union


def _in_notebook() -> bool:
    """Whether the program is the kernel of a notebook."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return type(shell).__name__ == "ZMQInteractiveShell"


class _Bar:
    """A bar from the first report to the end of the render. done, total: numbers of samples."""

    def __init__(self) -> None:
        self._bar: Any = None

    def __call__(self, done: int, total: int) -> None:
        if self._bar is None:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # tqdm's advice to install ipywidgets
                    from tqdm.auto import tqdm
            except ImportError:
                tqdm = _Line
            self._bar = tqdm(total=total, desc="render", unit="sample", unit_scale=True, leave=False)
        self._bar.total = total  # an estimate with noise_target and time_limit
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


class _Line:
    """A line of text that is written again and again."""

    def __init__(self, total: int, **_: Any) -> None:
        self.n, self.total = 0, total

    def update(self, count: int) -> None:
        """Adds samples."""
        self.n += count
        sys.stderr.write(f"\rrender: {100 * self.n // self.total:3d} %")
        sys.stderr.flush()

    def close(self) -> None:
        """Removes the line."""
        sys.stderr.write("\r" + " " * 14 + "\r")


def bar_for(progress: Union[Callable[[int, int], Any], bool, None]) -> Optional[Callable[[int, int], Any]]:
    """The function to call for the argument `progress` of render(): None means a bar in notebooks."""
    if progress is None:
        progress = _in_notebook()
    return _Bar() if progress is True else progress or None
