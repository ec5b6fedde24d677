"""Mesh of two C-shaped beams that are bolted at both ends: s4.msh, in mm.

The upper beam lies on z > 0, the lower one on z < 0; x is along both, from the middle. They touch at their feet alone.
"""

import gmsh

from blocks import QUARTER, Body, divisions, options, write

LENGTH = 508.0  # of a beam
WIDTH = 31.75
THICKNESS = 9.525  # of the beam between its feet
FOOT = 50.8  # length of a foot
HEIGHT = 6.35  # of a foot above the beam
HOLE = 9.0  # M8, medium series of ISO 273
SEAT = 16.0  # washer of ISO 7089 for M8


def beam(name, given, is_upper):
    """A beam with its surfaces in contact by foot, and those below heads or nuts by bolt."""
    sign = 1.0 if is_upper else -1.0
    # Drawn where feet and beam meet.
    body = Body(name, given, sign * HEIGHT, is_upper)
    y = WIDTH / 2
    along, across = (max(QUARTER, divisions(length, body.size)) for length in (FOOT, WIDTH))
    rings, feet = [], []
    for low in (-LENGTH / 2, LENGTH / 2 - FOOT):
        high = low + FOOT
        corners = [(low, -y), (high, -y), (high, y), (low, y)]
        inner, outer = body.bolt_hole((low + FOOT / 2, 0.0), HOLE, SEAT, corners, [along, across])
        rings.append(inner)
        feet.append(inner + outer)
    half = LENGTH / 2 - FOOT
    corners = [(-half, -y), (half, -y), (half, y), (-half, y)]
    rest = body.block(corners, [divisions(2 * half, body.size), across])
    both = feet[0] + feet[1]
    far = dict(zip(both, body.extrude(both + [rest], sign * THICKNESS)))
    contact = dict(zip(both, body.extrude(both, -sign * HEIGHT)))
    on = lambda side, parts: [[side[surface] for surface in part] for part in parts]
    return body, on(contact, feet), on(far, rings)


def main():
    given = options(__doc__.splitlines()[0], "s4.msh", bolts=None, size=8.0)
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    upper, of_upper, heads = beam("upper", given, True)
    lower, of_lower, nuts = beam("lower", given, False)
    groups = {}
    for i in range(2):
        groups[f"upper contact {i + 1}"], groups[f"lower contact {i + 1}"] = of_upper[i], of_lower[i]
        groups[f"head {i + 1}"], groups[f"nut {i + 1}"] = heads[i], nuts[i]
    write(given, [upper, lower], groups)
    gmsh.finalize()


if __name__ == "__main__":
    main()
