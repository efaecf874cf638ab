"""Sections of text, tables and pictures, and the two pages made of them."""

import base64
import functools
import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ...pages import table as table_lines


__all__ = ["Picture", "Section", "Table", "html", "markdown"]


@dataclass(frozen=True)
class Picture:
    """A PNG file.

    Parameters
    ----------
    name : str
        Of the file, without suffix.
    caption : str
    draw : callable
        Gives the PNG data; called when they are first read.
    """
    name: str
    caption: str
    draw: Callable[[], bytes]

    @functools.cached_property
    def png(self) -> bytes:
        return self.draw()


@dataclass(frozen=True)
class Table:
    """Rows under a head; the first ``words`` columns are words, the others numbers."""
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1


@dataclass(frozen=True)
class Section:
    """A heading, and below it paragraphs, tables and pictures.

    Parameters
    ----------
    title : str
    paragraphs : sequence of str
        Text within backquotes is set as code.
    tables : sequence of Table
    pictures : sequence of Picture
    left_out : sequence of str
        Names of the parts that a quick run leaves out.
    """
    title: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = field(default_factory=tuple)
    left_out: Sequence[str] = ()

    @property
    def text(self) -> list[str]:
        """The paragraphs, and one that names what is left out."""
        return [*self.paragraphs, *([f"Left out by `--quick`: {'; '.join(self.left_out)}."] if self.left_out else [])]


HTML = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ title }}</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 66rem; margin: 2rem auto; padding: 0 1rem; }
h2 { margin-top: 3rem; border-bottom: 1px solid #ccc; }
figure { margin: 1.5rem 0; }
figure img { max-width: 100%; height: auto; }
figcaption { color: #555; font-size: .9rem; }
div.table { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .7rem; border-bottom: 1px solid #ddd; text-align: right; }
table.wide { font-size: .78rem; }
table.wide th, table.wide td { padding: .2rem .35rem; }
th.word, td.word { text-align: left; }
td.word { white-space: nowrap; }
</style>
</head>
<body>
<h1>{{ title }}</h1>
<p>{{ foreword | code }}</p>
<nav><ul>
{%- for section in sections %}
<li><a href="#s{{ loop.index }}">{{ section.title }}</a></li>
{%- endfor %}
</ul></nav>
{%- for section in sections %}
<h2 id="s{{ loop.index }}">{{ section.title }}</h2>
{%- for paragraph in section.text %}
<p>{{ paragraph | code }}</p>
{%- endfor %}
{%- for picture in section.pictures %}
<figure><img src="data:image/png;base64,{{ picture.png | base64 }}" alt="{{ picture.caption }}">
<figcaption>{{ picture.caption }}</figcaption></figure>
{%- endfor %}
{%- for table in section.tables %}
<div class="table"><table{{ " class=wide" if table.head | length > 9 }}>
<tr>{% for cell in table.head %}<th{{ " class=word" if loop.index <= table.words }}>{{ cell }}</th>{% endfor %}</tr>
{%- for row in table.rows %}
<tr>{% for cell in row %}<td{{ " class=word" if loop.index <= table.words }}>{{ cell }}</td>{% endfor %}</tr>
{%- endfor %}
</table></div>
{%- endfor %}
{%- endfor %}
</body>
</html>
"""


def html(title: str, foreword: str, sections: Sequence[Section]) -> str:
    """One page that needs no other file: the pictures are part of it."""
    import jinja2  # here, because only this needs it
    import markupsafe

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    environment.filters["code"] = lambda text: markupsafe.Markup(re.sub("`(.*?)`", r"<code>\1</code>", str(markupsafe.escape(text))))
    environment.filters["base64"] = lambda data: base64.b64encode(data).decode("ascii")
    page: str = environment.from_string(HTML).render(title=title, foreword=foreword, sections=sections)
    return page


def markdown(title: str, foreword: str, sections: Sequence[Section], folder: str) -> str:
    """The same in Markdown; the pictures are files in ``folder``, next to the page."""
    lines = [f"# {title}", "", foreword]
    for section in sections:
        lines += ["", f"## {section.title}"]
        lines += itertools.chain.from_iterable(("", paragraph) for paragraph in section.text)
        for picture in section.pictures:
            lines += ["", f"![{picture.caption}]({folder}/{picture.name}.png)", "", f"*{picture.caption}*"]
        for table in section.tables:
            lines += ["", *table_lines(table.head, table.rows, table.words)]
    return "\n".join(lines) + "\n"
