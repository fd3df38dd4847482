"""Integrals of the motion over one period: of the position, its square, the square of the velocity, and work.

Over a hold all are linear and quadratic in what it begins with, the position, the velocity and the drive. So those are
added up over the holds of a kind, and their products, and the forms of the kind are taken of the sums, once.
"""

from hknob_cli.engine.orbit.holds import MEAN, PART, SPEED, SQUARE, G, S


def add_up(holds, kind, count, kinds, reference, mean):
    """Sums over the holds of one ``kind`` of a, b, d, a², ab, ad, b², bd and d².

    a: position less ``reference``; b: velocity; d: drive less its ``mean``. Without those the sums would lose digits
    where the knob is pushed deep.
    """
    x, v, drive = holds
    a, b, d = 0.0, 0.0, 0.0
    aa, ab, ad, bb, bd, dd = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(kind, count, kinds):
        place, speed, force = x[i] - reference, v[i], drive[i] - mean
        a, b, d = a + place, b + speed, d + force
        aa, ab, ad = aa + place * place, ab + place * speed, ad + place * force
        bb, bd, dd = bb + speed * speed, bd + speed * force, dd + force * force
    return a, b, d, aa, ab, ad, bb, bd, dd


def form_of(parts, at, products):
    """Value of the symmetric form that begins at ``at``, of sums of products."""
    aa, ab, ac, bb, bc, cc = products
    return (
        parts[at] * aa
        + 2.0 * (parts[at + 1] * ab + parts[at + 2] * ac)
        + (parts[at + 3] * bb + 2.0 * parts[at + 4] * bc)
        + parts[at + 5] * cc
    )


def find_integrals(holds, count, parts, kinds, beta, reference, mean):
    """Integrals over ``count`` holds: of x less ``reference`` (a position near the motion), of its square, of v², work.

    The work is that of the wall torque, in units of J (counts per sample)²: torque times distance. On a limit cycle it
    is what the damping takes out (bias and hand stiffness return what they take), alpha times the integral of v²; that
    one is of v alone, so that their difference checks the orbit and its integrals. The ``mean`` drive does no work.
    """
    total, square, speed, work = 0.0, 0.0, 0.0, 0.0
    spare = mean - beta * reference
    for kind in range(kinds):
        base = kind * PART
        a, b, d, aa, ab, ad, bb, bd, dd = add_up(holds, kind, count, kinds, reference, mean)
        c = d + (count // kinds) * spare  # the drive less what holds the knob at the reference
        products = (aa, ab, ad + spare * a, bb, bd + spare * b, dd + spare * (d + c))
        total += parts[base + MEAN] * a + parts[base + MEAN + 1] * b + parts[base + MEAN + 2] * c
        square += form_of(parts, base + SQUARE, products)
        speed += form_of(parts, base + SPEED, products)
        work += parts[base + S] * bd + parts[base + G] * ((dd + spare * d) - beta * ad)
    return total, square, speed, work
