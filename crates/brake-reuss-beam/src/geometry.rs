//! Dimensions of the beam, its bolts, washers and nuts.
use crate::{Error, Result};
use joint_model::benchmark::ElementOrder;

const INCH: f64 = 0.0254;

/// Dimensions of the benchmark (m). The default is the public drawing: a 720 mm beam of one inch square, with 5/16
/// inch bolts. Hardware is given in inches there, hence the fractions.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Length of the assembled beam along `x`.
    pub length: f64,
    /// Width across, along `y`.
    pub width: f64,
    /// Height outside of the lap, along `z`; each half-beam has half of it inside.
    pub height: f64,
    /// Length of the lap.
    pub lap_length: f64,
    /// Diameter of the three bolt holes.
    pub hole_diameter: f64,
    /// Distance between neighbouring holes; the middle one is at the origin.
    pub hole_pitch: f64,
    /// Inner diameter of the washers.
    pub washer_inner_diameter: f64,
    /// Outer diameter of the washers.
    pub washer_outer_diameter: f64,
    /// Thickness of the washers.
    pub washer_thickness: f64,
    /// Diameter of the bolt's shank.
    pub shank_diameter: f64,
    /// Overall length of the bolt, head included.
    pub bolt_length: f64,
    /// Distance across the flats of the hexagons of head and nut.
    pub across_flats: f64,
    /// Height of the bolt's head.
    pub head_height: f64,
    /// Height of the nut.
    pub nut_height: f64,
    /// Diameter of the nut's bore.
    pub nut_bore_diameter: f64,
}

impl Default for Geometry {
    fn default() -> Self {
        Self {
            length: 0.720,
            width: INCH,
            height: INCH,
            lap_length: 0.120,
            hole_diameter: 0.0085,
            hole_pitch: 0.030,
            washer_inner_diameter: 11.0 / 32.0 * INCH,
            washer_outer_diameter: 11.0 / 16.0 * INCH,
            washer_thickness: INCH / 16.0,
            shank_diameter: 5.0 / 16.0 * INCH,
            bolt_length: (1.5 + 13.0 / 64.0) * INCH,
            across_flats: INCH / 2.0,
            head_height: 13.0 / 64.0 * INCH,
            nut_height: 13.0 / 64.0 * INCH,
            nut_bore_diameter: 5.0 / 16.0 * INCH,
        }
    }
}

impl Geometry {
    /// Positions of the holes along `x` (m).
    pub fn hole_positions(&self) -> [f64; 3] {
        [-self.hole_pitch, 0.0, self.hole_pitch]
    }

    /// Length of the arm between the lap and the beam's end (m).
    pub fn arm_length(&self) -> f64 {
        (self.length - self.lap_length) / 2.0
    }

    /// Nominal area of the interface: the lap's rectangle without the three round holes (m^2).
    pub fn interface_area(&self) -> f64 {
        self.lap_length * self.width - 3.0 * disc_area(self.hole_diameter)
    }

    /// Volume of one half-beam (m^3).
    pub fn half_beam_volume(&self) -> f64 {
        (self.arm_length() * self.width + 0.5 * self.interface_area()) * self.height
    }

    /// Volume of one washer (m^3).
    pub fn washer_volume(&self) -> f64 {
        (disc_area(self.washer_outer_diameter) - disc_area(self.washer_inner_diameter)) * self.washer_thickness
    }

    /// Volume of one bolt's shank, without the head (m^3).
    pub fn shank_volume(&self) -> f64 {
        disc_area(self.shank_diameter) * (self.bolt_length - self.head_height)
    }

    /// Volume of one bolt's head (m^3).
    pub fn head_volume(&self) -> f64 {
        self.hexagon_area() * self.head_height
    }

    /// Volume of one nut (m^3).
    pub fn nut_volume(&self) -> f64 {
        (self.hexagon_area() - disc_area(self.nut_bore_diameter)) * self.nut_height
    }

    /// Volume of the whole assembly: two half-beams, three bolts, three nuts, six washers (m^3).
    pub fn volume(&self) -> f64 {
        2.0 * self.half_beam_volume()
            + 3.0 * (self.shank_volume() + self.head_volume() + self.nut_volume() + 2.0 * self.washer_volume())
    }

    fn hexagon_area(&self) -> f64 {
        // Regular hexagon of inradius r: 2 sqrt(3) r^2.
        0.5 * 3.0_f64.sqrt() * self.across_flats * self.across_flats
    }

    /// Checks that all dimensions are positive and fit together: holes, washers and hexagons nest, the shank passes
    /// through everything, washers lie on the beam without touching each other.
    ///
    /// # Errors
    /// [`Error::Value`] or [`Error::Misfit`], naming the dimensions.
    pub fn validate(&self) -> Result<()> {
        let lengths = [
            ("length", self.length),
            ("width", self.width),
            ("height", self.height),
            ("lap_length", self.lap_length),
            ("hole_diameter", self.hole_diameter),
            ("hole_pitch", self.hole_pitch),
            ("washer_inner_diameter", self.washer_inner_diameter),
            ("washer_outer_diameter", self.washer_outer_diameter),
            ("washer_thickness", self.washer_thickness),
            ("shank_diameter", self.shank_diameter),
            ("bolt_length", self.bolt_length),
            ("across_flats", self.across_flats),
            ("head_height", self.head_height),
            ("nut_height", self.nut_height),
            ("nut_bore_diameter", self.nut_bore_diameter),
        ];
        for (field, value) in lengths {
            positive("geometry", field, value, "m")?;
        }
        let corners = self.across_flats * 2.0 / 3.0_f64.sqrt();
        let stack = self.head_height + self.height + 2.0 * self.washer_thickness + self.nut_height;
        let misfits = [
            ("lap_length", self.lap_length, "length", self.length),
            ("2.5 hole_pitch", 2.5 * self.hole_pitch, "lap_length", self.lap_length),
            (
                "hole_diameter",
                self.hole_diameter,
                "0.5 hole_pitch",
                0.5 * self.hole_pitch,
            ),
            ("hole_diameter", self.hole_diameter, "width", self.width),
            (
                "shank_diameter",
                self.shank_diameter,
                "hole_diameter",
                self.hole_diameter,
            ),
            (
                "hole_diameter",
                self.hole_diameter,
                "washer_inner_diameter",
                self.washer_inner_diameter,
            ),
            (
                "nut_bore_diameter",
                self.nut_bore_diameter,
                "washer_inner_diameter",
                self.washer_inner_diameter,
            ),
            (
                "washer_inner_diameter",
                self.washer_inner_diameter,
                "across_flats",
                self.across_flats,
            ),
            (
                "hexagon across corners",
                corners,
                "washer_outer_diameter",
                self.washer_outer_diameter,
            ),
            (
                "washer_outer_diameter",
                self.washer_outer_diameter,
                "hole_pitch",
                self.hole_pitch,
            ),
            ("washer_outer_diameter", self.washer_outer_diameter, "width", self.width),
            (
                "2 hole_pitch + washer_outer_diameter",
                2.0 * self.hole_pitch + self.washer_outer_diameter,
                "lap_length",
                self.lap_length,
            ),
            (
                "head, washers, beam and nut together",
                stack,
                "bolt_length",
                self.bolt_length,
            ),
        ];
        for (smaller, smaller_value, larger, larger_value) in misfits {
            require_less("geometry", (smaller, smaller_value), (larger, larger_value))?;
        }
        // A tight thread may have no clearance at all, so equality is fine here.
        if self.shank_diameter > self.nut_bore_diameter {
            return Err(Error::Misfit {
                place: "geometry",
                smaller: "shank_diameter",
                smaller_value: self.shank_diameter,
                larger: "nut_bore_diameter",
                larger_value: self.nut_bore_diameter,
            });
        }
        Ok(())
    }
}

/// Radius on which the nodes of `edges` equal edges lie, so that these enclose the area of a circle of `radius`. With it, areas and
/// masses are exact at any refinement.
///
/// Linear edges form a polygon: `radius sqrt(pi / (n/2 sin(2 pi/n)))`. Quadratic ones are parabolas through three points of the circle,
/// with `h = pi/n`: `radius sqrt(3 h / (sin h (4 - cos h)))`, which is `1 + h^4/60` times `radius` to leading order.
pub fn equal_area_radius(radius: f64, edges: usize, order: ElementOrder) -> f64 {
    let n = edges as f64;
    match order {
        ElementOrder::Linear => {
            radius * (std::f64::consts::PI / (0.5 * n * (2.0 * std::f64::consts::PI / n).sin())).sqrt()
        }
        ElementOrder::Quadratic => {
            let (sin, cos) = (std::f64::consts::PI / n).sin_cos();
            radius * (3.0 * std::f64::consts::PI / n / (sin * (4.0 - cos))).sqrt()
        }
    }
}

fn disc_area(diameter: f64) -> f64 {
    0.25 * std::f64::consts::PI * diameter * diameter
}

pub(crate) fn positive(place: &'static str, field: &'static str, value: f64, unit: &'static str) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::Value {
            place,
            field,
            value,
            unit,
            requirement: "finite and positive",
        })
    }
}

pub(crate) fn require_less(
    place: &'static str,
    (smaller, smaller_value): (&'static str, f64),
    (larger, larger_value): (&'static str, f64),
) -> Result<()> {
    if smaller_value < larger_value {
        Ok(())
    } else {
        Err(Error::Misfit {
            place,
            smaller,
            smaller_value,
            larger,
            larger_value,
        })
    }
}
