"""The documentation's site: `python -m sphinx -W docs build/site`."""

import os
import pathlib
import sys

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "scdpr-jax"
copyright = "the scdpr-jax authors, MIT licence"
extensions = ["myst_parser"]
myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["paper/*"]
html_theme = "furo"
html_title = "scdpr-jax"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
# A summary is fetched, which a browser refuses where the site is a folder.
html_show_search_summary = False
# Words of the API's signatures aren't looked up: types are told in the text.
nitpicky = False


def _inline(self: HTML5Translator, node: nodes.math) -> None:
    """A formula in a line, as MathML: every browser draws it, and nothing is fetched."""
    self.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(self: HTML5Translator, node: nodes.math_block) -> None:
    """A formula of its own."""
    self.body.append(f"<div>{convert(node.astext(), display='block')}</div>")
    raise nodes.SkipNode


def _make(app: Sphinx) -> None:
    """What is made by the build: the API's pages, and the pictures where there are none."""
    # Looking for other devices is told as if something were amiss.
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    import api_pages

    api_pages.write_pages(HERE / "api")
    if not (HERE / "pictures" / "plan.svg").exists():
        import pictures

        pictures.main(HERE / "pictures")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register what is this site's own.

    Args:
        app: The builder.

    Returns:
        What the builder may do with it.
    """
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("builder-inited", _make)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
