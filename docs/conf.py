"""Sphinx's settings of the site; `make_site.py` lays out its pages and builds it."""

import os

# Kernels are read as the plain functions that they are: with their signatures and docstrings.
os.environ["NUMBA_DISABLE_JIT"] = "1"

project = "scara_drake"
author = "the authors of scara_drake"
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "myst_nb",
    "site_extension",
]
root_doc = "index"
smartquotes_action = "D"  # dashes alone: a quote in a table is a value

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # `run_notebooks.py` has executed them
nb_merge_streams = True
nb_ipywidgets_js: dict[str, dict[str, str]] = {}  # no script of another host

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 88
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_use_param = False
default_role = "py:obj"  # a name in single backticks, linked where it is on the site
nitpicky = True
nitpick_ignore_regex = [
    ("py:obj", ".*"),
    # Types in signatures: other packages', and ours that have no page.
    ("py:class", ".*"),
    ("py:exc", ".*"),
]

html_theme = "furo"
html_title = "scara_drake"
html_math_renderer = "mathml"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_domain_indices = False  # the index of names has the modules too
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
copybutton_exclude = ".linenos, .gp, .go"
highlight_language = "text"
pygments_style = "friendly"
pygments_dark_style = "monokai"
