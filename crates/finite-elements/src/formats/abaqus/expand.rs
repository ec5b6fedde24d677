//! The blocks of a deck in the scope of their part, instance, assembly or step.

use super::deck::Line;
use super::keywords::{Extent, Fate, Phase, fate};
use super::reader::{Reader, count};
use super::text::{Block, excerpt};
use crate::error::{DeckProblem, Error};
use nalgebra::{Isometry3, Rotation3, Translation3, Unit};
use std::collections::HashMap;

/// A block and the instance it speaks of.
pub(super) struct Scoped<'a, 'b> {
    pub(super) instance: u32,
    pub(super) phase: Phase,
    pub(super) block: &'b Block<'a>,
}

/// A part: where it begins, how many instances it has, and its blocks.
type Part<'a, 'b> = (Line, usize, Vec<&'b Block<'a>>);

/// What is open while the blocks of a deck are gone through.
#[derive(Default)]
struct Scopes<'a, 'b> {
    parts: HashMap<String, Part<'a, 'b>>,
    part: Option<String>,
    assembly: Option<Line>,
    instance: Option<Line>,
    step: Option<Line>,
    scoped: Vec<Scoped<'a, 'b>>,
}

/// Sorts out keywords and repeats the blocks of parts for each of their instances.
pub(super) fn expand<'a, 'b>(reader: &mut Reader<'a>, blocks: &'b [Block<'a>]) -> Result<Vec<Scoped<'a, 'b>>, Error> {
    let mut scopes = Scopes::default();
    for block in blocks {
        if !reader.extent.leaves_out(&block.key)
            && let Some(line) = block.data.get(most_lines(&block.key))
        {
            return Err(reader.error(
                line.at,
                DeckProblem::Syntax {
                    found: excerpt(line.text),
                    reason: "the keyword above takes no more data lines",
                },
            ));
        }
        scopes.block(reader, block)?;
    }
    scopes.close(reader)
}

/// How many data lines a keyword takes, where this does not depend on its parameters.
fn most_lines(key: &str) -> usize {
    match key {
        "PART"
        | "ENDPART"
        | "ASSEMBLY"
        | "ENDASSEMBLY"
        | "ENDINSTANCE"
        | "MATERIAL"
        | "COUPLING"
        | "ENDSTEP"
        | "SUBSTRUCTURELOADCASE"
        | "LOADCASE"
        | "ENDLOADCASE" => 0,
        "SOLIDSECTION" => 1,
        "SYSTEM" | "INSTANCE" => 2,
        _ => usize::MAX,
    }
}

impl<'a, 'b> Scopes<'a, 'b> {
    fn block(&mut self, reader: &mut Reader<'a>, block: &'b Block<'a>) -> Result<(), Error> {
        let name = |parameter| block.required(reader.source, parameter).map(str::to_ascii_uppercase);
        let outside = self.part.is_none() && self.instance.is_none() && self.step.is_none();
        match block.key.as_str() {
            "PART" if outside && self.assembly.is_none() => {
                block.allow(reader.source, &["NAME"])?;
                let name = name("NAME")?;
                if let Some((first, ..)) = self.parts.get(&name) {
                    return Err(reader.duplicate(block.at, "part", name, *first));
                }
                self.parts.insert(name.clone(), (block.at, 0, Vec::new()));
                self.part = Some(name);
            }
            "ENDPART" if self.part.is_some() => self.part = None,
            "ASSEMBLY" if outside && self.assembly.is_none() => {
                block.allow(reader.source, &["NAME"])?;
                reader.assembly = name("NAME")?;
                self.assembly = Some(block.at);
            }
            "ENDASSEMBLY" if outside && self.assembly.is_some() => self.assembly = None,
            "INSTANCE" if outside && self.assembly.is_some() => self.instance(reader, block)?,
            "ENDINSTANCE" if self.instance.is_some() => self.instance = None,
            "PART" | "ENDPART" | "ASSEMBLY" | "ENDASSEMBLY" | "INSTANCE" | "ENDINSTANCE" => {
                return Err(reader.misplaced(block));
            }
            _ => match &self.part {
                Some(name) => {
                    if let Some((_, _, content)) = self.parts.get_mut(name) {
                        content.push(block);
                    }
                }
                None => {
                    match block.key.as_str() {
                        "STEP" if outside && self.assembly.is_none() => self.step = Some(block.at),
                        "ENDSTEP" if self.step.is_some() => self.step = None,
                        "STEP" | "ENDSTEP" => return Err(reader.misplaced(block)),
                        _ => {}
                    }
                    let (in_instance, in_step) = (self.instance.is_some(), self.step.is_some());
                    reader.sort_out(block, in_instance, in_step, &mut self.scoped)?;
                }
            },
        }
        Ok(())
    }

    /// Begins an instance with the blocks of its part.
    fn instance(&mut self, reader: &mut Reader<'a>, block: &'b Block<'a>) -> Result<(), Error> {
        block.allow(reader.source, &["NAME", "PART"])?;
        let of = block.required(reader.source, "PART")?.to_ascii_uppercase();
        let Some((_, uses, content)) = self.parts.get_mut(&of) else {
            return Err(reader.error(
                block.at,
                DeckProblem::Undefined {
                    what: "part",
                    name: excerpt(&of),
                },
            ));
        };
        *uses += 1;
        let name = block.required(reader.source, "NAME")?.to_ascii_uppercase();
        reader.instance(name, block)?;
        self.instance = Some(block.at);
        for block in content {
            reader.sort_out(block, true, false, &mut self.scoped)?;
        }
        Ok(())
    }

    /// Refuses what is still open, and notes the parts without instance.
    fn close(self, reader: &mut Reader<'a>) -> Result<Vec<Scoped<'a, 'b>>, Error> {
        let open_part = self.part.and_then(|name| self.parts.get(&name).map(|(line, ..)| *line));
        for (open, keyword) in [
            (open_part, "PART"),
            (self.instance, "INSTANCE"),
            (self.assembly, "ASSEMBLY"),
            (self.step, "STEP"),
        ] {
            if let Some(line) = open {
                return Err(reader.unclosed(line, keyword));
            }
        }
        let mut unused: Vec<_> = self.parts.iter().filter(|(_, (_, uses, _))| *uses == 0).collect();
        unused.sort_by_key(|(name, _)| *name);
        for (name, (line, ..)) in unused {
            let place = reader.deck.place(*line);
            let note = format!("part `{name}` ({place}) has no instance and is left out");
            reader.deck.notes.push(note);
        }
        Ok(self.scoped)
    }
}

impl<'a> Reader<'a> {
    fn sort_out<'b>(
        &mut self,
        block: &'b Block<'a>,
        in_instance: bool,
        in_step: bool,
        scoped: &mut Vec<Scoped<'a, 'b>>,
    ) -> Result<(), Error> {
        self.spend(1 + block.data.len() * usize::from(in_instance), block.at)?;
        if self.extent.leaves_out(&block.key) || (self.extent == Extent::Mesh && in_step) {
            match fate(&block.key) {
                Fate::Ignored => count(&mut self.deck.ignored, block),
                _ if block.key.starts_with("END") => {}
                _ => count(&mut self.left_out, block),
            }
            return Ok(());
        }
        match fate(&block.key) {
            Fate::Refused(remedy) => Err(self.refused(block, remedy)),
            Fate::Ignored => {
                count(&mut self.deck.ignored, block);
                Ok(())
            }
            Fate::Replaced(by) => {
                let is_first = self.deck.ignored.iter().all(|ignored| ignored.keyword != block.keyword);
                count(&mut self.deck.ignored, block);
                if is_first {
                    self.deck.notes.push(format!("*{} does not act: {by}", block.keyword));
                }
                Ok(())
            }
            Fate::Procedure if in_step => {
                scoped.push(Scoped {
                    instance: 0,
                    phase: Phase::History,
                    block,
                });
                Ok(())
            }
            Fate::Procedure => Err(self.refused(block, "move it into a *STEP")),
            Fate::Read(phase) => {
                if in_step && phase != Phase::History {
                    return Err(self.refused(block, "move it before the first *STEP"));
                }
                if in_instance && matches!(phase, Phase::History | Phase::Materials) {
                    return Err(self.refused(block, "move it behind *END ASSEMBLY"));
                }
                let instance = if in_instance { self.frames.len() as u32 - 1 } else { 0 };
                scoped.push(Scoped { instance, phase, block });
                Ok(())
            }
        }
    }

    /// Adds an instance: moved by the first data line, then turned about the axis of the second.
    fn instance(&mut self, name: String, block: &Block<'_>) -> Result<(), Error> {
        if let Some(first) = self.instance_named(&name) {
            return Err(self.duplicate(block.at, "instance", name, self.frames[first as usize].1));
        }
        let mut frame = Isometry3::identity();
        let mut lines = block.data.iter();
        if let Some(line) = lines.next() {
            let [x, y, z] = line.columns::<3>(self.source)?;
            frame.translation = Translation3::from(self.vector(line, "translation", [x, y, z])?);
        }
        if let Some(line) = lines.next() {
            let [ax, ay, az, bx, by, bz, angle] = line.columns::<7>(self.source)?;
            let a = self.vector(line, "axis of rotation", [ax, ay, az])?;
            let b = self.vector(line, "axis of rotation", [bx, by, bz])?;
            let angle = line.number(self.source, "angle of rotation", angle)?;
            let axis = Unit::try_new(b - a, 0.0)
                .ok_or_else(|| line.invalid(self.source, "axis of rotation", line.text, "two different points"))?;
            let turn = Rotation3::from_axis_angle(&axis, angle.to_radians());
            let about = Isometry3::from_parts(Translation3::from(a - turn * a), turn.into());
            frame = about * frame;
        }
        self.add_instance(name, frame, block.at);
        Ok(())
    }
}
