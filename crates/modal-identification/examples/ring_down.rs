//! A ring-down as text, read and identified.
#![expect(clippy::print_stdout, reason = "it is what the example shows")]

use modal_identification::backbone::{Settings, identify};
use modal_identification::readers;
use modal_identification::signal::{Signal, Stated};
use modal_identification::synthetic::RingDown;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hit = RingDown {
        amplitude: 40.0,
        phase: 0.0,
        frequency: |a: f64| 180.0 - 0.05 * a,
        damping_ratio: |a: f64| 0.001 + 2e-4 * a,
    };
    let mut text = String::from("time [s],acc [m/s^2]\n");
    for (i, a) in hit.samples(4096.0, 12_000).iter().enumerate() {
        text += &format!("{:.8},{a:.6}\n", i as f64 / 4096.0);
    }
    let source = file_io::Source {
        name: "hit.csv",
        bytes: text.as_bytes(),
    };

    let recording = readers::parse(source)?;
    let (channels, _) = recording.select(Some("acc"))?;
    let (signal, _) = Signal::try_new(&recording.file, channels[0], &Stated::default())?;
    let found = identify(&signal, &Settings::default())?;
    println!("mode at {:.2} Hz", found.peak_hz);
    for p in found.backbone.iter().step_by(100) {
        let percent = 100.0 * p.damping_ratio;
        println!("{:8.4} m/s^2  {:.3} Hz  {percent:.3} %", p.amplitude, p.frequency_hz);
    }
    Ok(())
}
