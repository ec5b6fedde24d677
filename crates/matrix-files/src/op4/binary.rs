//! Records as Fortran writes them.

use super::stream::Stream;
use crate::Error;
use crate::columns::{Header, Position};
use crate::fortran::Records;
use file_io::{Place, Source};

pub(super) struct Binary<'a> {
    records: Records<'a>,
}

impl<'a> Binary<'a> {
    /// None if the file does not begin with the length of the head of a matrix, six words.
    pub(super) fn detect(source: Source<'a>) -> Option<Self> {
        Records::detect(source, 6).map(|records| Self { records })
    }
}

impl Position for Binary<'_> {
    fn file(&self) -> &str {
        self.records.file()
    }

    fn place(&self) -> Place {
        self.records.place()
    }
}

impl Stream for Binary<'_> {
    fn at(&self) -> usize {
        self.records.at
    }

    fn header(&mut self) -> Result<Option<Header>, Error> {
        let records = &mut self.records;
        if records.is_at_end() {
            return Ok(None);
        }
        let length = records.begin()?;
        if length != 6 * records.word {
            let expected = format!("the head of a matrix, of {} bytes", 6 * records.word);
            return Err(records.malformed(format!("a record of {length} bytes"), expected));
        }
        let mut numbers = [0; 4];
        for number in &mut numbers {
            *number = records.integer()?;
        }
        let header = records.head(numbers, records.rest())?;
        records.at = records.end;
        records.finish()?;
        Ok(Some(header))
    }

    fn column(&mut self) -> Result<[usize; 3], Error> {
        let length = self.records.begin()?;
        let [column, row, words] = self.string()?;
        if length / self.records.word != words.saturating_add(3) {
            let expected = format!("a record of three words more, not of {length} bytes");
            return Err(self.malformed(format!("{words} words in a column"), expected));
        }
        Ok([column, row, words])
    }

    fn string<const N: usize>(&mut self) -> Result<[usize; N], Error> {
        let mut integers = [0; N];
        for integer in &mut integers {
            let stated = self.records.integer()?;
            *integer = usize::try_from(stated).map_err(|_| self.malformed(stated, "no negative number"))?;
        }
        Ok(integers)
    }

    fn words(&self, is_double: bool, _is_dense: bool) -> usize {
        if is_double && self.records.word == 4 { 2 } else { 1 }
    }

    fn numbers(&mut self, count: usize, is_double: bool, values: &mut Vec<f64>) -> Result<(), Error> {
        self.records.numbers(count, is_double, values)
    }

    fn finish(&mut self) -> Result<(), Error> {
        self.records.finish()
    }
}
