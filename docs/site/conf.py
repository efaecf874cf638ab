"""Configuration of the site: ``make site``. With ``-t pages`` the pages of the API are left out, which take longer than all others."""

import sys
from pathlib import Path

from sphinx.application import Sphinx


sys.path.insert(0, str(Path(__file__).parent))

import pictures
import references
import staging
import timing


project = "Stereo graph cut"
version = staging.version()
copyright = ""
extensions = ["myst_parser", "sphinx.ext.autodoc"]
root_doc = "docs/site/index"

myst_heading_anchors = 4    # links to headings are those of GitHub
nitpicky = True
nitpick_ignore_regex = [("py:.*", pattern) for pattern in references.ELSEWHERE]
add_module_names = False
autodoc_inherit_docstrings = False

html_theme = "furo"
html_title = f"{project} {version}"
html_extra_path = ["root"]      # the site's front page is not at its root
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_copyright = False
html_copy_source = False


def setup(app: Sphinx) -> None:
    """Make the sources before Sphinx looks for them."""
    made = {f"docs/site/pictures/{name}": content for name, content in pictures.pictures().items()}
    made |= {f"docs/site/timing/{name}": content for name, content in timing.diagrams().items()}
    if not app.tags.has("pages"):
        made |= staging.api_pages()
    staging.stage(Path(app.srcdir), made)
    app.connect("autodoc-process-docstring", references.sections)
    app.connect("missing-reference", references.resolve)
