//! Stepped-sine tests against the mode that made them.

use file_io::Source;
use modal_identification::readers::steps;
use modal_identification::signal::Quantity;
use modal_identification::stepped_sine::{Level, Step, Unfitted};
use std::f64::consts::TAU;

const MASS: f64 = 0.7;
const ZETA: f64 = 0.013;
const FREQUENCY: f64 = 42.0;

/// What a mode needs to move by this amplitude of a quantity.
fn step(frequency_hz: f64, response: f64, quantity: Quantity) -> Step {
    let (omega, natural) = (TAU * frequency_hz, TAU * FREQUENCY);
    let displacement = response / omega.powi(quantity.derivatives());
    let (real, imaginary) = (
        MASS * (natural * natural - omega * omega),
        2.0 * MASS * ZETA * natural * omega,
    );
    Step {
        frequency_hz,
        force: displacement * real.hypot(imaginary),
        response,
        phase_deg: imaginary.atan2(real).to_degrees(),
        drift_hz_per_s: 0.0,
    }
}

fn level(quantity: Quantity, frequencies: &[f64]) -> Level {
    Level {
        name: "1".into(),
        quantity,
        steps: frequencies.iter().map(|f| step(*f, 2e-3, quantity)).collect(),
    }
}

#[test]
fn levels_give_the_mode_that_made_them_whatever_is_measured() {
    let around = [30.0, 41.0, 41.6, 41.9, 42.3, 42.8, 60.0];
    for quantity in [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration] {
        let found = level(quantity, &around).fit(None).expect("a mode");
        assert!((found.frequency_hz / FREQUENCY - 1.0).abs() < 1e-12);
        assert!((found.damping_ratio / ZETA - 1.0).abs() < 1e-10);
        assert!((found.modal_mass / MASS - 1.0).abs() < 1e-9);
        assert!(found.residual.is_some_and(|residual| residual < 1e-12));
        // The first and the last are too far from the resonance.
        assert_eq!((found.steps, found.amplitude), (5, 2e-3));
        let one = level(quantity, &[FREQUENCY]).fit(Some(MASS)).expect("phase resonance");
        assert!((one.damping_ratio / ZETA - 1.0).abs() < 1e-12 && one.residual.is_none());
    }
    // Where a fit is possible, a mass that is wrong does nothing.
    let fitted = level(Quantity::Displacement, &around)
        .fit(Some(2.0 * MASS))
        .expect("a mode");
    assert!((fitted.modal_mass / MASS - 1.0).abs() < 1e-9);
    let few = level(Quantity::Displacement, &[41.9, 42.1]);
    assert_eq!(few.fit(None), Err(Unfitted::TooFew { found: 2 }));
}

#[test]
fn tables_are_read_level_by_level_and_refused_with_their_place() {
    let parse = |text: &str| {
        steps::parse(Source {
            name: "steps.csv",
            bytes: text.as_bytes(),
        })
    };
    let heading = "level [m],frequency [Hz],amplitude [mm],phase_lag [deg],turns,force [N]\n";
    let found = parse(&format!(
        "{heading}1,10,2,80,false,3\n1,11,2,-5,true,4\n2,10,5,90,false,6\n"
    ))
    .expect("a table");
    assert_eq!(found.iter().map(|level| level.steps.len()).collect::<Vec<_>>(), [2, 1]);
    let second = found[0].steps[1];
    assert!((second.response - 2e-3).abs() < 1e-18 && second.phase_deg == 355.0 && second.force == 4.0);
    for (text, told) in [
        ("frequency [Hz],amplitude [m]\n1,2\n".to_owned(), "phase_lag"),
        (heading.to_owned(), "no rows"),
        (format!("{heading}1,10,2,80,false,-3\n"), "positive"),
        (format!("{heading}1,10,x,80,false,3\n"), "`x`"),
        (format!("{heading}1,10,2\n"), "rows of equal length"),
        (
            heading.replace("[Hz]", "[rad/s]") + "1,1,1,1,false,1\n",
            "frequency [Hz]",
        ),
        (heading.replace("[mm]", "[furlong]") + "1,1,1,1,false,1\n", "furlong"),
    ] {
        let refused = parse(&text).map(|_| ()).expect_err("refused").to_string();
        assert!(refused.contains(told), "{refused}");
    }
}
