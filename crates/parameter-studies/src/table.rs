//! The table of a study: one row per case, mode and amplitude, in the order of the plan, as CSV; as Parquet by a module of its own.

use crate::Error;
use crate::design::Kind;
use crate::store::Store;
use crate::study::Study;
use analyses::cases::CasePoint;
use analyses::hyper_reduced::ErrorEstimate;
use analyses::variants::VariantPoint;
use reports::csv::number;
use serde_json::Value;
use std::sync::Arc;

/// Name of the table as comma-separated values.
pub const CSV: &str = "results.csv";

/// Name of the table as Parquet.
pub const PARQUET: &str = "results.parquet";

/// A table, column by column.
pub(crate) struct Table {
    pub(super) columns: Vec<Column>,
}

pub(super) struct Column {
    pub(super) name: String,
    /// Whether every row has a value.
    pub(super) required: bool,
    pub(super) data: Data,
}

pub(super) enum Data {
    Text(Vec<Option<Arc<str>>>),
    Real(Vec<Option<f64>>),
    Whole(Vec<Option<i32>>),
}

/// A row apart from its case and parameters.
#[derive(Default)]
struct Row {
    mode: Option<i32>,
    point: Option<CasePoint>,
    status: &'static str,
    reason: Option<Arc<str>>,
}

/// The rows of a case.
fn rows(store: &Store, address: &str) -> Vec<Row> {
    let failed = |reason: &str| Row {
        status: "failed",
        reason: Some(reason.into()),
        ..Row::default()
    };
    let modes = match store.get(address).map(|record| &record.outcome) {
        None => return vec![failed("it was not run")],
        Some(Err(reason)) => return vec![failed(reason)],
        Some(Ok(modes)) => modes,
    };
    let mut rows = Vec::new();
    for mode in modes {
        let number = Some(mode.mode as i32);
        for (index, amplitude) in mode.amplitudes.iter().enumerate() {
            rows.push(match amplitude {
                Ok(point) => Row {
                    mode: number,
                    point: Some(*point),
                    status: "converged",
                    reason: point
                        .point
                        .damping_ratio
                        .is_none()
                        .then(|| "damping is below its floor".into()),
                },
                Err(reason) => Row {
                    mode: number,
                    status: "not-converged",
                    reason: Some(format!("amplitude {}: {reason}", index + 1).into()),
                    ..Row::default()
                },
            });
        }
    }
    rows
}

impl Table {
    pub(crate) fn new(study: &Study<'_>, store: &Store) -> Self {
        let mut addresses = Vec::new();
        let mut parameters: Vec<Data> = study
            .columns()
            .iter()
            .map(|column| match column.kind {
                Kind::Text => Data::Text(Vec::new()),
                Kind::Number | Kind::Quantity(_) => Data::Real(Vec::new()),
            })
            .collect();
        let mut found: Vec<Row> = Vec::new();
        for (number, index) in study.of_plan.iter().enumerate() {
            let Some(case) = study.cases.get(*index) else { continue };
            let address: Arc<str> = case.address.as_str().into();
            let own = rows(store, &case.address);
            addresses.extend(own.iter().map(|_| Some(address.clone())));
            let values = study.design.values(number);
            for ((column, data), value) in study.columns().iter().zip(&mut parameters).zip(values) {
                match data {
                    Data::Real(data) => {
                        let number = value.and_then(|value| column.number(value));
                        data.extend(own.iter().map(|_| number));
                    }
                    Data::Text(data) => {
                        let text: Option<Arc<str>> = value.map(|value| match value {
                            Value::String(text) => text.as_str().into(),
                            other => other.to_string().into(),
                        });
                        data.extend(own.iter().map(|_| text.clone()));
                    }
                    Data::Whole(_) => {}
                }
            }
            found.extend(own);
        }
        let column = |name: &str, required: bool, data: Data| Column {
            name: name.into(),
            required,
            data,
        };
        let real = |of: fn(&VariantPoint) -> Option<f64>| {
            let value = |row: &Row| of(&row.point.as_ref()?.point);
            Data::Real(found.iter().map(value).collect())
        };
        let error = |of: fn(&ErrorEstimate) -> Option<f64>| {
            let value = |row: &Row| of(row.point.as_ref()?.estimate.as_ref()?);
            Data::Real(found.iter().map(value).collect())
        };
        let mut columns = vec![column("case", true, Data::Text(addresses))];
        for (parameter, data) in study.columns().iter().zip(parameters) {
            columns.push(column(&parameter.heading(), false, data));
        }
        columns.extend([
            column("mode", false, Data::Whole(found.iter().map(|row| row.mode).collect())),
            column("modal_amplitude", false, real(|at| Some(at.modal_amplitude))),
            column(
                "response_displacement",
                false,
                real(|at| Some(at.response_displacement)),
            ),
            column("frequency_hz", false, real(|at| Some(at.frequency_hz))),
            column("damping_ratio", false, real(|at| at.damping_ratio)),
            column(
                "response_motion",
                false,
                real(|at| Some(at.first_harmonic.response_motion)),
            ),
            column(
                "frequency_first_harmonic_hz",
                false,
                real(|at| Some(at.first_harmonic.frequency_hz)),
            ),
            column(
                "damping_ratio_first_harmonic",
                false,
                real(|at| at.first_harmonic.damping_ratio),
            ),
            column(
                "status",
                true,
                Data::Text(found.iter().map(|row| Some(row.status.into())).collect()),
            ),
            column(
                "reason",
                false,
                Data::Text(found.iter().map(|row| row.reason.clone()).collect()),
            ),
        ]);
        if study.plan.hyper_reduction.is_some() {
            columns.extend([
                column("frequency_error", false, error(|own| Some(own.frequency))),
                column("damping_ratio_error", false, error(|own| own.damping)),
            ]);
        }
        Self { columns }
    }

    pub(crate) fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| match &column.data {
            Data::Text(data) => data.len(),
            Data::Real(data) => data.len(),
            Data::Whole(data) => data.len(),
        })
    }

    /// As comma-separated values; a value that is not there is an empty cell.
    pub(crate) fn csv(&self) -> Result<Vec<u8>, Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns.iter().map(|column| &column.name))?;
        for row in 0..self.len() {
            let cell = |column: &Column| match &column.data {
                Data::Text(data) => data.get(row).cloned().flatten().map(|text| text.to_string()),
                Data::Real(data) => data.get(row).copied().flatten().map(number),
                Data::Whole(data) => data.get(row).copied().flatten().map(|whole| whole.to_string()),
            };
            writer.write_record(self.columns.iter().map(|column| cell(column).unwrap_or_default()))?;
        }
        writer.into_inner().map_err(|error| {
            let source = std::io::Error::other(error.to_string());
            Error::Table(csv::Error::from(source))
        })
    }
}
