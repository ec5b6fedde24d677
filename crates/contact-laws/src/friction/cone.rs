//! The set of tangential tractions that friction can carry.

use super::history_rule::HistoryRule;
use super::return_map::{Block, Derivative, SLIP, TRACTION, Workspace};
use crate::choice::choices;
use crate::law::RegimeCounts;
use crate::simd::Lanes;
use crate::simd::bounds::{bounded, within};

choices! {
    /// Shape of the limit of the tangential traction at a point, with Coulomb's limit `L = mu t_n`.
    pub enum Cone, "CONE", "Slip limit, with Coulomb's limit L = mu t_n" {
        Circle = "circle", 0, "`t_x^2 + t_y^2 <= L^2`: the same in every direction.";
        Box = "box", 1, "`|t_x| <= L` and `|t_y| <= L`: each direction slips on its own. A point slips if one direction does.";
    }
}

/// Numbers of a block that is answered one direction at a time.
pub(crate) struct BoxWorkspace<const B: usize> {
    traction: [Lanes<f64, B>; 3],
    tangent: [Lanes<f64, B>; 9],
    memory: [Lanes<f64, B>; 2],
    derivative: Changes<B>,
}

/// Derivatives along one direction of the surface.
struct Changes<const B: usize> {
    traction: [Lanes<f64, B>; 3],
    memory: [Lanes<f64, B>; 2],
}

impl<const B: usize> BoxWorkspace<B> {
    pub(crate) fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            traction: [zero; 3],
            tangent: [zero; 9],
            memory: [zero; 2],
            derivative: Changes {
                traction: [zero; 3],
                memory: [zero; 2],
            },
        }
    }
}

/// Response of a block under a cone, whose regimes are left in the block's workspace. In a box both directions are answered
/// alone, each as if the other did not move.
pub(super) fn respond<const B: usize>(
    history: HistoryRule,
    workspace: &mut Option<BoxWorkspace<B>>,
    block: Block<'_, B>,
) -> RegimeCounts {
    match workspace {
        None => history.respond(block),
        Some(workspace) => respond_box(history, workspace, block),
    }
}

fn respond_box<const B: usize>(history: HistoryRule, own: &mut BoxWorkspace<B>, block: Block<'_, B>) -> RegimeCounts {
    let n = block.mu.len();
    let still = [0.0; B];
    let still = &still[..n];
    let Block {
        jump,
        begin,
        mu,
        mu_slope,
        u_n: closed,
        present,
        curves,
        sticking,
        workspace,
        memory: [end_x, end_y],
        traction: [t_x, t_y, t_n],
        mut tangent,
        regimes,
        mut derivative,
    } = block;
    let with_tangent = tangent.is_some();
    let alone =
        |q: usize, workspace: &mut Workspace<B>, own: &mut BoxWorkspace<B>, derivative: Option<&Derivative<'_, B>>| {
            history.respond(Block {
                jump: only_jump(q, jump, still),
                begin: only_state(q, begin, still),
                mu,
                mu_slope,
                u_n: closed,
                present,
                curves,
                sticking,
                workspace,
                memory: own.memory.each_mut().map(|lanes| &mut lanes.0[..n]),
                traction: own.traction.each_mut().map(|lanes| &mut lanes.0[..n]),
                tangent: with_tangent.then(|| own.tangent.each_mut().map(|lanes| &mut lanes.0[..n])),
                regimes: None,
                derivative: derivative.map(|derivative| Derivative {
                    jump: only_jump(q, derivative.jump, still),
                    begin: only_state(q, derivative.begin, still),
                    curves: derivative.curves,
                    memory: own.derivative.memory.each_mut().map(|lanes| &mut lanes.0[..n]),
                    traction: own.derivative.traction.each_mut().map(|lanes| &mut lanes.0[..n]),
                }),
            });
        };
    alone(0, workspace, own, derivative.as_ref());
    let along_x = workspace.regime;
    for i in 0..n {
        (t_x[i], t_n[i], end_x[i]) = (own.traction[0].0[i], own.traction[2].0[i], own.memory[0].0[i]);
    }
    if let Some([xx, xy, xn, .., nx, _, nn]) = &mut tangent {
        for i in 0..n {
            (xx[i], xy[i], xn[i]) = (own.tangent[0].0[i], 0.0 * closed.0[i], own.tangent[2].0[i]);
            (nx[i], nn[i]) = (own.tangent[6].0[i], own.tangent[8].0[i]);
        }
    }
    if let Some(Derivative {
        memory: [d_end_x, _],
        traction: [d_x, _, d_n],
        ..
    }) = &mut derivative
    {
        for i in 0..n {
            (d_x[i], d_n[i]) = (own.derivative.traction[0].0[i], own.derivative.traction[2].0[i]);
            d_end_x[i] = own.derivative.memory[0].0[i];
        }
    }
    alone(1, workspace, own, derivative.as_ref());
    // Both answers hold the normal traction of the curves; what the stretch of each direction adds counts once.
    let without = |both: f64, curve: f64, closed: f64| if closed > 0.0 { both - curve } else { both };
    for i in 0..n {
        (t_y[i], end_y[i]) = (own.traction[1].0[i], own.memory[1].0[i]);
        t_n[i] += without(own.traction[2].0[i], bounded(curves.normal.0[i]), closed.0[i]);
    }
    if let Some([_, _, _, yx, yy, yn, _, ny, nn]) = &mut tangent {
        for i in 0..n {
            (yx[i], yy[i], yn[i]) = (0.0 * closed.0[i], own.tangent[4].0[i], own.tangent[5].0[i]);
            ny[i] = own.tangent[7].0[i];
            nn[i] += without(own.tangent[8].0[i], bounded(curves.normal_slope.0[i]), closed.0[i]);
        }
    }
    if let Some(Derivative {
        curves: change,
        memory: [_, d_end_y],
        traction: [_, d_y, d_n],
        ..
    }) = &mut derivative
    {
        for i in 0..n {
            (d_y[i], d_end_y[i]) = (own.derivative.traction[1].0[i], own.derivative.memory[1].0[i]);
            let curve = within(change.normal.0[i], TRACTION);
            d_n[i] += without(own.derivative.traction[2].0[i], curve, closed.0[i]);
        }
    }
    for (regime, along_x) in workspace.regime.0[..n].iter_mut().zip(along_x.0) {
        *regime = if along_x == SLIP { SLIP } else { *regime };
    }
    workspace.sum = workspace.regime.0[..n].iter().sum();
    workspace.report(n, regimes)
}

/// The jump of a block, or its change, as if the direction of the surface that is not `q` did not move.
fn only_jump<'a>(q: usize, [x, y, n]: [&'a [f64]; 3], still: &'a [f64]) -> [&'a [f64]; 3] {
    match q {
        0 => [x, still, n],
        _ => [still, y, n],
    }
}

/// The same of the begin state.
fn only_state<'a>(q: usize, [x, y, n, x_1, y_1]: [&'a [f64]; 5], still: &'a [f64]) -> [&'a [f64]; 5] {
    match q {
        0 => [x, still, n, x_1, still],
        _ => [still, y, n, still, y_1],
    }
}
