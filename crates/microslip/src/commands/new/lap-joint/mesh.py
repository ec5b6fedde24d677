"""Mesh of two plates that overlap and are bolted in a row: lap.msh, in mm.

The upper plate lies on z > 0, the lower one on z < 0; x is along both. The bolts' axes are parallel to z.
"""

from blocks import QUARTER, Body, divisions, make, options

LENGTH = 200.0  # of a plate
WIDTH = 40.0
THICKNESS = 8.0
PITCH = 40.0  # between bolts; the overlap is one pitch per bolt
HOLE = 9.0  # M8, medium series of ISO 273
SEAT = 16.0  # washer of ISO 7089 for M8


def plate(name, given, free):
    """A plate with its surfaces in contact, and those below heads or nuts by bolt. `free` is the range of x beyond the overlap."""
    is_upper = free[0] > 0.0
    body = Body(name, given, 0.0, is_upper)
    y = WIDTH / 2
    along, across = (max(QUARTER, divisions(length, body.size)) for length in (PITCH, WIDTH))
    rings, contact = [], []
    for i in range(given.bolts):
        x = [i * PITCH, (i + 1) * PITCH]
        corners = [(x[0], -y), (x[1], -y), (x[1], y), (x[0], y)]
        inner, outer = body.bolt_hole((sum(x) / 2, 0.0), HOLE, SEAT, corners, [along, across])
        rings.append(inner)
        contact += inner + outer
    corners = [(free[0], -y), (free[1], -y), (free[1], y), (free[0], y)]
    rest = body.block(corners, [divisions(free[1] - free[0], body.size), across])
    far = dict(zip(contact, body.extrude(contact + [rest], THICKNESS if is_upper else -THICKNESS)))
    return body, contact, [[far[surface] for surface in ring] for ring in rings]


def main():
    given = options(__doc__.splitlines()[0], "lap.msh", bolts=(2, 1, 4), size=8.0)
    overlap = given.bolts * PITCH
    make(given, lambda: plate("upper", given, (overlap, LENGTH)), lambda: plate("lower", given, (overlap - LENGTH, 0.0)))


if __name__ == "__main__":
    main()
