"""Controllers beside the plain virtual wall, each a small array program, and their exact motion side by side.

- one file a controller
- `controller` what a controller is
- `plant_batch`, `cells` plants side by side
- `batch_stepper` a sample of them, exact
- `repeat` until they repeat, `search` to their ends
- `period_run` one period, `contraction` how distances fall over it, `proof` of its orbit
- `trajectory` one trial. `sets/`: all starts at once (`counting` where they are cut, `arcs` and `polygons`, `front`
  sets side by side, `captors` what captures them, `follow` to their ends)

Controllers (`controllers/`) are array programs over all trials of one sample rate, so that a new one is a small file
and needs no compiler. Between counts, and between signs of what a controller says it switches on, a sample is an
affine map of position, velocity and memory; perturbed copies beside a motion give the derivative of its period
up to rounding, Newton's method gives the orbit, and P = Σ (Aᵏ)ᵀ Aᵏ the distance that falls from period to period.
A trial whose distance cannot reach a switch is captured. What is not piecewise affine (a Kalman filter) is never
called proven. All states with the same counts so far have the same memory, so sets of them are cut and captured as
those of the plain wall, as lanes (`sets/`). The plain wall keeps its own engine.
"""
