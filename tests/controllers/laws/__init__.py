"""Every kind of controller once more, apart from the package: one file a kind, found by being there.

Each has the controller as its source has it (`Source`), the block of docs/reference/controllers.md (`Block`), and
variants.
"""

from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

LAWS: dict[str, ModuleType] = {one.name: import_module(f"{__name__}.{one.name}") for one in iter_modules(__path__)}
CONTROLLERS: dict[str, dict[str, Any]] = {
    name: given for law in LAWS.values() for name, given in law.CONTROLLERS.items()
}
# Those that only the compiled general loop has; and all.
LOOP_ONLY: dict[str, dict[str, Any]] = {
    name: given for law in LAWS.values() for name, given in getattr(law, "LOOP_ONLY", {}).items()
}
EVERY: dict[str, dict[str, Any]] = {**CONTROLLERS, **LOOP_ONLY}
