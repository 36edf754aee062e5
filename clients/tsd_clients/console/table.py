"""Tables that fit the terminal: where it is narrow, what matters least is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

# as wide as the terminal, or COLUMNS; 80 columns where the output is no terminal
console = Console()
# between two columns: the padding of the left one and the box's divider
BETWEEN = 2
# rows; Rich takes more than a millisecond for one of ten columns
MOST_DRESSED = 100


@dataclass(frozen=True)
class Column:
    """One column of a table.

    Attributes:
        heading: Above the cells; may have several lines.
        cells: With Rich's markup.
        rank: 0 is always shown; of the others the highest leaves first.
        is_text: Aligned to the left; numbers are to the right.
    """

    heading: str
    cells: Sequence[str]
    rank: int = 0
    is_text: bool = False


def print_table(title: str, columns: Sequence[Column]) -> None:
    """Print as many columns as there is room for, and name those there is none for.

    Cells stay in one line. Only where not even the columns of rank 0 fit do texts
    break, between words.

    Args:
        title: Above the table; empty for none.
        columns: In the order they are shown.
    """
    shown, left_out = list(columns), []
    # Rich would measure every cell anew for each column that leaves
    widths = {id(column): _column_width(column) for column in columns}

    def width() -> int:
        return sum(widths[id(column)] for column in shown) + BETWEEN * (len(shown) - 1)

    while width() > console.width and any(column.rank for column in shown):
        last = max(shown, key=lambda column: column.rank)
        shown.remove(last)
        left_out.append(last)
    console.print()
    if title:
        console.print(f"[italic]{escape(title)}[/italic]", highlight=False)
    if len(columns[0].cells) > MOST_DRESSED and width() <= console.width:
        console.out("\n".join(plain_lines(shown)), highlight=False)
    else:
        console.print(_table(shown, may_break=width() > console.width))
    if left_out:
        # in the order of the table
        names = [" ".join(column.heading.split()) for column in columns if column in left_out]
        console.print(
            f"[dim]no room for {escape(', '.join(names))}: a wider terminal shows it, the JSON "
            "has it[/dim]",
            highlight=False,
        )


def plain_lines(columns: Sequence[Column]) -> list[str]:
    """Lay a table out as Rich would, without bold letters: some hundred times faster."""
    headings = [column.heading.split("\n") for column in columns]
    height = max(map(len, headings))
    filled = [[""] * (height - len(lines)) + lines for lines in headings]
    texts = [
        [*heading, *map(_text, column.cells)]
        for heading, column in zip(filled, columns, strict=True)
    ]
    widths = [max(map(cell_len, each)) for each in texts]
    aligned = [
        [_aligned(text, width, column.is_text) for text in each]
        for each, width, column in zip(texts, widths, columns, strict=True)
    ]
    lines = ["  ".join(cells) for cells in zip(*aligned, strict=True)]
    rule = "─" * (sum(widths) + BETWEEN * (len(columns) - 1))
    return [line.rstrip() for line in (*lines[:height], rule, *lines[height:])]


def _aligned(text: str, width: int, is_text: bool) -> str:
    blank = " " * (width - cell_len(text))
    return text + blank if is_text else blank + text


def _text(cell: str) -> str:
    # only what may be markup or an emoji's name has to be parsed, which takes long
    return Text.from_markup(cell).plain if "[" in cell or ":" in cell else cell


def _table(columns: Sequence[Column], *, may_break: bool) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False, pad_edge=False)
    for column in columns:
        breaks = may_break and column.is_text
        table.add_column(
            column.heading, justify="left" if column.is_text else "right", no_wrap=not breaks
        )
    for row in zip(*(column.cells for column in columns), strict=True):
        table.add_row(*row)
    return table


def _column_width(column: Column) -> int:
    lines = [line for cell in (column.heading, *column.cells) for line in cell.split("\n")]
    return max(cell_len(_text(line)) for line in lines)
