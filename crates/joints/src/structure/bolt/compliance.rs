//! Compliance of a bolt between its seats (VDI 2230-1:2015, sections 5.1.1.1 and 5.1.1.2).

use scenes::metric::Thread;
use std::f64::consts::PI;

/// What a bolt's thread engages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engagement {
    /// A nut of this Young's modulus (Pa).
    Nut(f64),
    /// A tapped hole in a part of this Young's modulus (Pa).
    TappedHole(f64),
}

/// One part of a bolt that gives way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Which part.
    pub part: &'static str,
    /// Length that takes part (m).
    pub length: f64,
    /// Diameter of its section (m).
    pub diameter: f64,
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
}

impl Term {
    /// `l / (E A)` (m/N).
    pub fn axial(&self) -> f64 {
        self.length / (self.youngs_modulus * PI / 4.0 * self.diameter.powi(2))
    }

    /// `l / (E I)` (rad/(N m)).
    pub fn bending(&self) -> f64 {
        self.length / (self.youngs_modulus * PI / 64.0 * self.diameter.powi(4))
    }
}

/// The compliance of a bolt, part by part from head to nut.
///
/// | part | length | section |
/// |---|---|---|
/// | head | `0.5 d` (hexagon) | nominal |
/// | shank | without thread | nominal |
/// | free thread | the rest of the grip | core |
/// | engaged thread | `0.5 d` | core |
/// | nut, or tapped hole | `0.4 d`, or `0.33 d` | nominal, with its own modulus |
#[derive(Clone, Debug, PartialEq)]
pub struct Compliance {
    /// The parts.
    pub terms: Vec<Term>,
}

impl Compliance {
    /// Of a hexagon bolt of modulus `youngs_modulus` (Pa) whose seats are `grip` apart (m), washers included; the first
    /// `unthreaded` of it has no thread (m).
    pub fn new(thread: &Thread, grip: f64, unthreaded: f64, youngs_modulus: f64, engagement: Engagement) -> Self {
        let (nominal, core) = (thread.diameter, thread.core_diameter());
        let term = |part, length, diameter, youngs_modulus| Term {
            part,
            length,
            diameter,
            youngs_modulus,
        };
        let own = youngs_modulus;
        let mut terms = vec![
            term("head", 0.5 * nominal, nominal, own),
            term("shank", unthreaded, nominal, own),
            term("free thread", grip - unthreaded, core, own),
            term("engaged thread", 0.5 * nominal, core, own),
            match engagement {
                Engagement::Nut(modulus) => term("nut", 0.4 * nominal, nominal, modulus),
                Engagement::TappedHole(modulus) => term("tapped hole", 0.33 * nominal, nominal, modulus),
            },
        ];
        terms.retain(|term| term.length > 0.0);
        Self { terms }
    }

    /// Elongation per tension (m/N): `delta_S`.
    pub fn axial(&self) -> f64 {
        self.terms.iter().map(Term::axial).sum()
    }

    /// Rotation of the ends against one another per bending moment (rad/(N m)): `beta_S`.
    pub fn bending(&self) -> f64 {
        self.terms.iter().map(Term::bending).sum()
    }
}
