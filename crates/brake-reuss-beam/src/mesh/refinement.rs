//! How finely the beam is meshed.
use crate::{Error, Result};

/// Element counts of the block mesh. The default gives the interface of 588 quadrilaterals and 692 nodes.
///
/// Each hole sits in a block as long as half the hole pitch (15 mm), filled with an O-grid; its ring of
/// [`Refinement::hole_ring`] elements matches the block's perimeter, so that no count can disagree with another.
///
/// [`Refinement::default`], [`Refinement::fine`] and [`Refinement::finest`] are a family: all counts grow by about the root of two
/// from one to the next, so that an order of convergence can be read off. Counts of one can only double; they do so in `fine`.
/// [`Refinement::coarse`] and [`Refinement::quick`] are too coarse to follow in every count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refinement {
    /// Elements across the beam; even, so that nodes lie on the symmetry plane `y = 0`.
    pub across: usize,
    /// Elements along each half pitch: the hole's block and the block between two holes.
    pub per_block: usize,
    /// Rings of elements round each hole.
    pub hole_rings: usize,
    /// Elements along each end of the lap, from the last hole's block to the lap's edge.
    pub end: usize,
    /// Layers of elements in each half of the lap's height.
    pub layers: usize,
    /// Layers of elements along each arm. They start with the element length at the lap's end and grow by a constant
    /// ratio that fills the arm exactly.
    pub arm_layers: usize,
    /// Sectors of bolts, washers and nuts; a multiple of 12, so that hexagons and square cores meet nodes.
    pub sectors: usize,
    /// Rings between the shank's square core and its surface.
    pub shank_rings: usize,
    /// Rings between the washer's bore and the hexagon.
    pub seat_rings: usize,
    /// Rings between the hexagon and the washer's rim.
    pub rim_rings: usize,
    /// Layers of a washer.
    pub washer_layers: usize,
    /// Layers of a bolt's head and of a nut.
    pub head_layers: usize,
    /// Layers of the shank between head and nut.
    pub grip_layers: usize,
    /// Layers of the shank's end beyond the nut.
    pub tip_layers: usize,
}

impl Default for Refinement {
    fn default() -> Self {
        Self {
            across: 10,
            per_block: 6,
            hole_rings: 3,
            end: 9,
            layers: 5,
            arm_layers: 50,
            sectors: 24,
            shank_rings: 1,
            seat_rings: 2,
            rim_rings: 1,
            washer_layers: 1,
            head_layers: 3,
            grip_layers: 8,
            tip_layers: 2,
        }
    }
}

impl Refinement {
    /// Very coarse: 148 interface elements and a few thousand nodes, for quick checks.
    pub fn quick() -> Self {
        Self {
            across: 4,
            per_block: 3,
            hole_rings: 2,
            end: 5,
            layers: 3,
            arm_layers: 20,
            sectors: 12,
            shank_rings: 1,
            seat_rings: 1,
            rim_rings: 1,
            washer_layers: 1,
            head_layers: 2,
            grip_layers: 4,
            tip_layers: 1,
        }
    }

    /// Coarse: 300 interface elements.
    pub fn coarse() -> Self {
        Self {
            across: 6,
            per_block: 4,
            end: 6,
            layers: 4,
            arm_layers: 30,
            seat_rings: 1,
            head_layers: 2,
            grip_layers: 6,
            ..Self::default()
        }
    }

    /// Fine: the default with about 1.4 times the count in every direction, 1196 interface elements.
    pub fn fine() -> Self {
        Self {
            across: 14,
            per_block: 9,
            hole_rings: 4,
            end: 14,
            layers: 7,
            arm_layers: 70,
            sectors: 36,
            shank_rings: 2,
            seat_rings: 3,
            rim_rings: 2,
            washer_layers: 2,
            head_layers: 4,
            grip_layers: 12,
            tip_layers: 3,
        }
    }

    /// Finest: the default with twice the count in every direction, 2352 interface elements.
    pub fn finest() -> Self {
        Self {
            across: 20,
            per_block: 12,
            hole_rings: 6,
            end: 18,
            layers: 10,
            arm_layers: 100,
            sectors: 48,
            shank_rings: 2,
            seat_rings: 4,
            rim_rings: 2,
            washer_layers: 2,
            head_layers: 6,
            grip_layers: 16,
            tip_layers: 4,
        }
    }

    /// The smallest counts of which `scaled(2.0)`, `scaled(3.0)` and so on are a family without any rounding, to find the limit of the
    /// mesh with. Its own mesh is too coarse for results.
    pub fn unit() -> Self {
        Self {
            across: 4,
            per_block: 3,
            hole_rings: 1,
            end: 4,
            layers: 2,
            arm_layers: 16,
            sectors: 12,
            shank_rings: 1,
            seat_rings: 1,
            rim_rings: 1,
            washer_layers: 1,
            head_layers: 1,
            grip_layers: 4,
            tip_layers: 1,
        }
    }

    /// The presets from the coarsest to the finest, with their names.
    pub fn presets() -> [(&'static str, Self); 5] {
        [
            ("quick", Self::quick()),
            ("coarse", Self::coarse()),
            ("default", Self::default()),
            ("fine", Self::fine()),
            ("finest", Self::finest()),
        ]
    }

    /// All counts multiplied by `factor` and rounded: `across` to an even number, `sectors` to a multiple of 12.
    ///
    /// # Errors
    /// [`Error::Value`] if the factor is not finite and positive, [`Error::Count`] if a scaled count is too large.
    pub fn scaled(&self, factor: f64) -> Result<Self> {
        crate::geometry::positive("refinement", "factor", factor, "")?;
        let to_multiple = |count: usize, step: usize| {
            let steps = (count as f64 * factor / step as f64).round();
            // The cast saturates; validation below refuses what is too large.
            (steps as usize).max(1).saturating_mul(step)
        };
        let scaled = |count| to_multiple(count, 1);
        let refinement = Self {
            across: to_multiple(self.across, 2),
            per_block: scaled(self.per_block),
            hole_rings: scaled(self.hole_rings),
            end: scaled(self.end),
            layers: scaled(self.layers),
            arm_layers: scaled(self.arm_layers),
            sectors: to_multiple(self.sectors, 12),
            shank_rings: scaled(self.shank_rings),
            seat_rings: scaled(self.seat_rings),
            rim_rings: scaled(self.rim_rings),
            washer_layers: scaled(self.washer_layers),
            head_layers: scaled(self.head_layers),
            grip_layers: scaled(self.grip_layers),
            tip_layers: scaled(self.tip_layers),
        };
        refinement.validate()?;
        Ok(refinement)
    }

    /// All counts with their names.
    pub fn counts(&self) -> [(&'static str, usize); 14] {
        [
            ("across", self.across),
            ("per_block", self.per_block),
            ("hole_rings", self.hole_rings),
            ("end", self.end),
            ("layers", self.layers),
            ("arm_layers", self.arm_layers),
            ("sectors", self.sectors),
            ("shank_rings", self.shank_rings),
            ("seat_rings", self.seat_rings),
            ("rim_rings", self.rim_rings),
            ("washer_layers", self.washer_layers),
            ("head_layers", self.head_layers),
            ("grip_layers", self.grip_layers),
            ("tip_layers", self.tip_layers),
        ]
    }

    /// Elements in each ring round a hole: the perimeter of its block.
    pub fn hole_ring(&self) -> usize {
        2 * (self.across + self.per_block)
    }

    /// Number of interface elements.
    pub fn interface_elements(&self) -> usize {
        3 * self.hole_rings * self.hole_ring() + 2 * self.across * (self.per_block + self.end)
    }

    /// Checks that every count lies between 1 and 256, that `across` is even and `sectors` a multiple of 12.
    ///
    /// # Errors
    /// [`Error::Count`], naming the count.
    pub fn validate(&self) -> Result<()> {
        for (field, value) in self.counts() {
            require_count(field, value)?;
        }
        if !self.across.is_multiple_of(2) {
            return Err(Error::Count {
                field: "across",
                value: self.across,
                requirement: "even",
            });
        }
        if !self.sectors.is_multiple_of(12) {
            return Err(Error::Count {
                field: "sectors",
                value: self.sectors,
                requirement: "a multiple of 12",
            });
        }
        Ok(())
    }
}

/// Node numbers are 32 bits wide; this bound keeps every mesh far inside of them.
pub(crate) fn require_count(field: &'static str, value: usize) -> Result<()> {
    if (1..=256).contains(&value) {
        Ok(())
    } else {
        Err(Error::Count {
            field,
            value,
            requirement: "from 1 to 256",
        })
    }
}
