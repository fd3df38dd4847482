"""Controllers beside the plain virtual wall, each a small array program, and sets of all starts under them.

Trials run in the compiled general loop (`engine.general.laws`); this is what sets of starts are made of.

- one file a controller
- `controller` what a controller is
- `plant_batch`, `cells` plants side by side
- `batch_stepper` a sample of them, exact
- `repeat` until they repeat, `search` to their ends
- `period_run` one period, `contraction` how distances fall over it, `proof` of its orbit
- `scalar_law` a controller as the compiled general loop runs it
- `sets/` all starts at once: `counting` where they are cut, `arcs` and `polygons`, `front` sets side by side,
  `captors` what captures them, `follow` to their ends

The array programs need no compiler. Between counts, and between signs of what a controller says it switches on, a
sample is an affine map of position, velocity and memory. Perturbed copies beside a motion give the derivative of its
period up to rounding, Newton's method gives the orbit, and P = Σ (Aᵏ)ᵀ Aᵏ the distance that falls from period to
period.
A trial whose distance cannot reach a switch is captured. What is not piecewise affine (a Kalman filter) is never
called proven. All states with the same counts so far have the same memory, so sets of them are cut and captured as
those of the plain wall, as lanes (`sets/`). The plain wall keeps its own engine.
"""
