"""The page of ``hknob explore`` as one HTML file that needs nothing else and asks for nothing."""

import base64
import hashlib
import json
from importlib.resources import files
from typing import Any

from hknob_cli import __version__
from hknob_cli.page.explore.knob import KINDS, Knobs
from hknob_cli.specs.controller import KINDS as EVERY

# Each script is the files of a folder, or one file.
_ENGINE = ("plant", "controllers", "cell", "motion", "trial", "cycle", "measure", "solve")
_VIEW = ("words", "sliders", "answer", "clock", "window", "pictures", "sound", "begin")
MARK = "<!-- hknob explore -->"  # in the second line: by it the command knows its own files


def sheet(knobs: Knobs) -> str:
    """HTML of the page; the same text for the same knobs. Its policy allows only the scripts and the style in it."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FunctionLoader(packaged),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    style = packaged("page.css")
    scripts = [engine(), packaged("remedies.js"), _joined("view", _VIEW)]
    data = {"cells": knobs.cells, "touch": knobs.touch, "slug": knobs.name}
    left_out = ", ".join(_words(kind) for kind in EVERY if kind not in KINDS)
    return environment.get_template("page.html.j2").render(
        mark=Markup(MARK),
        name=knobs.name,
        notes=knobs.notes,
        touch=knobs.touch,
        carried="plain wall, virtual damping, rounding, "
        + ", ".join(_words(kind) for kind in KINDS)
        + ", and changes of the knob itself",
        left_out=f"Not in this page, and not approximated: {left_out}, velocity sensors and estimators, a finger apart "
        "from the knob, lag, torque over the angle, continuous sensors. The command has them.",
        style=Markup(style),
        scripts=[Markup(text) for text in scripts],
        hashes={"style": _hash(style), "scripts": " ".join(map(_hash, scripts))},
        data=Markup(_in_html(data)),
        versions=f"Made by hknob explore, hknob {__version__}.",
    )


def engine() -> str:
    """The script that makes ``Knob``, the engine: it follows trials, and needs no page."""
    return f"const Knob = {_joined('engine', _ENGINE)}"


def _joined(folder: str, names: tuple[str, ...]) -> str:
    """Files of a folder as one function that is called at once."""
    return '(() => {\n"use strict";\n' + "".join(packaged(f"{folder}/{name}.js") for name in names) + "})();\n"


def packaged(name: str) -> str:
    """A file of the page as it lies in the package."""
    return files("hknob_cli.page").joinpath("explore", *name.split("/")).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """A script or style as a content security policy names it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _in_html(data: dict[str, Any]) -> str:
    """JSON that no HTML parser takes for the end of its element, or for another one's beginning."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _words(kind: str) -> str:
    return kind.replace("_", " ")
