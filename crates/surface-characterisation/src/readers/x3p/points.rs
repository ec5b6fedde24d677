//! The points: numbers in the document or in a binary member, and which of them are valid.

use std::ops::Range;

use file_io::Place;

use super::axes::{Axis, DataType};
use super::document::{Document, MAIN};
use super::members::{Members, plain};
use crate::error::FileError;
use crate::readers::bytes::{malformed, oversized};
use crate::readers::grid::{Gridded, grid};

/// How many points the document states.
pub(super) struct Extent {
    /// Along x and along y, and layers.
    size: [u64; 3],
    /// Where it states them, for messages.
    at: usize,
    /// A matrix of points rather than a list.
    is_matrix: bool,
}

impl Extent {
    pub(super) fn read(document: &Document<'_>) -> Result<Self, FileError> {
        const LIST: &str = "Record3/ListDimension";
        if document.text(LIST).is_some() {
            return Ok(Self {
                size: [document.count(LIST)?, 1, 1],
                at: document.at(LIST),
                is_matrix: false,
            });
        }
        let count = |axis: &str| document.count(&format!("Record3/MatrixDimension/{axis}"));
        Ok(Self {
            size: [count("SizeX")?, count("SizeY")?, count("SizeZ")?],
            at: document.at("Record3/MatrixDimension/SizeX"),
            is_matrix: true,
        })
    }
}

/// The numbers of all points.
pub(super) struct Points<'a> {
    document: &'a Document<'a>,
    /// Types of the coordinates that are given for each point.
    columns: Vec<DataType>,
    /// The binary member with the numbers, unless the document lists them.
    linked: Option<Vec<u8>>,
    /// Name and contents of the member with a bit per point.
    valid: Option<(&'a str, Vec<u8>)>,
    /// Where the numbers stand, for messages.
    part: String,
    /// Numbers per point, bytes if linked.
    width: usize,
}

impl<'a> Points<'a> {
    pub(super) fn read(
        document: &'a Document<'a>,
        axes: &[Axis; 3],
        members: &mut Members<'_>,
        notes: &mut Vec<String>,
    ) -> Result<Self, FileError> {
        let columns: Vec<DataType> = axes.iter().filter_map(|axis| axis.data).collect();
        if let Some(link) = document.text("Record3/DataLink/PointDataLink") {
            let stated = document.text("Record3/DataLink/MD5ChecksumPointData");
            let data = members.linked(link, stated, notes)?;
            let valid = match document.text("Record3/DataLink/ValidPointsLink") {
                Some(link) => {
                    let stated = document.text("Record3/DataLink/MD5ChecksumValidPoints");
                    Some((link, members.linked(link, stated, notes)?))
                }
                None => None,
            };
            return Ok(Self {
                document,
                width: columns.iter().map(|d| d.width()).sum(),
                columns,
                linked: Some(data),
                valid,
                part: plain(link),
            });
        }
        if document.listed.is_none() {
            return Err(document.malformed(0, "no points", "`DataLink` or `DataList` in `Record3`"));
        }
        Ok(Self {
            document,
            width: columns.len(),
            columns,
            linked: None,
            valid: None,
            part: MAIN.into(),
        })
    }

    /// Size of the grid or list, and the numbers of its points, for the layer asked for; checks that the data are those of
    /// as many points as stated.
    pub(super) fn layer(
        &self,
        extent: &Extent,
        wanted: Option<usize>,
    ) -> Result<([usize; 2], Range<usize>), FileError> {
        let file = self.document.file;
        let [nx, ny, layers] = extent.size;
        let stated = u128::from(nx).saturating_mul(ny.into()).saturating_mul(layers.into());
        let held = self.linked.as_ref().map_or(self.document.datums.len(), Vec::len);
        let possible = held / self.width;
        if stated > possible as u128 {
            return Err(oversized(
                file,
                Document::place(extent.at),
                "the number of points",
                stated,
                possible,
            ));
        }
        if stated * self.width as u128 != held as u128 {
            return Err(malformed(
                file,
                self.place(stated as usize),
                format!("data of {possible} points or more"),
                format!("{stated} points"),
            ));
        }
        let [nx, ny, layers] = [nx as usize, ny as usize, layers as usize];
        let layer = match (layers, wanted) {
            (1, None) => 0,
            (_, Some(layer)) if layer < layers => layer,
            _ => {
                return Err(FileError::Choice {
                    file: file.into(),
                    found: format!("{layers} layers, numbered from 0"),
                    option: "layer",
                });
            }
        };
        let per_layer = nx * ny;
        self.check_valid(per_layer * layers)?;
        Ok(([nx, ny], layer * per_layer..(layer + 1) * per_layer))
    }

    /// Where the numbers of point `k` stand.
    fn place(&self, k: usize) -> Place {
        Place::Inside {
            part: format!("`{}`", self.part.escape_debug()),
            byte: if self.linked.is_none() { 0 } else { k * self.width },
        }
    }

    /// Checks that there is a bit for each of `count` points.
    fn check_valid(&self, count: usize) -> Result<(), FileError> {
        let Some((link, bits)) = &self.valid else {
            return Ok(());
        };
        let expected = count.div_ceil(8);
        if bits.len() == expected {
            return Ok(());
        }
        let place = Place::Inside {
            part: format!("`{}`", link.escape_debug()),
            byte: bits.len().min(expected),
        };
        Err(malformed(
            self.document.file,
            place,
            format!("{} bytes", bits.len()),
            format!("{expected}, a bit per point"),
        ))
    }

    fn is_valid(&self, k: usize) -> bool {
        self.valid
            .as_ref()
            .is_none_or(|(_, bits)| bits[k / 8] >> (k % 8) & 1 == 1)
    }

    /// Coordinate `column` of those given for each point.
    fn number(&self, k: usize, column: usize) -> f64 {
        let Some(data) = &self.linked else {
            return self.document.datums[k * self.width + column];
        };
        let skipped: usize = self.columns[..column].iter().map(|d| d.width()).sum();
        let bytes = data.get(k * self.width + skipped..).unwrap_or_default();
        self.columns[column].number(bytes).unwrap_or(f64::NAN)
    }

    /// Height of point `k` (m), NaN if missing.
    fn height(&self, k: usize, z: &Axis) -> f64 {
        if self.is_valid(k) {
            z.metres(self.number(k, self.columns.len() - 1))
        } else {
            f64::NAN
        }
    }

    /// The grid of the points in `layer`, `size` of them along x and y.
    pub(super) fn grid(
        &self,
        extent: &Extent,
        axes: &[Axis; 3],
        size: [usize; 2],
        layer: Range<usize>,
    ) -> Result<Gridded, FileError> {
        let [x, y, z] = axes;
        match (x.data, y.data) {
            (None, None) if extent.is_matrix => Ok(Gridded {
                size,
                step: [x.increment, y.increment],
                origin: [x.offset, y.offset],
                heights: layer.map(|k| self.height(k, z)).collect(),
                deviation: 0.0,
            }),
            (along_x, along_y) if extent.is_matrix || along_x.is_some() && along_y.is_some() => {
                self.scattered(axes, size[0], layer)
            }
            _ => {
                let found = "a list of points with an incremental axis";
                Err(self.document.malformed(extent.at, found, "absolute axes, or a matrix"))
            }
        }
    }

    /// The grid of points with positions of their own, `nx` of them per line where they are counted.
    fn scattered(&self, axes: &[Axis; 3], nx: usize, layer: Range<usize>) -> Result<Gridded, FileError> {
        let first = layer.start;
        let (mut numbers, mut points) = (Vec::with_capacity(layer.len()), Vec::with_capacity(layer.len()));
        for k in layer {
            let index = [(k - first) % nx, (k - first) / nx];
            let mut point = [0.0, 0.0, self.height(k, &axes[2])];
            let mut column = 0;
            for q in 0..2 {
                point[q] = if axes[q].data.is_some() {
                    column += 1;
                    axes[q].metres(self.number(k, column - 1))
                } else {
                    axes[q].metres(index[q] as f64)
                };
            }
            if self.is_valid(k) && point[0].is_finite() && point[1].is_finite() {
                numbers.push(k);
                points.push(point);
            }
        }
        grid(self.document.file, &points, |index| {
            self.place(numbers.get(index).copied().unwrap_or(0))
        })
    }
}
