//! The answer of a run, on a mass with a spring and a slider, whose backbone is known.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::points::read;
use crate::uncertainty::{MU_PATH, closed_form, onset, slider};
use analyses::results::answer::Verdict;
use analyses::results::summary::Summary;
use analyses::{prepare, run, run_samples};
use joints::Options;
use joints::progress::Silent;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use test_support::TemporaryFolder;

fn summary(given: &Value) -> Summary {
    let run = run(&read(given).unwrap(), &Options::default(), &Silent).unwrap();
    Summary::new(&run, BTreeMap::new(), None)
}

#[test]
fn few_amplitudes_are_answered_as_they_are() {
    let given = slider("answer-few", &Value::Null);
    let summary = summary(&given);
    let [answer] = summary.answer.as_slice() else {
        panic!("one mode")
    };
    assert_eq!((answer.mode, answer.damping.len()), (1, 5));
    assert_eq!(answer.frequency_hz, summary.modes[0].frequency_hz);
    for (one, point) in answer.damping.iter().zip(&summary.backbone) {
        assert_eq!(Some(one.amplitude_m), point.response_displacement);
        assert_eq!(
            (Some(one.frequency_hz), one.ratio),
            (point.frequency_hz, point.damping_ratio)
        );
    }
    // The slider is all of the contact: between the last amplitude that sticks and the first that slips.
    let first = summary
        .backbone
        .iter()
        .find(|point| point.slip_fraction > Some(0.5))
        .unwrap();
    let found = answer.onset_amplitude_m.unwrap();
    assert!(
        found <= first.response_displacement.unwrap() && found > 0.4 * onset(),
        "{found}"
    );
    let [from, to] = answer.onset_interval_m.unwrap();
    assert!(from < found && found <= to && from < onset() && Some(to) == first.response_displacement);
    // Matrices do not show their mesh.
    assert_eq!(answer.verdict, Verdict::WithCare);
    assert!(
        answer.reason.contains("not known: matrices do not show their mesh"),
        "{}",
        answer.reason
    );
    assert!(answer.frequency_interval_hz.is_none() && answer.frequency_band_hz.is_none());
}

#[test]
fn many_amplitudes_are_answered_at_powers_of_ten() {
    let mut given = slider("answer-many", &Value::Null);
    given["analyses"]["backbone"]["amplitudes"] = json!(24);
    given["analyses"]["backbone"]["amplitude_from"] = json!("5 um");
    given["analyses"]["backbone"]["amplitude_to"] = json!("2 mm");
    given["background_damping"] = json!(1e-3);
    let summary = summary(&given);
    let answered: Vec<f64> = summary.answer[0].damping.iter().map(|one| one.amplitude_m).collect();
    assert_eq!(answered, [1e-5, 1e-4]);
    // Nothing slips before 200 um.
    assert!(summary.answer[0].damping.iter().all(|one| one.ratio.is_none()));
    given["analyses"]["backbone"]["amplitude_from"] = json!("0.3 mm");
    given["analyses"]["backbone"]["amplitude_to"] = json!("3 mm");
    let summary = self::summary(&given);
    let answer = &summary.answer[0];
    // None of them is within: the ends.
    let [first, last] = answer.damping.as_slice() else {
        panic!("{:?}", answer.damping)
    };
    for one in [first, last] {
        let [frequency, ratio] = closed_form(5e4, 0.2, one.amplitude_m);
        assert!((one.frequency_hz / frequency - 1.0).abs() < 1e-3);
        assert!(((one.ratio.unwrap() - 1e-3) / ratio - 1.0).abs() < 0.01);
    }
    // It slips from the beginning.
    assert_eq!(answer.onset_amplitude_m, Some(first.amplitude_m));
    assert_eq!(answer.onset_interval_m, None);
}

/// Of two neighbours of 100 um the damping of one alone is known; and a loop between them did not close.
#[test]
fn a_damping_that_one_neighbour_alone_has_is_answered_there() {
    let mut given = slider("answer-neighbour", &Value::Null);
    given["analyses"]["backbone"]["amplitudes"] = json!(12);
    given["analyses"]["backbone"]["amplitude_from"] = json!("5 um");
    given["analyses"]["backbone"]["amplitude_to"] = json!("2 mm");
    let mut summary = summary(&given);
    let all: Vec<f64> = summary
        .backbone
        .iter()
        .map(|point| point.response_displacement.unwrap())
        .collect();
    let above = all.iter().position(|amplitude| *amplitude > 1e-4).unwrap();
    for point in &mut summary.backbone {
        (point.damping_ratio, point.friction_damping_ratio) = (None, None);
    }
    let known = &mut summary.backbone[above];
    (known.damping_ratio, known.friction_damping_ratio) = (Some(0.01), Some(0.01));
    let nearer = if all[above] * all[above - 1] < 1e-8 {
        above
    } else {
        above - 1
    };
    let answer = &summary.answers()[0];
    let last = answer.damping.last().unwrap();
    assert_eq!(last.amplitude_m, all[nearer]);
    assert_eq!(last.ratio, summary.backbone[nearer].damping_ratio);

    summary.backbone[above].closed = Some(false);
    let told = summary.answers()[0].clone();
    assert_eq!(told.verdict, Verdict::WithCare);
    assert!(
        told.reason.contains("1 of 12 loops did not close within"),
        "{}",
        told.reason
    );
}

#[test]
fn bands_are_those_of_the_samples() {
    let given = slider(
        "answer-bands",
        &json!({ "parameters": { MU_PATH: { "uniform": [0.18, 0.22] } } }),
    );
    let (run, found) = run_samples(&read(&given).unwrap(), 40, None, &Options::default(), &Silent).unwrap();
    let bands = found.modes[0].bands.clone();
    let summary = Summary::new(&run, BTreeMap::new(), None).with_uncertainty(Some(found));
    let answer = &summary.answer[0];
    let [low, _, high] = bands[0].frequency_hz.quantiles;
    assert_eq!(answer.frequency_band_hz, low.zip(high).map(|(low, high)| [low, high]));
    for (one, band) in answer.damping.iter().zip(&bands[1..]).skip(2) {
        let [low, _, high] = band.damping_ratio.quantiles;
        assert_eq!(one.band, Some([low.unwrap(), high.unwrap()]));
        assert!(one.band.unwrap()[0] < one.ratio.unwrap() && one.ratio.unwrap() < one.band.unwrap()[1]);
    }
}

#[test]
fn what_did_not_converge_is_not_reliable() {
    let mut failed = summary(&slider("answer-failed", &Value::Null));
    failed.backbone[4].converged = false;
    let answers = failed.answers();
    assert_eq!(answers[0].verdict, Verdict::NotReliable);
    assert_eq!(answers[0].reason, "1 of 5 amplitudes did not converge");
    assert_eq!(answers[0].damping.len(), 4);
}

#[test]
fn intervals_are_the_errors_of_the_settings() {
    let given = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "interfaces": { "gap": "flat" },
        "analyses": { "backbone": { "amplitudes": 8, "amplitude_from": 1e-6, "amplitude_to": 4e-4, "vertices_per_quarter": 4 } },
    });
    let summary = summary(&given);
    let [answer] = summary.answer.as_slice() else {
        panic!("one mode")
    };
    let answered: Vec<f64> = answer
        .damping
        .iter()
        .map(|one| (1e6 * one.amplitude_m).round())
        .collect();
    assert_eq!(answered, [1.0, 10.0, 100.0]);
    let known = summary.backbone.iter().map(|point| point.error.as_ref().unwrap());
    let errors: Vec<f64> = known.map(|error| error.frequency_relative.unwrap()).collect();
    let largest = errors.iter().copied().fold(0.0, f64::max);
    for one in &answer.damping {
        let [low, high] = one.frequency_interval_hz.unwrap();
        let width = 0.5 * (high - low) / one.frequency_hz;
        let above = summary
            .backbone
            .iter()
            .position(|p| p.response_displacement.unwrap() >= one.amplitude_m)
            .unwrap();
        let neighbours = [above.saturating_sub(1), above].map(|place| &summary.backbone[place]);
        // Between computed amplitudes no more is added than the frequency falls by from one to the other.
        let [before, after] = neighbours.map(|point| point.frequency_hz.unwrap());
        let fall = 0.5 * (before - after) / one.frequency_hz;
        assert!(width <= 1.000_001 * (largest + fall) && width > 0.0);
        let [low, high] = one.interval.unwrap();
        assert!(low < one.ratio.unwrap() && one.ratio.unwrap() < high);
        let ends = neighbours.map(|point| point.damping_ratio.unwrap());
        assert!(ends[0] <= one.ratio.unwrap() && one.ratio.unwrap() <= ends[1]);
    }
    assert!(answer.onset_amplitude_m.unwrap() > 2e-5);
    assert!(!answer.reason.contains("CQSMA") && !answer.reason.contains("ZTE"));
}

/// A test whose frequencies are a percent above those of a run and whose dampings are twice as large, in um.
#[test]
fn measured_backbones_are_beside_the_answer() {
    let folder = TemporaryFolder::new("answer-measured");
    let file = folder.join("test.csv");
    let mut given = slider("answer-measured", &Value::Null);
    given["analyses"]["backbone"] = json!({ "amplitudes": 12, "amplitude_from": "0.3 mm", "amplitude_to": "3 mm" });
    let rows = summary(&given).backbone.into_iter().map(|point| {
        let (motion, ratio) = (
            point.response_motion.unwrap(),
            point.damping_ratio_first_harmonic.unwrap(),
        );
        let frequency = point.frequency_first_harmonic_hz.unwrap();
        format!("{},{},{}\n", 1e6 * motion, 1.01 * frequency, 2.0 * ratio)
    });
    let rows: String = rows.skip(2).collect();
    std::fs::write(&file, format!("amplitude [um],frequency_hz,damping_ratio\n{rows}")).unwrap();
    given["analyses"]["backbone"]["measured"] = json!([file]);
    let summary = summary(&given);
    let [one] = summary.measured.as_slice() else {
        panic!("{:?}", summary.measured)
    };
    let misfit = one.misfit.unwrap();
    assert!(
        (misfit.frequency_percent.mean + 100.0 * 0.01 / 1.01).abs() < 1e-9,
        "{misfit:?}"
    );
    assert!(
        (misfit.damping_ln.unwrap().mean + 2.0_f64.ln()).abs() < 0.02,
        "{misfit:?}"
    );
    assert_eq!(one.points.len(), 10);
    let scene = read(&given).unwrap();
    let inputs = analyses::results::provenance::inputs_of(&scene).unwrap();
    assert!(inputs.iter().any(|input| input.path == file.display().to_string()));
    // What cannot be read is refused before anything is computed.
    for (text, why) in [
        ("amplitude [um],frequency_hz\n1,2\n", "must name the columns"),
        ("amplitude [s],frequency_hz,damping_ratio\n1,2,3\n", "the unit `s`"),
        (
            "amplitude [um],frequency_hz,damping_ratio\n1,2,3\n4,x,6\n",
            "line 3, column `frequency_hz`: `x` is no number",
        ),
        (
            "amplitude [um],frequency_hz,damping_ratio\n1,2,3\n",
            "two different amplitudes",
        ),
    ] {
        std::fs::write(&file, text).unwrap();
        let error = prepare(&scene, &Options::default(), &Silent).unwrap_err().to_string();
        assert!(error.contains("test.csv") && error.contains(why), "{error}");
    }
    std::fs::remove_file(&file).unwrap();
    let error = prepare(&scene, &Options::default(), &Silent).unwrap_err().to_string();
    assert!(error.contains("test.csv"), "{error}");
}
