//! What drives a structure, and through which point.

use super::check::Check;
use super::uncertain::NumberOrText;
use super::units::{Dimension, Quantity};
use crate::Error;
use serde::de::IntoDeserializer;
use serde::de::value::Error as ValueError;
use serde::{Deserialize, Serialize};

/// What drives a structure.
#[derive(Clone, Debug, PartialEq)]
pub enum Excitation {
    /// A force at the response point in its direction.
    Response,
    /// A force at a node.
    Node {
        /// The node: in a deck a label or a set of one node, in a mesh a group of one node, in matrices a label.
        node: String,
        /// Direction of the force, a unit vector.
        direction: [f64; 3],
    },
    /// A force on coordinates of matrices: label, component, factor.
    Terms(Vec<(i64, u32, f64)>),
    /// All supports move alike.
    Base(BaseMotion),
}

/// An excitation, and the field of the scene that asks for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Driver {
    /// The field.
    pub field: &'static str,
    /// The excitation.
    pub excitation: Excitation,
}

/// Motion of all supports together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BaseMotion {
    /// Direction of the motion, a unit vector; either this or `motion` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices whose coordinates do not show it, how these move when everything moves by one: label, component, factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Vec<(i64, u32, f64)>>,
}

/// Where a force acts: at the response point in its direction, unless `node` and `direction` or `terms` say otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PointForce {
    /// Node that the force acts on: in a deck a label or a set of one node, in matrices a label. Not for benchmarks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Direction of the force at the node, a unit vector.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices: factors of the coordinates that the force acts on, in the place of a node: label, component, factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub terms: Option<Vec<(i64, u32, f64)>>,
}

/// Names of the fields of a [`PointForce`] in a scene.
pub(super) struct PointFields {
    pub(super) node: &'static str,
    pub(super) direction: &'static str,
    pub(super) terms: &'static str,
}

/// Names of the fields of an excitation in a scene.
pub(super) struct ExcitationFields {
    /// Direction and motion of the base.
    pub(super) base: [&'static str; 2],
    pub(super) point: PointFields,
}

/// Whether it is the base that moves, of a base and a force of which one must be given.
pub(super) fn one_of(base: Option<&BaseMotion>, force: Option<&PointForce>) -> Result<bool, String> {
    match (base, force) {
        (Some(_), None) => Ok(true),
        (None, Some(_)) => Ok(false),
        _ => Err("exactly one of `base` and `force` must be given".into()),
    }
}

/// What a base or a force, of which one is given, is.
pub(super) fn excitation(base: Option<&BaseMotion>, force: Option<&PointForce>) -> Excitation {
    match (base, force) {
        (Some(base), _) => Excitation::Base(base.clone()),
        (None, Some(force)) => point(force),
        (None, None) => Excitation::Response,
    }
}

/// A number in the units of the file, or a text, as a quantity of a moving base or of a force, in SI.
pub(super) fn of_kind<B: Dimension, F: Dimension>(is_base: bool, value: &NumberOrText) -> Result<f64, String> {
    fn of<D: Dimension>(value: &NumberOrText) -> Result<f64, String> {
        let found: Result<Quantity<D>, ValueError> = match value {
            NumberOrText::Number(number) => Quantity::deserialize((*number).into_deserializer()),
            NumberOrText::Text(text) => Quantity::deserialize(text.as_str().into_deserializer()),
        };
        found.map(Quantity::si).map_err(|error| error.to_string())
    }
    if is_base { of::<B>(value) } else { of::<F>(value) }
}

/// Refuses what cannot be of a base or a force.
pub(super) fn check_excitation(
    check: &Check<'_>,
    fields: &ExcitationFields,
    base: Option<&BaseMotion>,
    force: Option<&PointForce>,
    is_matrices: bool,
) -> Result<(), Error> {
    if let Some(base) = base {
        check_base(check, fields.base, base, is_matrices)?;
    }
    match force {
        Some(force) => check_point(check, &fields.point, force),
        None => Ok(()),
    }
}

/// What a force acts on.
fn point(force: &PointForce) -> Excitation {
    match (&force.node, force.direction, &force.terms) {
        (_, _, Some(terms)) => Excitation::Terms(terms.clone()),
        (Some(node), Some(direction), None) => Excitation::Node {
            node: node.clone(),
            direction,
        },
        _ => Excitation::Response,
    }
}

/// Refuses directions that are no unit vectors.
pub(super) fn check_direction(check: &Check<'_>, field: &'static str, direction: [f64; 3]) -> Result<(), Error> {
    let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    let unit = (length - 1.0).abs() < 1e-6;
    check.that(unit, field, length, "(length)", "a unit vector")
}

/// Refuses motions of the base that are none, and coordinates of what are no matrices.
fn check_base(
    check: &Check<'_>,
    [direction, motion]: [&'static str; 2],
    base: &BaseMotion,
    is_matrices: bool,
) -> Result<(), Error> {
    let given = u8::from(base.direction.is_some()) + u8::from(base.motion.is_some());
    check.that(
        given == 1,
        direction,
        f64::from(given),
        "(given)",
        "exactly one of direction and motion",
    )?;
    if let Some(along) = base.direction {
        check_direction(check, direction, along)?;
    }
    check.that(
        is_matrices || base.motion.is_none(),
        motion,
        1.0,
        "(given)",
        "left out where the structure is not given as matrices",
    )?;
    for (_, _, factor) in base.motion.iter().flatten() {
        let finite = factor.is_finite() && *factor != 0.0;
        check.that(finite, motion, *factor, "", "finite and not zero")?;
    }
    Ok(())
}

/// Refuses a node without a direction, both a node and terms, and terms that are empty or without effect.
pub(super) fn check_point(check: &Check<'_>, fields: &PointFields, force: &PointForce) -> Result<(), Error> {
    let PointForce { node, direction, terms } = force;
    let given = f64::from(u8::from(node.is_some()));
    let both = node.is_some() == direction.is_some();
    check.that(both, fields.node, given, "(given)", "given together with its direction")?;
    let one = terms.is_none() || node.is_none();
    check.that(one, fields.terms, 1.0, "(given)", "left out where a node is given")?;
    if let Some(direction) = direction {
        check_direction(check, fields.direction, *direction)?;
    }
    for (_, _, factor) in terms.iter().flatten() {
        let finite = factor.is_finite() && *factor != 0.0;
        check.that(finite, fields.terms, *factor, "", "finite and not zero")?;
    }
    let empty = terms.as_ref().is_some_and(Vec::is_empty);
    check.that(!empty, fields.terms, 0.0, "(terms)", "at least one")
}

/// Refuses points that the structure of a scene does not have.
pub(super) fn check_structure(
    check: &Check<'_>,
    fields: &PointFields,
    excitation: &Excitation,
    [is_benchmark, is_matrices]: [bool; 2],
) -> Result<(), Error> {
    let given = matches!(excitation, Excitation::Node { .. } | Excitation::Terms(_));
    check.that(
        !(is_benchmark && given),
        fields.node,
        1.0,
        "(given)",
        "left out on a benchmark, whose force acts at the response point",
    )?;
    check.that(
        is_matrices || !matches!(excitation, Excitation::Terms(_)),
        fields.terms,
        1.0,
        "(given)",
        "left out where the structure is not given as matrices",
    )
}
