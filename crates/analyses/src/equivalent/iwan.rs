//! The four-parameter Iwan element: Segalman, "A four-parameter Iwan model for lap-type joints", Journal of Applied Mechanics 72 (2005) 752-760,
//! DOI 10.1115/1.1989354.

use super::fit::{Columns, Family, Stiffnesses};
use serde::{Deserialize, Serialize};

/// Sliders in parallel, each with a spring of unit stiffness: `rho(phi) = R phi^chi` of them slip at the displacement `phi` up to `phi_max`, and a
/// lump at `phi_max` itself, so that `beta` is the stiffness of the lump over that of the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Iwan {
    /// `F_S`: force at which all slips.
    pub slip_force: f64,
    /// `K_T`: stiffness without slip.
    pub stiffness: f64,
    /// `chi`, above -1: at small amplitudes dissipation grows with the power `chi + 3`.
    pub chi: f64,
    /// `beta`.
    pub beta: f64,
    /// Stiffness of a linear spring in parallel, which Segalman leaves to the structure: what does not slip at all, bodies and bolts.
    pub spring: f64,
}

impl Iwan {
    /// `phi_max`: displacement from which all slips (eq. 27 of Segalman).
    pub fn largest_displacement(&self) -> f64 {
        self.slip_force * (1.0 + self.beta) / (self.stiffness * (self.beta + (self.chi + 1.0) / (self.chi + 2.0)))
    }
}

impl Family for Iwan {
    const CHOICES: &'static [[bool; 3]] = &[
        [true, false, false],
        [true, true, false],
        [true, false, true],
        [true, true, true],
    ];

    /// A power law and a lump of sliders are written with their stiffnesses `k` and `k beta`, beside the spring. Below `phi_max`, with `x = u/phi_max`,
    /// `K = k (1 - x^(chi+1)/(chi+2)) + k beta` and `D = 4 k (chi+1) x^(chi+1) u^2 / ((chi+2)(chi+3))`; above it `K = F_S/u` and
    /// `D = 4 (F_S u - integral of phi^2 rho)`.
    fn columns(u: f64, [largest, power]: [f64; 2]) -> Columns {
        // chi + 1, which is positive.
        let (x, p) = (u / largest, power);
        if x < 1.0 {
            let slipping = x.powf(p);
            Columns {
                stiffness: [1.0 - slipping / (p + 1.0), 1.0, 1.0],
                dissipation: [4.0 * p * slipping * u * u / ((p + 1.0) * (p + 2.0)), 0.0, 0.0],
            }
        } else {
            let forces = [largest * p / (p + 1.0), largest];
            let squares = [largest.powi(2) * p / (p + 2.0), largest.powi(2)];
            let lost = |i: usize| 4.0 * (forces[i] * u - squares[i]);
            Columns {
                stiffness: [forces[0] / u, forces[1] / u, 1.0],
                dissipation: [lost(0), lost(1), 0.0],
            }
        }
    }

    fn of([largest, power]: [f64; 2], [spread, lump, spring]: Stiffnesses) -> Self {
        Self {
            slip_force: largest * (spread * power / (power + 1.0) + lump),
            stiffness: spread + lump,
            chi: power - 1.0,
            beta: lump / spread,
            spring,
        }
    }

    fn apart(&self) -> ([f64; 2], Stiffnesses) {
        let spread = self.stiffness / (1.0 + self.beta);
        (
            [self.largest_displacement(), self.chi + 1.0],
            [spread, self.beta * spread, self.spring],
        )
    }
}
