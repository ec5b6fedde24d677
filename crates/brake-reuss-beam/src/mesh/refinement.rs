//! How finely the beam is meshed.
use crate::{Error, Result};
use joint_model::benchmark::{ElementOrder, RefinementLevel};

/// Element counts of the block mesh. The default gives the interface of 588 quadrilaterals and 692 nodes.
///
/// Each hole sits in a block as long as half the hole pitch (15 mm), filled with an O-grid; its ring of
/// [`Refinement::hole_ring`] elements matches the block's perimeter, so that no count can disagree with another.
///
/// [`Refinement::default`], [`Refinement::fine`] and [`Refinement::finest`] are a family: all counts grow by about the root of two
/// from one to the next, so that an order of convergence can be read off. Counts of one can only double; they do so in `fine`.
/// [`Refinement::coarse`] and [`Refinement::quick`] are too coarse to follow in every count.
///
/// Those are for linear elements, and equally spaced. The error of quadratic elements sits at the singular edges instead, so that
/// [`Refinement::level`] has graded meshes for them.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// How the lap's mesh meets the washers.
    pub washers: Washers,
    /// Elements across the beam; even, so that nodes lie on the symmetry plane `y = 0`.
    pub across: usize,
    /// Elements along each block of the lap: half a pitch, of which one has the hole and the next one is between two holes, or a
    /// whole pitch where the lap [follows](Washers::Followed) the washers.
    pub per_block: usize,
    /// Rings of elements round each hole, or round each washer where the lap follows the washers.
    pub hole_rings: usize,
    /// Elements along each end of the lap, from the last hole's block to the lap's edge.
    pub end: usize,
    /// Length of each of these elements over that of its neighbour towards the lap's edge.
    pub end_growth: f64,
    /// Layers of elements in each half of the lap's height.
    pub layers: usize,
    /// Height of each of these layers over that of its neighbour towards the interface.
    pub layer_growth: f64,
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

/// How the lap's mesh meets the washers that are tied to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Washers {
    /// The lap's mesh knows nothing of them; their nodes are anywhere on its faces.
    Independent,
    /// The lap has the washers' rings of nodes, all but the one on the bore. There are as many elements round a hole as sectors.
    Followed,
}

/// Neighbouring elements of a graded line differ by this factor at most.
const GREATEST_GROWTH: f64 = 4.0;

impl Default for Refinement {
    fn default() -> Self {
        Self {
            washers: Washers::Independent,
            across: 10,
            per_block: 6,
            hole_rings: 3,
            end: 9,
            end_growth: 1.0,
            layers: 5,
            layer_growth: 1.0,
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
            ..Self::default()
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
            ..Self::default()
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
            ..Self::default()
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
            ..Self::default()
        }
    }

    /// The smallest counts of a family of meshes for quadratic elements, graded towards the lap's ends and the interface, where the
    /// stress is singular. `graded_unit().scaled(k)` divides every element of it into `k` parts in each direction, by the same
    /// smooth grading.
    pub fn graded_unit() -> Self {
        Self {
            washers: Washers::Followed,
            across: 4,
            per_block: 2,
            hole_rings: 1,
            end: 3,
            end_growth: 4.0,
            layers: 2,
            layer_growth: 3.0,
            arm_layers: 16,
            sectors: 12,
            shank_rings: 1,
            seat_rings: 1,
            rim_rings: 1,
            washer_layers: 1,
            head_layers: 1,
            grip_layers: 2,
            tip_layers: 1,
        }
    }

    /// Meshes for quadratic elements by level; graded towards the lap's ends and the interface, with rings of nodes under the washers'.
    /// Counts were chosen by their effect on the first frequency.
    fn graded(level: RefinementLevel) -> Self {
        let default = Self {
            hole_rings: 3,
            end: 7,
            end_growth: 2.1,
            layers: 3,
            layer_growth: 2.0,
            arm_layers: 24,
            seat_rings: 2,
            ..Self::graded_unit()
        };
        match level {
            RefinementLevel::Quick => Self::graded_unit(),
            RefinementLevel::Coarse => Self {
                hole_rings: 2,
                end: 5,
                end_growth: 2.5,
                layers: 3,
                layer_growth: 2.0,
                arm_layers: 18,
                ..Self::graded_unit()
            },
            RefinementLevel::Default => default,
            RefinementLevel::Fine => Self {
                across: 6,
                per_block: 6,
                sectors: 24,
                hole_rings: 4,
                end: 9,
                end_growth: 1.7,
                layers: 6,
                layer_growth: 1.45,
                arm_layers: 33,
                seat_rings: 3,
                rim_rings: 3,
                washer_layers: 3,
                head_layers: 3,
                grip_layers: 3,
                ..default
            },
            RefinementLevel::Finest => Self {
                across: 8,
                per_block: 4,
                sectors: 24,
                hole_rings: 6,
                end: 12,
                end_growth: 1.48,
                layers: 8,
                layer_growth: 1.32,
                arm_layers: 44,
                shank_rings: 2,
                seat_rings: 4,
                rim_rings: 4,
                washer_layers: 4,
                head_layers: 4,
                grip_layers: 4,
                tip_layers: 2,
                ..default
            },
        }
    }

    /// The mesh of a level for elements of an order: [`Refinement::quick`] to [`Refinement::finest`] for linear elements, graded
    /// ones for quadratic elements.
    pub fn level(level: RefinementLevel, order: ElementOrder) -> Self {
        if order == ElementOrder::Quadratic {
            return Self::graded(level);
        }
        match level {
            RefinementLevel::Quick => Self::quick(),
            RefinementLevel::Coarse => Self::coarse(),
            RefinementLevel::Default => Self::default(),
            RefinementLevel::Fine => Self::fine(),
            RefinementLevel::Finest => Self::finest(),
        }
    }

    /// The presets for elements of an order from the coarsest to the finest, with their names.
    pub fn presets(order: ElementOrder) -> [(&'static str, Self); 5] {
        [
            ("quick", RefinementLevel::Quick),
            ("coarse", RefinementLevel::Coarse),
            ("default", RefinementLevel::Default),
            ("fine", RefinementLevel::Fine),
            ("finest", RefinementLevel::Finest),
        ]
        .map(|(name, level)| (name, Self::level(level, order)))
    }

    /// All counts multiplied by `factor` and rounded: `across` to an even number, `sectors` to a multiple of 12. Growths become
    /// their `factor`-th roots.
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
            washers: self.washers,
            end_growth: self.end_growth.powf(factor.recip()),
            layer_growth: self.layer_growth.powf(factor.recip()),
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
        let (rings, columns) = match self.washers {
            Washers::Independent => (self.hole_rings, self.per_block + self.end),
            Washers::Followed => (self.seat_rings + self.rim_rings + self.hole_rings, self.end),
        };
        3 * rings * self.hole_ring() + 2 * self.across * columns
    }

    /// Checks that every count lies between 1 and 256, that `across` is even, `sectors` a multiple of 12 and, where the lap follows
    /// the washers, the number of elements round a hole; and that growths lie between 1 and 4.
    ///
    /// # Errors
    /// [`Error::Count`], naming the count; [`Error::Value`], naming the growth.
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
        if self.washers == Washers::Followed && self.hole_ring() != self.sectors {
            return Err(Error::Count {
                field: "sectors",
                value: self.sectors,
                requirement: "2 (across + per_block) where the lap follows the washers",
            });
        }
        for (field, value) in [("end_growth", self.end_growth), ("layer_growth", self.layer_growth)] {
            if !(1.0..=GREATEST_GROWTH).contains(&value) {
                return Err(Error::Value {
                    place: "refinement",
                    field,
                    value,
                    unit: "",
                    requirement: "from 1 to 4",
                });
            }
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
