"""Tables for the screen, and the same tables as Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import MARKDOWN, SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

_WIDE = 400  # characters: Markdown lines are never folded


def new_table(title: str, *columns: str) -> Table:
    """Return an empty table: the first column for names, the others for figures."""
    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if index else "left", no_wrap=index == 0)
    return table


def print_tables(tables: Sequence[Table], markdown: bool) -> None:
    """Print tables on stdout, for a person or as Markdown."""
    for table in tables:
        if markdown:
            print(_markdown(table))
        else:
            Console().print(table, "")


def _markdown(table: Table) -> str:
    """Return a table as Markdown, under a heading."""
    heading, table.title = f"## {table.title}\n\n", None
    table.box, table.pad_edge = MARKDOWN, True
    for row in table.rows:
        row.end_section, row.style = False, None
    console = Console(width=_WIDE)
    with console.capture() as captured:
        console.print(table)
    return heading + "".join(f"{line.rstrip()}\n" for line in captured.get().strip().splitlines())
