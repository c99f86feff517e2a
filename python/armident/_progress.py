"""Progress of long commands in notebooks: a bar of tqdm, where tqdm is installed."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import sys
import threading
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

Item = TypeVar("Item")

#: Seconds between two looks at the clock.
_TICK_S = 0.2
#: Seconds before a bar is worth showing.
_DELAY_S = 0.5

_wish: bool | None = None


def show_progress(shown: bool | None) -> None:
    """Show progress of long commands, or hide it.

    Args:
        shown: True: always; False: never; None: in notebooks. Without the package tqdm there is none.
    """
    global _wish
    _wish = shown


def in_notebook() -> bool:
    """Whether this is a kernel of Jupyter."""
    # a module that was never imported has no shell
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module is not None else None
    return shell is not None and type(shell).__name__ == "ZMQInteractiveShell"


def _bars() -> Any:
    """The class of bars; None where there are none."""
    if _wish is False or (_wish is None and not in_notebook()):
        return None
    # widgets need a package of their own
    has_widgets = in_notebook() and importlib.util.find_spec("ipywidgets") is not None
    try:
        return importlib.import_module("tqdm.notebook" if has_widgets else "tqdm").tqdm
    except ImportError:
        return None


def steps(items: Iterable[Item], doing: str) -> Iterator[Item]:
    """The items, with a bar where there are several."""
    every = list(items)
    bars = _bars() if len(every) > 1 else None
    yield from every if bars is None else bars(every, desc=doing, leave=False, delay=_DELAY_S)


@contextlib.contextmanager
def working(doing: str) -> Iterator[None]:
    """A line with the time that the work inside has taken; its length is not known beforehand."""
    bars = _bars()
    if bars is None:
        yield
        return
    ended = threading.Event()

    def show() -> None:
        if ended.wait(_DELAY_S):
            return
        with bars(desc=doing, bar_format="{desc} {elapsed}", leave=False) as bar:
            while not ended.wait(_TICK_S):
                bar.refresh()

    # the work itself runs without the interpreter
    thread = threading.Thread(target=show, name="armident-progress", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
