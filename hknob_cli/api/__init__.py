"""hknob from Python: ``import hknob_cli as hk``. The commands' results and provenance, as data frames and figures.

>>> found = hk.sweep("experiments/my_knob.yaml", {"scene.wall.stiffness": 0.5})
>>> found.cells[["sample_rate_hz", "p2p_max_rad"]], found.figure()

- `stages` a function a stage, what they return, and `stages.load`
- `scene` a scene to build specs from
"""

from hknob_cli.api.scene import Scene as Scene
from hknob_cli.api.stages import Results as Results
from hknob_cli.api.stages import design as design
from hknob_cli.api.stages import dfa as dfa
from hknob_cli.api.stages import load as load
from hknob_cli.api.stages import predict as predict
from hknob_cli.api.stages import remedies as remedies
from hknob_cli.api.stages import run as run
from hknob_cli.api.stages import sweep as sweep
from hknob_cli.api.stages import sysid as sysid
