//! What a run found: the top of its page, and the end of what the terminal prints.

use crate::html::{MISSING, Table};
use analyses::results::answer::{Answer, Verdict};
use analyses::results::summary::{MeasuredSummary, Summary};
use std::fmt::Write;

/// The answer for one mode, on a page.
pub(crate) struct Shown {
    /// Class and sign of its verdict: neither needs colours.
    pub(crate) class: &'static str,
    pub(crate) sign: &'static str,
    pub(crate) verdict: String,
    pub(crate) frequency: String,
    pub(crate) sentence: String,
    pub(crate) table: Table,
    /// How far it lies from measured backbones.
    pub(crate) measured: Vec<String>,
}

pub(crate) fn shown(summary: &Summary) -> Vec<Shown> {
    let several = summary.answer.len() > 1;
    let of_mode = |answer: &Answer| {
        let (class, sign) = match answer.verdict {
            Verdict::Sound => ("sound", "✓"),
            Verdict::WithCare => ("with-care", "!"),
            Verdict::NotReliable => ("not-reliable", "✗"),
        };
        let mode = if several {
            format!("Mode {}: ", answer.mode)
        } else {
            String::new()
        };
        Shown {
            class,
            sign,
            verdict: format!("{}: {}", answer.verdict.words(), answer.reason),
            frequency: format!("{mode}{:.2} Hz", answer.frequency_hz),
            sentence: format!(
                "at small amplitude{}; {}.",
                intervals_of_frequency(answer),
                onset(answer)
            ),
            table: table(answer),
            measured: measured(summary, answer.mode),
        }
    };
    summary.answer.iter().map(of_mode).collect()
}

/// The answers as lines of a terminal, five at most for each mode.
pub fn lines(summary: &Summary) -> String {
    let mut out = String::new();
    for answer in &summary.answer {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "\nmode {}: {:.2} Hz at small amplitude{}; {}",
            answer.mode,
            answer.frequency_hz,
            intervals_of_frequency(answer),
            onset(answer)
        );
        // The first, the middle and the last of more.
        let count = answer.damping.len();
        let places = match count {
            0..=3 => (0..count).collect(),
            _ => vec![0, count / 2, count - 1],
        };
        for one in places.into_iter().map(|place| &answer.damping[place]) {
            let ratio = one.ratio.map_or_else(|| "below what can be resolved".into(), percent);
            let by_numbers = one
                .interval
                .map_or_else(String::new, |ends| format!(" ({})", range(ends, &percent)));
            let by_inputs = one.band.map_or_else(String::new, |ends| {
                format!(", {} by the uncertain inputs", range(ends, &percent))
            });
            let _ = writeln!(
                out,
                "  at {}: {:.2} Hz, damping {ratio}{by_numbers}{by_inputs}",
                length(one.amplitude_m),
                one.frequency_hz
            );
        }
        for line in measured(summary, answer.mode) {
            let _ = writeln!(out, "  {line}");
        }
        let _ = writeln!(out, "{}: {}", answer.verdict.words(), answer.reason);
    }
    out
}

/// How far a mode lies from each of its measured backbones.
fn measured(summary: &Summary, mode: usize) -> Vec<String> {
    let mut modes = summary.by_mode();
    let of_mode = modes.find(|(further, _)| further.unwrap_or(summary.first_mode()) == mode);
    let lines = |one: &MeasuredSummary| {
        let Some(misfit) = &one.misfit else {
            let range = [one.points.first(), one.points.last()].map(|point| point.map_or(f64::NAN, |p| p.amplitude));
            return format!(
                "against {}: no amplitude in common, it was measured from {}",
                one.name,
                range_of_lengths(range)
            );
        };
        let signed = |percent: f64| {
            format!(
                "{} % {}",
                digits(percent.abs()),
                if percent < 0.0 { "low" } else { "high" }
            )
        };
        let damping = misfit.damping_ln.map_or_else(String::new, |ln| {
            let [mean, rms] = [ln.mean, ln.rms].map(|ln| 100.0 * ln.exp_m1());
            format!(", damping {} (rms {} %)", signed(mean), digits(rms))
        });
        format!(
            "against {}, {}: frequency {} (rms {} %){damping}",
            one.name,
            range_of_lengths(misfit.amplitudes),
            signed(misfit.frequency_percent.mean),
            digits(misfit.frequency_percent.rms)
        )
    };
    of_mode.map_or_else(Vec::new, |(_, of)| of.measured.iter().map(lines).collect())
}

fn range_of_lengths(ends: [f64; 2]) -> String {
    range(ends, &length)
}

fn intervals_of_frequency(answer: &Answer) -> String {
    let by_numbers = answer
        .frequency_interval_hz
        .map(|ends| format!("{} by the numerical error", range(ends, &hertz)));
    let by_inputs = answer
        .frequency_band_hz
        .map(|ends| format!("{} by the uncertain inputs", range(ends, &hertz)));
    let known: Vec<String> = by_numbers.into_iter().chain(by_inputs).collect();
    if known.is_empty() {
        String::new()
    } else {
        format!(" ({})", known.join("; "))
    }
}

fn onset(answer: &Answer) -> String {
    match answer.onset_amplitude_m {
        Some(amplitude) => {
            let amplitude = length(amplitude);
            match answer.onset_interval_m {
                Some(ends) => {
                    let ends = range_of_lengths(ends);
                    format!("1 % of the contact slips from {amplitude} on ({ends} by the amplitudes computed)")
                }
                None => format!("1 % of the contact slips from the smallest amplitude, {amplitude}, on"),
            }
        }
        None if answer.damping.is_empty() => "no amplitudes were asked for".into(),
        None => "less than 1 % of the contact slips as a whole".into(),
    }
}

fn table(answer: &Answer) -> Table {
    let has_bands = answer
        .damping
        .iter()
        .any(|one| one.band.is_some() || one.frequency_band_hz.is_some());
    let mut headings = vec!["amplitude", "frequency (numerical error)", "damping (numerical error)"];
    if has_bands {
        headings.extend(["frequency by uncertain inputs", "damping by uncertain inputs"]);
    }
    let cell = |value: String, ends: Option<[f64; 2]>, of: &dyn Fn(f64) -> String| {
        ends.map_or_else(|| value.clone(), |ends| format!("{value} ({})", range(ends, of)))
    };
    let band = |ends: Option<[f64; 2]>, of: &dyn Fn(f64) -> String| {
        ends.map_or_else(|| MISSING.into(), |ends| range(ends, of))
    };
    let rows = answer.damping.iter().map(|one| {
        let ratio = one.ratio.map_or_else(|| MISSING.into(), percent);
        let mut row = vec![
            length(one.amplitude_m),
            cell(hertz(one.frequency_hz), one.frequency_interval_hz, &hertz),
            cell(ratio, one.interval, &percent),
        ];
        if has_bands {
            row.extend([band(one.frequency_band_hz, &hertz), band(one.band, &percent)]);
        }
        row
    });
    Table {
        headings: headings.into_iter().map(str::to_owned).collect(),
        rows: rows.collect(),
    }
}

fn range([low, high]: [f64; 2], of: &dyn Fn(f64) -> String) -> String {
    let (low, high) = (of(low), of(high));
    match low.split_once(' ') {
        Some((number, unit)) if high.ends_with(unit) => format!("{number} to {high}"),
        _ => format!("{low} to {high}"),
    }
}

fn hertz(frequency: f64) -> String {
    format!("{frequency:.2} Hz")
}

/// A damping ratio with two digits and more.
pub(crate) fn percent(ratio: f64) -> String {
    format!("{} %", digits(100.0 * ratio))
}

/// The unit that suits a length (m), and its number in a metre.
pub(crate) fn unit_of_length(length: f64) -> (&'static str, f64) {
    match length.abs() {
        size if size < 0.9995e-6 => ("nm", 1e9),
        size if size < 0.9995e-3 => ("um", 1e6),
        _ => ("mm", 1e3),
    }
}

/// A length in the unit that suits it.
pub(crate) fn length(length: f64) -> String {
    let (unit, scale) = unit_of_length(length);
    format!("{} {unit}", digits(scale * length))
}

/// Three digits, without zeros behind.
fn digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let decimals = (2.0 - value.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_a_unit_that_suits_them() {
        assert_eq!(length(1.0002e-6), "1 um");
        assert_eq!(length(0.99999e-3), "1 mm");
        assert_eq!(length(4.25e-4), "425 um");
        assert_eq!(length(2.6e-8), "26 nm");
        assert_eq!(percent(3.34e-3), "0.334 %");
        assert_eq!(percent(0.0), "0 %");
        assert_eq!(percent(1.2e-8), "1.20e-6 %");
        assert_eq!(range([0.01, 0.02], &percent), "1 to 2 %");
        assert_eq!(range([2.6e-8, 1e-6], &length), "26 nm to 1 um");
    }
}
