"""Mesh of the Brake-Reuss beam of half the thickness: beam.msh, in mm.

Two halves of 420 mm overlap by 120 mm, where each is half as thick. The upper one has its arm on x < 0; they touch on z = 0, and the bolts'
axes are parallel to z.
"""

from blocks import QUARTER, Body, divisions, make, options

LENGTH = 720.0  # of the whole
WIDTH = 25.4
THICKNESS = 12.7  # of an arm; half of it in the lap
LAP = 120.0
PITCH = 30.0  # between bolts; the middle one is at x = 0
HOLE = 8.4
SEAT = 16.0  # washer of ISO 7089 for M8, which stands for 5/16-18 UNC


def half(name, given, is_upper):
    """A half with its surfaces in contact, and those below heads or nuts by bolt."""
    sign = 1.0 if is_upper else -1.0
    body = Body(name, given, 0.0, is_upper)
    y = WIDTH / 2
    along, across = (max(QUARTER, divisions(length, body.size)) for length in (PITCH, WIDTH))
    rings, lap = [], []
    for i in (-1, 0, 1):
        x = [(i - 0.5) * PITCH, (i + 0.5) * PITCH]
        corners = [(x[0], -y), (x[1], -y), (x[1], y), (x[0], y)]
        inner, outer = body.bolt_hole((i * PITCH, 0.0), HOLE, SEAT, corners, [along, across])
        rings.append(inner)
        lap += inner + outer
    plain = lambda a, b: body.block([(a, -y), (b, -y), (b, y), (a, y)], [divisions(b - a, body.size), across])
    lap += [plain(-LAP / 2, -1.5 * PITCH), plain(1.5 * PITCH, LAP / 2)]
    arm = plain(-LENGTH / 2, -LAP / 2) if is_upper else plain(LAP / 2, LENGTH / 2)
    far = dict(zip(lap, body.extrude(lap + [arm], sign * THICKNESS / 2)))
    body.extrude([arm], -sign * THICKNESS / 2)
    return body, lap, [[far[surface] for surface in ring] for ring in rings]


def main():
    given = options(__doc__.splitlines()[0], "beam.msh", bolts=None, size=5.0)
    make(given, lambda: half("upper", given, True), lambda: half("lower", given, False))


if __name__ == "__main__":
    main()
