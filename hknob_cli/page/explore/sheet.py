"""The page of ``hknob explore`` as one HTML file that needs nothing else and asks for nothing."""

import json
from typing import Any

from hknob_cli import __version__
from hknob_cli.page.explore.knob import KINDS, Knobs
from hknob_cli.page.template_files import digest, packaged, template_of
from hknob_cli.specs.controller import KINDS as EVERY

_FOLDER = "explore"
# Each script is the files of a folder, or one file.
_ENGINE = ("plant", "controllers", "cell", "motion", "trial", "cycle", "measure", "solve")
_VIEW = ("words", "sliders", "answer", "clock", "window", "pictures", "sound", "begin")
MARK = "<!-- hknob explore -->"  # in the second line: by it the command knows its own files


def sheet(knobs: Knobs) -> str:
    """HTML of the page; the same text for the same knobs. Its policy allows only the scripts and the style in it."""
    from markupsafe import Markup

    style = packaged(_FOLDER, "page.css")
    scripts = [engine(), packaged(_FOLDER, "remedies.js"), _joined("view", _VIEW)]
    data = {"cells": knobs.cells, "touch": knobs.touch, "slug": knobs.name}
    left_out = ", ".join(_words(kind) for kind in EVERY if kind not in KINDS)
    return template_of(_FOLDER).render(
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
    return '(() => {\n"use strict";\n' + "".join(packaged(_FOLDER, f"{folder}/{name}.js") for name in names) + "})();\n"


def _hash(text: str) -> str:
    """A script or style as a content security policy names it."""
    return f"'{digest(text)}'"


def _in_html(data: dict[str, Any]) -> str:
    """JSON that no HTML parser takes for the end of its element, or for another one's beginning."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _words(kind: str) -> str:
    return kind.replace("_", " ")
