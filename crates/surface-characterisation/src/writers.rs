//! Height maps as files that [`crate::readers`] and other programs read, to the last bit: the same map gives the same
//! bytes, and reading them gives the same map.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use md5::{Digest, Md5};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::error::FileError;
use crate::topography::HeightMap;

/// X3P (ISO 25178-72): metres in double precision, missing points as NaN, checksums; without dates, which would differ.
///
/// # Errors
/// [`FileError::Layout`] if the archive cannot be made.
pub fn x3p(map: &HeightMap) -> Result<Vec<u8>, FileError> {
    let md5 = |bytes: &[u8]| -> String { Md5::digest(bytes).iter().map(|b| format!("{b:02x}")).collect() };
    let points = 0..map.nx() * map.ny();
    let data: Vec<u8> = points.flat_map(|k| map.value(k).to_le_bytes()).collect();
    let [dx, dy] = map.step();
    let [x0, y0] = map.origin();
    let main = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
      <CX>
        <AxisType>I</AxisType>
        <DataType>D</DataType>
        <Increment>{dx:e}</Increment>
        <Offset>{x0:e}</Offset>
      </CX>
      <CY>
        <AxisType>I</AxisType>
        <DataType>D</DataType>
        <Increment>{dy:e}</Increment>
        <Offset>{y0:e}</Offset>
      </CY>
      <CZ>
        <AxisType>A</AxisType>
        <DataType>D</DataType>
        <Increment>1</Increment>
        <Offset>0</Offset>
      </CZ>
    </Axes>
  </Record1>
  <Record3>
    <MatrixDimension>
      <SizeX>{}</SizeX>
      <SizeY>{}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
      <PointDataLink>bindata/data.bin</PointDataLink>
      <MD5ChecksumPointData>{}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"#,
        map.nx(),
        map.ny(),
        md5(&data),
    );
    let checksum = format!("{} *main.xml\n", md5(main.as_bytes()));
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |name: &str, bytes: &[u8]| -> zip::result::ZipResult<()> {
        // Stored, since the bytes of compressed members depend on the version of the compressor.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .large_file(bytes.len() > u32::MAX as usize);
        archive.start_file(name, options)?;
        Ok(archive.write_all(bytes)?)
    };
    let unwritable = |e: zip::result::ZipError| matrix_files::Error::Unwritable {
        name: "main.xml".into(),
        reason: e.to_string(),
        remedy: "write a smaller map",
    };
    add("main.xml", main.as_bytes())
        .and_then(|()| add("bindata/data.bin", &data))
        .and_then(|()| add("md5checksum.hex", checksum.as_bytes()))
        .map_err(unwritable)?;
    Ok(archive.finish().map_err(unwritable)?.into_inner())
}

/// Text with a line of heights per line of points along x, towards larger y, between commas: metres, with as many digits
/// as it takes to read the same numbers. Lines before them state units, steps and the position of the first point.
pub fn csv(map: &HeightMap) -> String {
    let [dx, dy] = map.step();
    let [x0, y0] = map.origin();
    let mut text =
        format!("# lateral_unit = m\n# height_unit = m\n# dx = {dx:e}\n# dy = {dy:e}\n# x0 = {x0:e}\n# y0 = {y0:e}\n");
    for j in 0..map.ny() {
        for i in 0..map.nx() {
            let z = map.value(j * map.nx() + i);
            let end = if i + 1 == map.nx() { '\n' } else { ',' };
            // Writing to a string cannot fail.
            let _ = if z.is_nan() {
                write!(text, "NaN{end}")
            } else {
                write!(text, "{z:e}{end}")
            };
        }
    }
    text
}
