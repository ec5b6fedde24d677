//! The set of tangential tractions that friction can carry.

use super::history_rule::HistoryRule;
use super::return_map::{Block, CurveChange, Derivative, SLIP, TRACTION, Workspace};
use crate::law::RegimeCounts;
use crate::simd::Lanes;
use crate::simd::bounds::{bounded, within};

/// Shape of the limit of the tangential traction at a point, with Coulomb's limit `L = mu t_n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Cone {
    /// `t_x^2 + t_y^2 <= L^2`: the same in every direction.
    #[default]
    Circle,
    /// `|t_x| <= L` and `|t_y| <= L`: each direction slips on its own. A point slips if one direction does.
    Box,
}

/// Numbers of a block that is answered one direction at a time.
pub(crate) struct BoxWorkspace<const B: usize> {
    traction: [Lanes<f64, B>; 3],
    tangent: [Lanes<f64, B>; 9],
    memory: [Lanes<f64, B>; 2],
    derivative: Changes<B>,
}

/// What [`Derivative`] has of one direction of the surface.
struct Along<'a, const B: usize> {
    jump: [&'a [f64]; 3],
    begin: [&'a [f64]; 5],
    curves: &'a CurveChange<B>,
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
        Some(workspace) => in_box(history, workspace, block),
    }
}

fn in_box<const B: usize>(history: HistoryRule, own: &mut BoxWorkspace<B>, block: Block<'_, B>) -> RegimeCounts {
    let n = block.mu.len();
    let still = [0.0; B];
    let still = &still[..n];
    let Block {
        jump: [u_x, u_y, u_n],
        begin: [x_0, y_0, n_0, m_x, m_y],
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
    let alone = |jump,
                 begin,
                 workspace: &mut Workspace<B>,
                 own: &mut BoxWorkspace<B>,
                 with_tangent: bool,
                 along: Option<Along<'_, B>>| {
        history.respond(Block {
            jump,
            begin,
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
            derivative: along.map(|Along { jump, begin, curves }| Derivative {
                jump,
                begin,
                curves,
                memory: own.derivative.memory.each_mut().map(|lanes| &mut lanes.0[..n]),
                traction: own.derivative.traction.each_mut().map(|lanes| &mut lanes.0[..n]),
            }),
        });
    };
    let with_tangent = tangent.is_some();
    let along = derivative.as_ref().map(|derivative| {
        let Derivative {
            jump: [d_x, _, d_n],
            begin: [d_x0, _, d_n0, d_memory, _],
            curves,
            ..
        } = *derivative;
        Along {
            jump: [d_x, still, d_n],
            begin: [d_x0, still, d_n0, d_memory, still],
            curves,
        }
    });
    alone(
        [u_x, still, u_n],
        [x_0, still, n_0, m_x, still],
        workspace,
        own,
        with_tangent,
        along,
    );
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
    let along = derivative.as_ref().map(|derivative| {
        let Derivative {
            jump: [_, d_y, d_n],
            begin: [_, d_y0, d_n0, _, d_memory],
            curves,
            ..
        } = *derivative;
        Along {
            jump: [still, d_y, d_n],
            begin: [still, d_y0, d_n0, still, d_memory],
            curves,
        }
    });
    alone(
        [still, u_y, u_n],
        [still, y_0, n_0, still, m_y],
        workspace,
        own,
        with_tangent,
        along,
    );
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
