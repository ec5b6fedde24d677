//! Tools to test a traction law, this crate's or anyone's: a tangent checker and proptest strategies for its input.
//!
//! The strategies cover interferences from 1e-12 m to 1e-2 m, open points, exact kinks, denormal numbers and signed
//! zeros.

use proptest::prelude::*;

use crate::law::{Components, ComponentsMut, Regime, StateView, StateViewMut, Sticking, TangentMut, TractionLaw};

/// What a law answers at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointResponse {
    /// Traction along x, y, n (Pa).
    pub traction: [f64; 3],
    /// Row `i` holds the derivatives of traction `i` with respect to the jump (Pa/m).
    pub tangent: [[f64; 3]; 3],
    /// State reached.
    pub end: Vec<f64>,
    /// Regime.
    pub regime: Regime,
}

/// Evaluates one point of a law under `jump` (m) from the state `begin`.
pub fn evaluate_point<L: TractionLaw + ?Sized>(
    law: &L,
    point: usize,
    sticking: Sticking,
    jump: [f64; 3],
    begin: &[f64],
) -> PointResponse {
    let mut end = vec![0.0; law.info().n_state()];
    let [mut x, mut y, mut n] = [0.0; 3];
    let mut j = [[0.0]; 9];
    let [xx, xy, xn, yx, yy, yn, nx, ny, nn] = &mut j;
    let mut regime = [Regime::Open];
    law.evaluate(
        point..point + 1,
        sticking,
        Components {
            x: &jump[..1],
            y: &jump[1..2],
            n: &jump[2..],
        },
        StateView {
            data: begin,
            stride: 1,
            offset: 0,
        },
        StateViewMut {
            data: &mut end,
            stride: 1,
            offset: 0,
        },
        ComponentsMut {
            x: core::slice::from_mut(&mut x),
            y: core::slice::from_mut(&mut y),
            n: core::slice::from_mut(&mut n),
        },
        Some(TangentMut {
            xx,
            xy,
            xn,
            yx,
            yy,
            yn,
            nx,
            ny,
            nn,
        }),
        Some(&mut regime),
    );
    let tangent = core::array::from_fn(|i| core::array::from_fn(|k| j[3 * i + k][0]));
    PointResponse {
        traction: [x, y, n],
        tangent,
        end,
        regime: regime[0],
    }
}

/// Largest error of a law's tangent against fourth-order central differences, or `None` if a kink is too near.
///
/// For laws whose first state components are those of [`crate::FrictionalLaw`]. The steps are 1e-5 of the lengths over
/// which the response changes: `u_n` and the tangential traction over its stiffness. Entry `(i, k)` is measured relative
/// to the larger of itself and traction `i` over the length of direction `k`.
pub fn tangent_error<L: TractionLaw + ?Sized>(
    law: &L,
    point: usize,
    sticking: Sticking,
    jump: [f64; 3],
    begin: &[f64],
) -> Option<f64> {
    let here = evaluate_point(law, point, sticking, jump, begin);
    let stuck = evaluate_point(law, point, Sticking::Full, jump, begin);
    let stuck_length = stuck.traction[0].hypot(stuck.traction[1]);
    let over_closing = stuck.tangent[0][2].hypot(stuck.tangent[1][2]) * jump[2].abs();
    let trial = stuck_length.max(begin[3].hypot(begin[4])).max(over_closing);
    if here.regime == Regime::Slip && stuck_length < 0.01 * trial {
        // The direction of slip turns within the steps: the tip of the cone.
        return None;
    }
    let stiffness = stuck.tangent[0][0].abs().max(stuck.tangent[1][1].abs());
    let reach = trial / stiffness;
    let along = if reach.is_normal() { reach } else { jump[2].abs() };
    let lengths = [along, along, jump[2].abs()];
    let tangential = if here.regime == Regime::Slip {
        here.traction[0].hypot(here.traction[1])
    } else {
        trial
    };
    // Tractions below have lost digits to underflow.
    let tangential = tangential.max(f64::MIN_POSITIVE / f64::EPSILON);
    let tractions = [tangential, tangential, here.traction[2]];

    let mut worst = 0.0_f64;
    for k in 0..3 {
        let step = 1e-5 * lengths[k];
        let at = |steps: f64| {
            let mut moved = jump;
            moved[k] += steps * step;
            // The step as it was rounded.
            (moved[k] - jump[k], evaluate_point(law, point, sticking, moved, begin))
        };
        let stencil = [at(-2.0), at(-1.0), at(1.0), at(2.0)];
        if stencil.iter().any(|(_, response)| response.regime != here.regime) {
            return None;
        }
        let [(a, far_left), (b, left), (c, right), (d, far_right)] = &stencil;
        for i in 0..3 {
            let near = (right.traction[i] - left.traction[i]) / (c - b);
            let far = (far_right.traction[i] - far_left.traction[i]) / (d - a);
            let difference = (4.0 * near - far) / 3.0;
            let entry = here.tangent[i][k];
            let scale = entry.abs().max(tractions[i] / lengths[k]);
            if difference != entry {
                worst = worst.max((difference - entry).abs() / scale);
            }
        }
    }
    Some(worst)
}

/// Numbers spread evenly over the decades between `lower` and `upper`.
pub fn log_uniform(lower: f64, upper: f64) -> impl Strategy<Value = f64> {
    (lower.ln()..upper.ln()).prop_map(f64::exp)
}

fn special() -> impl Strategy<Value = f64> {
    let tiny = f64::from_bits(1);
    prop::sample::select(vec![0.0, -0.0, tiny, -tiny, f64::MIN_POSITIVE, -f64::MIN_POSITIVE])
}

/// Interferences of closed points, 1e-12 m to 1e-2 m.
pub fn closed_interference() -> impl Strategy<Value = f64> {
    log_uniform(1e-12, 1e-2)
}

/// Interferences of closed and open points, with zeros and denormal numbers.
pub fn interference() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => closed_interference(),
        2 => closed_interference().prop_map(|u| -u),
        1 => special(),
    ]
}

/// Tangential displacements of either sign up to 1e-3 m, with zeros and denormal numbers.
pub fn displacement() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => log_uniform(1e-14, 1e-3),
        4 => log_uniform(1e-14, 1e-3).prop_map(|u| -u),
        1 => special(),
    ]
}

/// Jumps `[u_x, u_y, u_n]`.
pub fn jump() -> impl Strategy<Value = [f64; 3]> {
    (displacement(), displacement(), interference()).prop_map(|(x, y, n)| [x, y, n])
}

/// Begin states `[u_x, u_y, u_n, t_x, t_y]`; open points carry no traction.
pub fn begin_state() -> impl Strategy<Value = [f64; 5]> {
    let traction = || {
        (any::<bool>(), log_uniform(1e-3, 1e9), 0..8).prop_map(|(negative, t, zero)| match (zero, negative) {
            (0, _) => 0.0,
            (_, false) => t,
            (_, true) => -t,
        })
    };
    (jump(), traction(), traction()).prop_map(|([x, y, n], tx, ty)| {
        if n > 0.0 {
            [x, y, n, tx, ty]
        } else {
            [x, y, n, 0.0, 0.0]
        }
    })
}

/// Friction coefficients from 0 to 10, both included.
pub fn friction_coefficient() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 1 => Just(10.0), 6 => 0.0..10.0, 2 => log_uniform(1e-6, 1.0)]
}
