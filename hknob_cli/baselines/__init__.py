"""Other ways to the same motion: SciPy, fixed steps, MuJoCo, and 60 digits. They share no formula with the engine.

- `model` the plant and its controller, which share no formula with the engine, and a trial from sample to sample
- `programs` SciPy and MuJoCo, `fixed_step`
- `digits60` the reference
- `stages/bench/timed.py` has them by name

Two models. What the engine is compared with is built in `baselines/` from the spec alone: equations of motion and a
command law, over any kind of number. With floats they serve the rivals; with 60 digits and matrix exponentials over
T/2ʲ, of which every hold is a product and by which every event is bisected, they are the reference.
"""
