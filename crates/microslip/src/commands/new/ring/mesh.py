"""Mesh of two tubes with flanges that are bolted together: ring.msh, in mm.

The tubes' axis is z, and the flanges meet at z = 0. The first bolt lies on the x axis.
"""

import math

from blocks import QUARTER, Body, divisions, make, options

BORE = 30.0  # radius
TUBE = 36.0  # outer radius of the tube
FLANGE = 60.0  # outer radius of the flange
THICKNESS = 10.0  # of the flange
LENGTH = 200.0  # of a tube with its flange
CIRCLE = 48.0  # radius on which the bolts lie
HOLE = 9.0  # M8, medium series of ISO 273
SEAT = 16.0  # washer of ISO 7089 for M8
PIECE = math.radians(15.0)  # a hole lies in a piece of the flange that reaches so far to both sides


def flange(name, given, is_upper):
    """A tube with its flange, with its surfaces in contact, and those below heads or nuts by bolt."""
    body = Body(name, given, 0.0, is_upper)
    middle = (0.0, 0.0)
    at = lambda r, a: (r * math.cos(a), r * math.sin(a))
    radial = max(QUARTER, divisions(FLANGE - TUBE, body.size))
    wall = divisions(TUBE - BORE, body.size)
    pitch = 2 * math.pi / given.bolts
    rings, tube, rest = [], [], []
    for i in range(given.bolts):
        angle = i * pitch
        # The piece with the hole, then the one up to the next.
        for low, high, has_hole in [(angle - PIECE, angle + PIECE, True), (angle + PIECE, angle + pitch - PIECE, False)]:
            around = max(QUARTER, divisions(CIRCLE * (high - low), body.size))
            arcs = [None, middle, None, middle]
            of_piece = lambda inner, outer: [at(inner, low), at(outer, low), at(outer, high), at(inner, high)]
            tube.append(body.block(of_piece(BORE, TUBE), [wall, around], arcs))
            if has_hole:
                inner, outer = body.bolt_hole(at(CIRCLE, angle), HOLE, SEAT, of_piece(TUBE, FLANGE), [radial, around], arcs)
                rings.append(inner)
                rest += inner + outer
            else:
                rest.append(body.block(of_piece(TUBE, FLANGE), [radial, around], arcs))
    contact = tube + rest
    sign = 1.0 if is_upper else -1.0
    far = dict(zip(contact, body.extrude(contact, sign * THICKNESS)))
    body.extrude([far[surface] for surface in tube], sign * (LENGTH - THICKNESS))
    return body, contact, [[far[surface] for surface in ring] for ring in rings]


def main():
    given = options(__doc__.splitlines()[0], "ring.msh", bolts=(4, 2, 8), size=8.0)
    make(given, lambda: flange("upper", given, True), lambda: flange("lower", given, False))


if __name__ == "__main__":
    main()
