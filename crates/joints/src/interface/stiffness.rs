//! Stiffness of laws at a point, and means over the interface.

use contact_laws::{
    Components, ComponentsMut, ContactCurves, StateView, StateViewMut, Sticking, TangentMut, TractionLaw,
};
use zte_assembly::Operators;

/// Average over the area of values at the points.
pub(super) fn mean(operators: &Operators, of: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let points = operators.weights.iter().enumerate();
    let sum = points.fold([0.0; 2], |sum, (p, w)| {
        let value = of(p);
        [sum[0] + w * value[0], sum[1] + w * value[1]]
    });
    sum.map(|sum| sum / operators.area())
}

/// Normal and mean tangential stiffness of curves at an interference.
pub(super) fn stiffnesses(curves: &dyn ContactCurves, u: f64) -> [f64; 2] {
    let k = curves.tangential(u);
    [curves.normal(u).1, 0.5 * (k[0].value + k[1].value)]
}

/// Normal and mean tangential stiffness (Pa/m) of a point that was closed to an interference and sticks there.
pub(super) fn stuck_stiffness(law: &dyn TractionLaw, point: usize, u: f64) -> [f64; 2] {
    let n_state = law.info().n_state();
    let (mut begin, mut end) = (vec![0.0; n_state], vec![0.0; n_state]);
    let mut tangent = [[0.0]; 9];
    // First loading, and then from there.
    for _ in 0..2 {
        let [mut x, mut y, mut n] = [[0.0]; 3];
        law.evaluate(
            point..point + 1,
            Sticking::Full,
            Components::new(&[0.0], &[0.0], &[u]),
            StateView::new(&begin, 1, 0),
            StateViewMut::new(&mut end, 1, 0),
            ComponentsMut::new(&mut x, &mut y, &mut n),
            Some(TangentMut::from_entries(
                tangent.each_mut().map(|entry| entry.as_mut_slice()),
            )),
            None,
        );
        begin.copy_from_slice(&end);
    }
    let [[x], _, _, _, [y], _, _, _, [n]] = tangent;
    [n, 0.5 * (x + y)]
}

/// The interference at which curves carry a pressure; bisection on a rising function.
pub fn interference_at(curves: &dyn ContactCurves, pressure: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e-9);
    while curves.normal(high).0 < pressure && high < 1.0 {
        low = high;
        high *= 2.0;
    }
    between(curves, pressure, [low, high], 60)[1]
}

/// A bracket of that interference after so many halvings.
pub(super) fn between(
    curves: &dyn ContactCurves,
    pressure: f64,
    [mut low, mut high]: [f64; 2],
    halvings: u32,
) -> [f64; 2] {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        match curves.normal(middle).0 < pressure {
            true => low = middle,
            false => high = middle,
        }
    }
    [low, high]
}

/// Any curves.
pub(super) fn as_dyn<C: ContactCurves>(curves: &[C]) -> Vec<&dyn ContactCurves> {
    curves.iter().map(|curves| curves as &dyn ContactCurves).collect()
}
