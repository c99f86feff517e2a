"""Progress is shown where it is wished and tqdm is there, and changes no result."""

import sys
import time
import types

import pytest

import armident
from armident import _progress


class Bars:
    """Records what is shown."""

    def __init__(self):
        self.shown = []

    def tqdm(self, items=(), *, desc, **options):
        self.shown.append(desc)
        return Bar(items)


class Bar:
    def __init__(self, items):
        self.items = items

    def __iter__(self):
        return iter(self.items)

    def __enter__(self):
        return self

    def __exit__(self, *raised):
        pass

    def refresh(self):
        pass


@pytest.fixture
def bars(monkeypatch):
    bars = Bars()
    module = types.ModuleType("tqdm")
    module.tqdm = bars.tqdm
    monkeypatch.setitem(sys.modules, "tqdm", module)
    monkeypatch.setattr(_progress, "_DELAY_S", 0.0)
    yield bars
    armident.show_progress(None)


def test_outside_of_notebooks_nothing_is_shown(bars, train):
    assert not _progress.in_notebook()
    list(_progress.steps([1, 2], "reading"))
    with _progress.working("fitting"):
        time.sleep(0.1)
    assert bars.shown == []


def test_wish_shows_bars(bars, robot, train, holdout):
    armident.show_progress(True)
    assert list(_progress.steps([1, 2], "reading")) == [1, 2]
    # one item is no progress
    assert list(_progress.steps([1], "nothing")) == [1]
    armident.validate(robot, [train, holdout], replay=False)
    assert set(bars.shown) <= {"reading", "validating"} and "reading" in bars.shown
    with _progress.working("fitting"):
        time.sleep(0.1)
    assert "fitting" in bars.shown


def test_without_tqdm_nothing_is_shown(monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    armident.show_progress(True)
    try:
        assert list(_progress.steps([1, 2], "reading")) == [1, 2]
        with _progress.working("fitting"):
            pass
    finally:
        armident.show_progress(None)


def test_errors_pass_through(bars):
    armident.show_progress(True)
    with pytest.raises(ValueError, match="wrong"), _progress.working("fitting"):
        raise ValueError("wrong")
