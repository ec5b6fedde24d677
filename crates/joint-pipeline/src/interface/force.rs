//! The adapter through which the solver sees an interface.

use contact_laws::Sticking;
use cqsma_solver::{HystereticForce, Pattern, PointCounts, Sliding};
use zte_assembly::{Interface, State, Workspace};

/// The interface as the solver sees it.
pub struct InterfaceForce<'a> {
    interface: &'a Interface,
    pattern: Pattern,
}

impl<'a> InterfaceForce<'a> {
    /// Wraps an interface.
    pub fn new(interface: &'a Interface) -> Self {
        let pattern = interface.pattern();
        Self {
            interface,
            pattern: Pattern {
                indptr: pattern.indptr.clone(),
                indices: pattern.indices.clone(),
            },
        }
    }

    /// The interface.
    pub fn interface(&self) -> &Interface {
        self.interface
    }
}

impl HystereticForce for InterfaceForce<'_> {
    type State = State;
    type Workspace = Workspace;

    fn n_dofs(&self) -> usize {
        self.interface.n_dofs()
    }

    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn initial_state(&self) -> State {
        self.interface.initial_state()
    }

    fn workspace(&self) -> Workspace {
        self.interface.workspace()
    }

    fn dissipates(&self) -> bool {
        self.interface.dissipates()
    }

    fn evaluate(
        &self,
        u: &[f64],
        sliding: Sliding,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> PointCounts {
        let sticking = match sliding {
            Sliding::Allowed => Sticking::Coulomb,
            Sliding::Prevented => Sticking::Full,
        };
        let counts = self
            .interface
            .evaluate(u, sticking, begin, end, workspace, force, tangent);
        PointCounts {
            stick: counts.stick,
            slip: counts.slip,
            open: counts.open,
        }
    }
}
