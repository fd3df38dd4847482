"""Files of a page as they lie in the package: its template, and what goes into it by a policy that names each."""

import base64
import hashlib
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import Template


def packaged(folder: str, name: str) -> str:
    """A file of a folder of this one, by its path there."""
    return files("hknob_cli.page").joinpath(folder, *name.split("/")).read_text(encoding="utf-8")


def template_of(folder: str) -> "Template":
    """The HTML of a page, which may include other files of its folder."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        loader=FunctionLoader(lambda name: packaged(folder, name)),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("page.html.j2")


def digest(text: str) -> str:
    """SHA-256 of a script or style, as a page's policy names what it allows."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
