"""Where a bounded lag damps, and how large a part of a step it should keep: by its describing function.

Within one count the law is the lag K (keep tau s + 1)/(tau s + 1). At the frequency w of the buzz it acts as a spring
K (1 + keep tau^2 w^2)/(1 + tau^2 w^2) and as a damper -(1 - keep) K tau/(1 + tau^2 w^2), which is below 0: the lag
drives, and works only while w tau is large. The quantizer turns K into a gain G that falls with the amplitude. With
G keep well above the hand's stiffness and w tau well above 1, w^2 = G keep/J, and the buzz is where the loss of the
sample's delay and of the lag is the damping b:

    G keep T/2 + (1 - keep) J/(keep tau) = b.

So G = (2 b/(keep T)) (1 - r (1 - keep)/keep) with r = J/(b tau); the plain wall's (keep = 1) is 2 b/T, and the
amplitude goes as 1/G. The buzz is smaller than the plain wall's for r < keep < 1, smallest at keep = 2 r/(1 + r), where
it is (1 + r)^2/(4 r) times smaller. Below keep = r/(1 + r) the lag drives a slow oscillation of its own; from r = 1 on
no lag makes the buzz smaller. Sample delay, friction and the hand's stiffness are left out: the last helps.
"""


def slowness(*, inertia_kg_m2: float, damping_nm_s_per_rad: float, time_constant_s: float) -> float:
    """Time J/b in which knob and hand lose their speed, over that of the lag; infinite without damping."""
    loss = damping_nm_s_per_rad * time_constant_s
    return inertia_kg_m2 / loss if loss > 0.0 else float("inf")


def best_keep(r: float) -> float:
    """Part of a step that leaves the smallest buzz; 1, the plain wall, where none makes it smaller."""
    return 2.0 * r / (1.0 + r) if r < 1.0 else 1.0
