"""Which tests watch over which proofs: quick ones, that run in the interpreter."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "hknob_cli"
ENGINE = PACKAGE / "engine"
PROOF, SETS, GENERAL = "tests/engine/proof/", "tests/engine/sets/", "tests/engine/general/"
CAPTURE = (f"{PROOF}test_capture_margins.py", f"{SETS}test_ball.py")
CUTTING = (f"{PROOF}test_cutting_margins.py",)
ARCS = (f"{PROOF}test_arc_margins.py", f"{PROOF}test_arc_ends.py", f"{SETS}test_arc.py")
GENERAL_SETS = f"{GENERAL}sets/"
GENERAL_CAPTURE = (f"{PROOF}test_general_capture_margins.py", f"{GENERAL_SETS}test_arc.py")
GENERAL_CUTTING = (f"{PROOF}test_general_cutting_margins.py", f"{GENERAL_SETS}test_piece.py")
FRICTION_SETS = tuple(f"{PROOF}test_{name}_margins.py" for name in ("friction_set", "friction_piece", "lagged_piece"))
LAWS = (f"{PROOF}test_law_trial_margins.py",)
ORBIT = ("tests/engine/test_orbit_cycle.py", "tests/engine/test_orbit_margins.py")
FLANKS = (f"{PROOF}test_flank_rest_margins.py", f"{PROOF}test_teeth_margins.py")
TEETH_ON_SLOPES = tuple(f"{GENERAL}test_{name}_on_slopes.py" for name in ("teeth", "told", "flanks"))
TEETH = (
    f"{GENERAL}test_flanks.py",
    *TEETH_ON_SLOPES,
    *(f"{PROOF}test_teeth_{name}.py" for name in ("modes", "steps")),
    *FLANKS,
)
ABSENT = (f"{GENERAL}test_as_compiled.py",)
COG_REST = (f"{PROOF}test_cog_rest_margins.py", *ABSENT)
COGGING_MARGINS = (f"{PROOF}test_cogging_margins.py",)
SLOPES = (f"{GENERAL}test_slopes.py", f"{GENERAL}test_turning_points.py", *ABSENT)
COGGING = (*COGGING_MARGINS, f"{GENERAL}test_cogging.py", *SLOPES, *TEETH_ON_SLOPES)
STANDSTILL = (
    f"{PROOF}test_standstill_margins.py",
    *COG_REST,
    *FLANKS,
    f"{PROOF}test_runs_off.py",
    f"{GENERAL}test_inner_region.py",
)
BODIES = (
    "advance",
    "columns",
    "controller",
    "event_bounds",
    "inner_region",
    "laws",
    "over_angle",
    "powers",
    "proof",
    "search",
    "sensed",
    "slides",
    "torque_range",
    "torque_table",
    "trace",
)
PLAIN = ("attractors", "budget", "certificate", "ensemble", "extremes", "relay_cycles", "rest", "turning")
# Without those that run every pair of parts, and every preset.
SPEC_TESTS = (
    *(
        "bounds",
        "capabilities",
        "cells",
        "design",
        "edges_of_campaigns",
        "edges_of_identification",
        "edges_of_rules",
        "edges_of_stages",
        "edges_of_sweeps",
        "edges_of_words",
        "gear",
        "grid",
        "hand_from",
        "hand_of_table",
    ),
    *("motor", "over_angle", "parquet", "people", "points", "presets", "pulses", "quantity", "remedies", "schema"),
    *("seal", "source", "squeeze"),
)
OF_MEASURES = ("backlash", "energy_balance", "gear", "general_orbits", "motor", "peak_to_peak", "unsampled_motion")
CLI_OF_SPECS = ("explain", "new", "new_asks", "population", "predict", "presets", "remarks", "stdin", "sysid_foreign")
WIRED = (
    *("edges", "safety_margins", "block_order_margins", "sample_clock_margins", "replay_margins"),
    *("agreed_wall", "block_order", "campaign", "control", "frame", "journal", "knob_motion", "measures"),
    *("messages", "nuisances", "person", "pump", "replay", "safety", "sample_clock", "serial_device", "session"),
    *("pulse_campaign", "pulse_loop", "pulse_person", "spoilt_trials", "tables", "trial_phases"),
    *("trial_margins", "trial_run", "virtual", "virtual_motor", "wire_margins"),
    *("parts_by_hand", "reference_target"),
)
WATCHED: dict[str, tuple[str, ...]] = {
    "certificate.py": ("tests/engine/test_certificate.py", f"{PROOF}test_certificate_margins.py"),
    "ensemble.py": ("tests/engine/test_ensemble.py", "tests/engine/test_attractors.py"),
    "loop.py": ("tests/engine/test_ensemble.py", "tests/engine/test_turning.py", "tests/engine/test_attractors.py"),
    "propagator.py": ("tests/verification/test_propagator.py",),
    "turning.py": ("tests/engine/test_turning.py",),
    "rest.py": ("tests/engine/test_rest.py", f"{PROOF}test_rest_margins.py"),
    "follow.py": ("tests/engine/test_rest.py", f"{SETS}test_ball.py", f"{PROOF}test_follow_margins.py"),
    "sets/ball.py": CAPTURE,
    "sets/polygon.py": CUTTING,
    "sets/arc.py": (f"{PROOF}test_arc_search_margins.py", f"{PROOF}test_arc_margins.py"),
    "sets/arc_cut.py": ARCS,
    "sets/box.py": (f"{PROOF}test_box_margins.py",),
    "sets/cells.py": (f"{PROOF}test_cells_margins.py",),
    "sets/search.py": (f"{PROOF}test_set_search_margins.py",),
    "sets/region.py": (f"{PROOF}test_convex_region_margins.py",),
    "sets/absorbing.py": (f"{PROOF}test_absorbing_margins.py", f"{PROOF}test_no_region_margins.py"),
    **{f"orbit_{name}.py": ORBIT for name in ("cycle", "holds")},
    "measure/orbit.py": ("tests/measure/test_orbit.py",),
    "measure/unsampled.py": tuple(f"tests/measure/test_unsampled{end}.py" for end in ("", "_margins")),
    "measure/growth.py": tuple(f"tests/measure/test_growth{end}.py" for end in ("", "_by_hand")),
    "general/columns.py": (f"{GENERAL}test_columns.py", f"{GENERAL}test_advance.py"),
    "general/trace.py": (f"{GENERAL}test_trace.py",),
    "general/interval.py": (
        *(f"{PROOF}test_{name}_margins.py" for name in ("interval", "friction_alone")),
        f"{GENERAL}test_jitter.py",
        *ABSENT,
    ),
    "general/torque_table.py": (f"{GENERAL}test_torque_table.py", *ABSENT),
    "general/standstill.py": STANDSTILL,
    "general/inner_region.py": (f"{PROOF}test_region_margins.py", *FLANKS, f"{GENERAL}test_inner_region.py"),
    "general/teeth.py": TEETH,
    "general/teeth_ends.py": TEETH,
    "general/flanks.py": (*TEETH, f"{GENERAL}test_turning_points.py"),
    "general/flank_rest.py": FLANKS,
    "general/powers.py": (f"{PROOF}test_power_margins.py", f"{GENERAL}test_powers.py"),
    "general/orbit_proof.py": (f"{PROOF}test_period_map_margins.py", f"{PROOF}test_bent_margins.py"),
    "general/period_map.py": (
        *(f"{PROOF}test_{name}_margins.py" for name in ("period_map", "turn")),
        f"{GENERAL}test_parting.py",
    ),
    "general/torque_curve.py": (f"{GENERAL}test_curve_by_hand.py", f"{GENERAL}test_torque_curve.py", *ABSENT),
    "general/captured.py": (
        *(f"{PROOF}test_general_{name}_margins.py" for name in ("follow", "trial")),
        *(f"{GENERAL}test_{name}.py" for name in ("captured", "hysteresis")),
    ),
    "general/follow.py": (
        f"{PROOF}test_general_follow_margins.py",
        f"{PROOF}test_general_trial_margins.py",
        f"{PROOF}test_friction_alone_margins.py",
        f"{GENERAL}test_inner_region.py",
    ),
    "general/looks.py": (
        *(f"{PROOF}test_{name}_margins.py" for name in ("general_follow", "general_trial", "law_trial")),
        f"{GENERAL}test_inner_region.py",
    ),
    "general/hysteresis.py": (f"{PROOF}test_hysteresis_margins.py", f"{GENERAL}test_turning_points.py", *ABSENT),
    "general/body.py": (f"{GENERAL}test_body.py",),
    "general/slide_two.py": (f"{PROOF}test_two_state_slides.py", f"{GENERAL}test_slides.py"),
    "general/slide_many.py": (f"{PROOF}test_slide_margins.py",),
    "general/controller.py": tuple(f"{GENERAL}test_controller{end}.py" for end in ("", "_edges", "_curve")),
    "general/every_clock.py": (f"{GENERAL}test_every_clock_steps.py", f"{GENERAL}test_clock_cells.py"),
    "general/ensemble.py": (f"{PROOF}test_general_ensemble_margins.py",),
    "general/clock_cells.py": (f"{GENERAL}test_clock_cells.py",),
    "general/cogging.py": COGGING,
    "general/slopes.py": (*SLOPES, *COGGING_MARGINS),
    "general/slope_columns.py": (f"{GENERAL}test_slope_columns.py", *ABSENT),
    "general/corners.py": (f"{PROOF}test_corner_margins.py",),
    "general/piece_marks.py": (f"{GENERAL}test_piece_marks.py", f"{PROOF}test_corner_margins.py"),
    "general/cog_rest.py": COG_REST,
    "general/laws/period.py": (f"{PROOF}test_law_period_margins.py", *FLANKS),
    "general/laws/trials.py": (f"{PROOF}test_law_ensemble_margins.py",),
    "general/laws/cascade.py": LAWS,
    "general/laws/rest.py": (
        *(f"{PROOF}test_law_{name}_margins.py" for name in ("rest", "settling", "over_angle")),
        *COG_REST,
        *FLANKS,
    ),
    "general/laws/follow.py": LAWS,
    "general/laws/step.py": (f"{PROOF}test_law_over_angle_margins.py", f"{PROOF}test_law_step_margins.py"),
    "general/sets/known.py": (f"{PROOF}test_known_margins.py", *GENERAL_CAPTURE),
    "general/sets/memory.py": (f"{PROOF}test_memory_margins.py", *GENERAL_CAPTURE, f"{GENERAL_SETS}test_memory.py"),
    "general/sets/ball.py": GENERAL_CAPTURE,
    "general/sets/piece.py": GENERAL_CUTTING,
    "general/sets/parts.py": (f"{GENERAL_SETS}test_turns.py", *GENERAL_CUTTING),
    "general/sets/arc_parts.py": (f"{PROOF}test_general_arc_margins.py", f"{GENERAL_SETS}test_turns.py"),
    **{f"general/sets/{name}.py": (f"{GENERAL_SETS}test_turns.py",) for name in ("turns", "swings")},
    "general/sets/drift.py": (f"{PROOF}test_drift_margins.py",),
    "general/sets/lattice.py": (f"{PROOF}test_lagged_lattice_margins.py", *GENERAL_CUTTING),
    "general/sets/readings.py": (f"{GENERAL_SETS}test_readings.py",),
    "general/sets/box.py": (f"{PROOF}test_general_box_margins.py", f"{GENERAL_SETS}test_piece.py"),
    "general/sets/curve.py": (f"{PROOF}test_curve_margins.py",),
    "general/sets/arc.py": (f"{PROOF}test_general_arc_margins.py",),
    "general/sets/afar.py": (f"{GENERAL_SETS}test_afar.py", f"{GENERAL_SETS}test_afar_limits.py"),
    "general/sets/friction_step.py": (f"{PROOF}test_friction_step_margins.py",),
    **{f"general/sets/lagged_{end}.py": (f"{PROOF}test_lagged_step_margins.py",) for end in ("step", "stops")},
    "general/sets/friction_room.py": (
        *(f"{PROOF}test_{name}.py" for name in ("friction_room_margins", "lagged_room_margins", "friction_rounding")),
    ),
    "general/sets/friction_rest.py": (f"{PROOF}test_friction_rest_margins.py",),
    "general/sets/friction_piece.py": FRICTION_SETS,
    "general/sets/friction_set.py": FRICTION_SETS,
    "general/sets/friction_turns.py": (f"{GENERAL_SETS}test_friction_turns.py",),
    "general/sets/friction_box.py": (f"{PROOF}test_friction_box_margins.py",),
    **{
        f"general/sets/{name}.py": (f"{GENERAL_SETS}test_friction_arc.py",)
        for name in ("friction_arc", "friction_arcs")
    },
    **{f"general/sets/{name}.py": (f"{GENERAL_SETS}test_cog_arc.py",) for name in ("cog_arc", "cog_stop")},
    **{f"general/sets/cog_{name}.py": (f"{GENERAL_SETS}test_cog_piece.py",) for name in ("box", "fold", "piece")},
    "general/sets/friction_arc_counts.py": (f"{GENERAL_SETS}test_friction_arc_counts.py",),
    "general/sets/friction_phases.py": (
        f"{PROOF}test_friction_phase_margins.py",
        f"{PROOF}test_friction_interval_margins.py",
    ),
    **{f"general/sets/{name}.py": (f"{PROOF}test_set_room_margins.py",) for name in ("ends", "room", "scope")},
    "general/sets/convex.py": (f"{PROOF}test_convex_margins.py",),
    "general/sets/search.py": (f"{PROOF}test_general_search_margins.py",),
    "general/laws/sensed.py": (f"{PROOF}test_sensed_margins.py", f"{GENERAL}test_parting.py"),
    "controllers/estimated_velocity.py": ("tests/controllers/test_fading_pair.py",),
    "hardware/sample_clock.py": tuple(f"tests/hardware/test_sample_clock{end}.py" for end in ("", "_margins")),
    "hardware/replay.py": tuple(f"tests/hardware/test_replay{end}.py" for end in ("", "_margins")),
    "hardware/wire/sending.py": tuple(f"tests/hardware/test_block_order{end}.py" for end in ("", "_margins")),
    "hardware/trial_phases.py": ("tests/hardware/test_trial_phases.py",),
    "hardware/safety.py": tuple(
        f"tests/hardware/test_{name}.py" for name in ("safety", "safety_margins", "agreed_wall", "control")
    ),
}
# Which tests watch over a file that the table above does not have, by the first of these that its name begins with: all
# of them that run in this process and call what is changed. None are for compilers, caches and pages made from specs.
FOLDERS: dict[str, tuple[str, ...]] = {
    "engine/general/sets/": (GENERAL_SETS, PROOF),
    "engine/general/": (*(f"{GENERAL}test_{name}.py" for name in BODIES), PROOF),
    "engine/sets/": (SETS, PROOF),
    "engine/orbit_": (*ORBIT, "tests/measure/"),
    "engine/unsampled/": (
        *(f"tests/engine/test_{name}.py" for name in ("settling", "state_machine")),
        *(f"tests/measure/test_unsampled{end}.py" for end in ("", "_course")),
    ),
    "engine/pulse": ("tests/identify/",),
    "engine/": (*(f"tests/engine/test_{name}.py" for name in PLAIN), PROOF),
    "controllers/": ("tests/controllers/",),
    "measure/": (
        *("tests/measure/", *ORBIT, "tests/stages/sweep/test_run.py"),
        *(f"tests/verification/test_{name}.py" for name in OF_MEASURES),
    ),
    "specs/": (
        *(f"tests/specs/test_{name}.py" for name in SPEC_TESTS),
        *(f"tests/faults/test_{name}.py" for name in ("bad_specs", "bad_designs", "named_files", "untrusted_specs")),
        *(f"tests/scene/test_{name}.py" for name in ("sampled_cells", "plain_knob", "torque_over_angle")),
        *(f"tests/cli/test_{name}.py" for name in CLI_OF_SPECS),
        *("tests/recordings/test_foreign.py", "tests/test_stage_table.py"),
    ),
    "hardware/": (*(f"tests/hardware/test_{name}.py" for name in WIRED),),
}
# Folder groups, each by what its files' names begin with; a file is in the first that it fits.
GROUPS: dict[str, tuple[str, ...]] = {
    "proofs": (
        *(f"engine/{name}" for name in ("certificate", "rest", "follow", "sets/", "general/sets/", "general/laws/")),
        *(f"engine/general/{name}" for name in ("standstill", "inner", "powers", "period", "follow", "interval")),
    ),
    "measures": ("measure/", "engine/orbit_"),
    "engine": ("engine/", "controllers/"),
    "specs": ("specs/",),
    "hardware": ("hardware/",),
}
UNTRIED = tuple(f"engine/{name}" for name in ("absent", "compiling", "jit", "kept_code", "linking", "alarm"))
# Of these files, what would take longer than all others together.
LEFT_OUT = (
    f"{GENERAL}test_inner_region.py::test_the_share_at_rest_never_falls_with_the_limit",
    *(
        f"tests/specs/test_capabilities{name}"  # each compiles a part of the engine
        for name in (
            "_sets.py::test_every_start_of_a_controller_beside_more",
            "_sets.py::test_every_phase_beside_friction_and_more",
            "_sets.py::test_sets_of_starts_are_proven_where_the_table_says",
            ".py::test_pairs_are_as_the_table_says",
            ".py::test_trials_are_proven_where_the_table_says",
            ".py::test_a_controller_goes_with_what_the_table_says",
            "_bare.py::test_a_controller_reads_a_continuous_sensor",
        )
    ),
)


def path_of(name: str) -> Path:
    """File of a name in the table: of the engine, or of a folder beside it that the name begins with."""
    return (PACKAGE if (PACKAGE / name).exists() else ENGINE) / name


def name_of(path: Path) -> str:
    """Its name in the table."""
    return path.relative_to(ENGINE if path.is_relative_to(ENGINE) else PACKAGE).as_posix()


def watchers_of(path: Path) -> list[Path]:
    """Files or folders of tests that watch over a file."""
    listed = WATCHED.get(name_of(path))
    if listed is None:
        name = path.relative_to(PACKAGE).as_posix()
        listed = next(tests for begin, tests in FOLDERS.items() if name.startswith(begin))
    return [ROOT / name for name in listed]


def files_of(group: str) -> list[Path]:
    """Files of a folder group, in order."""
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).as_posix()
        first = next((one for one, begins in GROUPS.items() if name.startswith(begins)), None)
        if first == group and not name.startswith(UNTRIED):
            found.append(path)
    return found
