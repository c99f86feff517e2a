"""Python blocks of the README and the book run, and print what the text block behind them shows."""

import contextlib
import io
import re
import shutil

import pytest

from conftest import PROJECT

PAGES = ["README.md", "docs/book/src/python.md"]
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n*^```text\n(.*?)^```\n)?", re.M | re.S)


def pattern(shown):
    """The shown text, in which a line `...` stands for any lines and `[..]` for anything in a line."""
    lines = [
        r"(?:.*\n)*?" if line == "..." else re.escape(line).replace(r"\[\.\.\]", ".*") + r"\n"
        for line in shown.splitlines()
    ]
    return "".join(lines)


@pytest.mark.parametrize("page", PAGES)
def test_blocks_run(page, tmp_path, monkeypatch):
    shutil.copytree(PROJECT / "urdf", tmp_path / "urdf")
    shutil.copytree(PROJECT / "examples" / "ur5", tmp_path / "examples" / "ur5")
    monkeypatch.chdir(tmp_path)
    blocks = BLOCK.findall((PROJECT / page).read_text())
    assert blocks
    names = {}
    for code, shown in blocks:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, page, "exec"), names)
        if shown:
            assert re.fullmatch(pattern(shown), printed.getvalue()), printed.getvalue()
