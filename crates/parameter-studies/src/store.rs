//! Finished cases: append-only segments, each written by one process, in folders by structure.

use crate::Error;
use analyses::cases::{CaseMode, CasePoint};
use analyses::hyper_reduced::ErrorEstimate;
use analyses::variants::{FirstHarmonic, VariantPoint};
use file_io::durable::{Segment, read_segment, segments};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// What checksums of lines cover beside them; changes with the layout of lines.
const LINES: &str = "case-1";

/// Characters of the key of a structure that name its folder: at most 256 folders, however many structures there are.
const PREFIX: usize = 2;

/// What became of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time that it took on one thread (s).
    pub seconds: f64,
    /// Its modes, or why it has none.
    pub outcome: Result<Vec<CaseMode>, String>,
}

impl Record {
    /// Whether all amplitudes converged.
    pub fn is_converged(&self) -> bool {
        let modes = self.outcome.as_ref();
        modes.is_ok_and(|modes| modes.iter().flat_map(|mode| &mode.amplitudes).all(Result::is_ok))
    }

    /// Amplitudes that converged.
    fn converged(&self) -> usize {
        let modes = self.outcome.as_ref().map_or(&[][..], Vec::as_slice);
        let amplitudes = modes.iter().flat_map(|mode| &mode.amplitudes);
        amplitudes.filter(|found| found.is_ok()).count()
    }
}

/// A line of a segment.
#[derive(Serialize, Deserialize)]
struct Line {
    case: String,
    seconds: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    modes: Vec<StoredMode>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    failure: Option<String>,
}

#[derive(Serialize, Deserialize)]
struct StoredMode {
    mode: usize,
    linear_frequency_hz: Option<f64>,
    background: f64,
    points: Vec<StoredPoint>,
}

/// Modal amplitude, response displacement, frequency and damping ratio, then motion of the response, frequency and damping ratio of the first
/// harmonic; with few coordinates and points also the estimated errors of frequency and damping ratio; or why there are none. Without names, which would double the files.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum StoredPoint {
    Converged([Option<f64>; 7]),
    Estimated([Option<f64>; 9]),
    Failed(String),
}

impl Line {
    fn new(case: &str, record: &Record) -> Self {
        let point = |found: &Result<CasePoint, String>| match found {
            Ok(CasePoint { point, estimate }) => {
                let [q, x, f, damping] = [
                    Some(point.modal_amplitude),
                    Some(point.response_displacement),
                    Some(point.frequency_hz),
                    point.damping_ratio,
                ];
                let first_harmonic = point.first_harmonic;
                let [motion, seen_f, seen_damping] = [
                    Some(first_harmonic.response_motion),
                    Some(first_harmonic.frequency_hz),
                    first_harmonic.damping_ratio,
                ];
                match estimate {
                    None => StoredPoint::Converged([q, x, f, damping, motion, seen_f, seen_damping]),
                    Some(own) => {
                        let errors = [Some(own.frequency), own.damping];
                        StoredPoint::Estimated([q, x, f, damping, motion, seen_f, seen_damping, errors[0], errors[1]])
                    }
                }
            }
            Err(reason) => StoredPoint::Failed(reason.clone()),
        };
        let mode = |mode: &CaseMode| StoredMode {
            mode: mode.mode,
            linear_frequency_hz: Some(mode.linear_frequency_hz),
            background: mode.background,
            points: mode.amplitudes.iter().map(point).collect(),
        };
        Self {
            case: case.into(),
            seconds: record.seconds,
            modes: record.outcome.iter().flatten().map(mode).collect(),
            failure: record.outcome.as_ref().err().cloned(),
        }
    }

    fn record(self) -> Record {
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let found = |[q, x, f, damping_ratio, motion, seen_f, seen_damping]: [Option<f64>; 7], estimate| CasePoint {
            point: VariantPoint {
                modal_amplitude: number(q),
                response_displacement: number(x),
                frequency_hz: number(f),
                damping_ratio,
                first_harmonic: FirstHarmonic {
                    response_motion: number(motion),
                    frequency_hz: number(seen_f),
                    damping_ratio: seen_damping,
                },
            },
            estimate,
        };
        let point = |point: StoredPoint| match point {
            StoredPoint::Converged(numbers) => Ok(found(numbers, None)),
            StoredPoint::Estimated(
                [
                    q,
                    x,
                    f,
                    damping,
                    motion,
                    seen_f,
                    seen_damping,
                    frequency_error,
                    damping_error,
                ],
            ) => {
                let estimate = ErrorEstimate {
                    frequency: number(frequency_error),
                    damping: damping_error,
                };
                Ok(found([q, x, f, damping, motion, seen_f, seen_damping], Some(estimate)))
            }
            StoredPoint::Failed(reason) => Err(reason),
        };
        let mode = |mode: StoredMode| CaseMode {
            mode: mode.mode,
            linear_frequency_hz: number(mode.linear_frequency_hz),
            background: mode.background,
            amplitudes: mode.points.into_iter().map(point).collect(),
        };
        Record {
            seconds: self.seconds,
            outcome: match self.failure {
                Some(reason) => Err(reason),
                None => Ok(self.modes.into_iter().map(mode).collect()),
            },
        }
    }
}

/// The folder of a structure.
fn folder(root: &Path, structure: &str) -> PathBuf {
    root.join(structure.get(..PREFIX).unwrap_or(structure))
}

/// The finished cases of a study, read from all segments that may hold one.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    folders: BTreeSet<PathBuf>,
    wanted: HashSet<String>,
    /// Byte after the last line read of each segment.
    read: BTreeMap<PathBuf, u64>,
    records: HashMap<String, Record>,
    /// Lines read of cases that are wanted.
    lines: usize,
}

impl Store {
    pub(crate) fn open<'a>(
        root: &Path,
        structures: impl Iterator<Item = &'a String>,
        wanted: impl Iterator<Item = String>,
    ) -> Result<Self, Error> {
        let mut store = Self {
            root: root.to_owned(),
            folders: structures.map(|key| folder(root, key)).collect(),
            wanted: wanted.collect(),
            read: BTreeMap::new(),
            records: HashMap::new(),
            lines: 0,
        };
        store.refresh()?;
        Ok(store)
    }

    /// Reads what was appended since.
    ///
    /// # Errors
    /// [`Error::Store`].
    pub fn refresh(&mut self) -> Result<(), Error> {
        for folder in &self.folders {
            for path in segments(folder)? {
                let from = self.read.get(&path).copied().unwrap_or(0);
                let (wanted, records, lines) = (&self.wanted, &mut self.records, &mut self.lines);
                let next = read_segment(&path, LINES, from, &mut |line| {
                    let Ok(line) = serde_json::from_slice::<Line>(line) else {
                        return;
                    };
                    if !wanted.contains(&line.case) {
                        return;
                    }
                    *lines += 1;
                    let case = line.case.clone();
                    let record = line.record();
                    // One that was tried again counts if more of it converged. Else all are equal.
                    let is_better = |known: &Record| record.converged() > known.converged();
                    if records.get(&case).is_none_or(is_better) {
                        records.insert(case, record);
                    }
                })?;
                self.read.insert(path, next);
            }
        }
        Ok(())
    }

    /// Where it is.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// A finished case.
    pub fn get(&self, address: &str) -> Option<&Record> {
        self.records.get(address)
    }

    /// The finished cases.
    pub fn records(&self) -> impl Iterator<Item = &Record> {
        self.records.values()
    }

    /// Bytes of the segments, and how many there are.
    pub fn size(&self) -> (u64, usize) {
        (self.read.values().sum(), self.read.len())
    }

    /// Lines of cases that are wanted: as many as there are finished cases, unless some were run twice.
    pub fn lines(&self) -> usize {
        self.lines
    }
}

/// Writes the segments of this process: one at a time, in the folder of the structure under way.
pub(crate) struct Writer {
    root: PathBuf,
    open: Option<(PathBuf, Segment)>,
}

impl Writer {
    pub(crate) fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
            open: None,
        }
    }

    /// Appends a finished case; gives the bytes of its line.
    pub(crate) fn append(&mut self, structure: &str, case: &str, record: &Record) -> Result<usize, Error> {
        let json = serde_json::to_vec(&Line::new(case, record)).map_err(|source| Error::Encoding {
            case: case.into(),
            source,
        })?;
        let folder = folder(&self.root, structure);
        let segment = match &mut self.open {
            Some((own, segment)) if *own == folder => segment,
            open => {
                let segment = Segment::create(&folder)?;
                &mut open.insert((folder, segment)).1
            }
        };
        segment.append(LINES, &json)?;
        Ok(json.len())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use test_support::TemporaryFolder;

    fn record(points: &[Result<f64, &str>]) -> Record {
        let amplitude = |point: &Result<f64, &str>| match point {
            Ok(x) => Ok(CasePoint {
                point: VariantPoint {
                    modal_amplitude: 0.1 * x,
                    response_displacement: *x,
                    frequency_hz: 100.0 / 3.0,
                    damping_ratio: (*x > 1.0).then_some(0.1 + 0.2),
                    first_harmonic: FirstHarmonic {
                        response_motion: x / 3.0,
                        frequency_hz: 100.0 / 7.0,
                        damping_ratio: (*x > 1.0).then_some(0.1 + 0.7),
                    },
                },
                // With few coordinates: two amplitudes, one of them without damping.
                estimate: (*x < 2.5).then_some(ErrorEstimate {
                    frequency: 1e-5 / 3.0,
                    damping: (*x > 1.0).then_some(0.1 / 3.0),
                }),
            }),
            Err(reason) => Err((*reason).to_owned()),
        };
        Record {
            seconds: 0.25,
            outcome: Ok(vec![CaseMode {
                mode: 1,
                linear_frequency_hz: 33.3,
                background: 0.01,
                amplitudes: points.iter().map(amplitude).collect(),
            }]),
        }
    }

    #[test]
    fn finished_cases_are_read_back_bit_by_bit_and_the_better_of_two_counts() {
        let root = TemporaryFolder::new("cases-store");
        let keys = ["ab01".to_owned(), "cd02".to_owned()];
        let failed = Record {
            seconds: 1.5,
            outcome: Err("no\nequilibrium".into()),
        };
        let (whole, part) = (record(&[Ok(0.5), Ok(2.0), Ok(3.0)]), record(&[Ok(0.5), Err("stalled")]));
        let mut writer = Writer::new(&root);
        writer.append(&keys[0], "one", &whole).unwrap();
        writer.append(&keys[0], "two", &failed).unwrap();
        writer.append(&keys[1], "three", &part).unwrap();
        writer.append(&keys[1], "foreign", &part).unwrap();
        let wanted = || ["one", "two", "three", "four"].map(str::to_owned).into_iter();
        let mut store = Store::open(&root, keys.iter(), wanted()).unwrap();
        assert_eq!(store.get("one"), Some(&whole));
        assert_eq!(store.get("two"), Some(&failed));
        assert_eq!(store.get("three"), Some(&part));
        assert!(store.get("four").is_none() && store.get("foreign").is_none());
        assert!(whole.is_converged() && !part.is_converged() && !failed.is_converged());
        assert_eq!((store.lines(), store.size().1), (3, 2));
        // Another process tries again; a torn line of it is none.
        let mut other = Writer::new(&root);
        other
            .append(&keys[1], "three", &record(&[Ok(0.5), Ok(2.0), Ok(3.0)]))
            .unwrap();
        other.append(&keys[1], "one", &failed).unwrap();
        store.refresh().unwrap();
        assert_eq!(store.get("three"), Some(&whole));
        assert_eq!(store.get("one"), Some(&whole));
        // Folders of other structures are not read.
        let store = Store::open(&root, keys[..1].iter(), wanted()).unwrap();
        assert!(store.get("three").is_none() && store.get("one").is_some());
    }
}
