//! The order in which a deck is read, and how names are resolved.

use super::keywords::{Fate, Phase, fate};
use super::text::{Block, Data, Source, excerpt};
use super::{Deck, DeckCoupling, Ignored, Label, Line, qualified};
use crate::error::{DeckProblem, Error};
use nalgebra::{Isometry3, Rotation3, Translation3, Unit, Vector3};
use std::collections::{HashMap, HashSet};

/// Number of set members, copies and the like that any deck may hold, and how many more per byte.
const MEMBERS: [usize; 2] = [1_000_000, 16];

/// A deck while it is read.
pub(super) struct Reader<'a> {
    pub(super) source: &'a Source,
    pub(super) deck: Deck,
    pub(super) nodes: HashMap<Label, u32>,
    pub(super) elements: HashMap<Label, u32>,
    /// Where each instance stands, and is defined.
    pub(super) frames: Vec<(Isometry3<f64>, Line)>,
    /// `SPRING1` and `DCOUP3D`: element label to node, and the line.
    pub(super) points: HashMap<Label, (Point, u32, Line)>,
    /// Those that a `*SPRING` or a coupling has taken up.
    pub(super) used_points: HashSet<Label>,
    /// Sets of those.
    pub(super) point_sets: HashMap<String, Vec<Label>>,
    /// Node sets that keep the order of the deck.
    pub(super) unsorted: HashSet<String>,
    /// A coupling whose kind is still to come.
    pub(super) open_coupling: Option<DeckCoupling>,
    pub(super) in_step: bool,
    /// Which load case of the step is open.
    pub(super) in_case: Option<usize>,
    assembly: String,
    members: usize,
}

/// An element of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Point {
    Spring,
    Coupling,
}

/// A block and the instance it speaks of.
struct Scoped<'a, 'b> {
    instance: u32,
    phase: Phase,
    block: &'b Block<'a>,
}

impl<'a> Reader<'a> {
    pub(super) fn run(source: &'a Source) -> Result<Deck, Error> {
        let mut reader = Self {
            source,
            deck: Deck {
                files: source.files.clone(),
                instances: vec![String::new()],
                ..Deck::default()
            },
            nodes: HashMap::new(),
            elements: HashMap::new(),
            frames: vec![(Isometry3::identity(), Line::default())],
            points: HashMap::new(),
            used_points: HashSet::new(),
            point_sets: HashMap::new(),
            unsorted: HashSet::new(),
            open_coupling: None,
            in_step: false,
            in_case: None,
            assembly: String::new(),
            members: 0,
        };
        let blocks = source.blocks()?;
        let mut scoped = reader.expand(&blocks)?;
        // Stable: within a phase the order of the deck is kept.
        scoped.sort_by_key(|scoped| scoped.phase);
        let mut system = (0, Isometry3::identity());
        for Scoped { instance, phase, block } in scoped {
            match phase {
                Phase::Geometry => {
                    if system.0 != instance {
                        system = (instance, Isometry3::identity());
                    }
                    reader.geometry(instance, &mut system.1, block)?;
                }
                Phase::Sets => reader.set(instance, block)?,
                Phase::Surfaces => reader.surface(instance, block)?,
                Phase::Materials => reader.material(block)?,
                Phase::Properties => reader.property(instance, block)?,
                Phase::Constraints => reader.constraint(instance, block)?,
                Phase::History => reader.history(block)?,
            }
        }
        reader.close_coupling()?;
        let idle = reader
            .points
            .iter()
            .filter(|(label, _)| !reader.used_points.contains(*label));
        if let Some((label, (.., line))) = idle.min_by_key(|(label, _)| **label) {
            let name = reader.deck.name(*label);
            let what = "*SPRING or *DISTRIBUTING COUPLING of element";
            return Err(reader.undefined(*line, what, &name));
        }
        Ok(reader.deck)
    }

    /// Sorts out keywords and repeats the blocks of parts for each of their instances.
    fn expand<'b>(&mut self, blocks: &'b [Block<'a>]) -> Result<Vec<Scoped<'a, 'b>>, Error> {
        let mut scoped = Vec::new();
        let mut parts: HashMap<String, (Line, usize, Vec<&'b Block<'a>>)> = HashMap::new();
        let mut part: Option<String> = None;
        let (mut assembly, mut instance, mut step): (Option<Line>, Option<Line>, Option<Line>) = (None, None, None);
        for block in blocks {
            let name = |parameter| block.required(self.source, parameter).map(str::to_ascii_uppercase);
            let most = match block.key.as_str() {
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
            };
            if let Some(line) = block.data.get(most) {
                return Err(self.error(
                    line.at,
                    DeckProblem::Syntax {
                        found: excerpt(line.text),
                        reason: "the keyword above takes no more data lines",
                    },
                ));
            }
            let outside = part.is_none() && instance.is_none() && step.is_none();
            match block.key.as_str() {
                "PART" if outside && assembly.is_none() => {
                    block.allow(self.source, &["NAME"])?;
                    let name = name("NAME")?;
                    if let Some((first, ..)) = parts.get(&name) {
                        return Err(self.duplicate(block.at, "part", name, *first));
                    }
                    parts.insert(name.clone(), (block.at, 0, Vec::new()));
                    part = Some(name);
                }
                "ENDPART" if part.is_some() => part = None,
                "ASSEMBLY" if outside && assembly.is_none() => {
                    block.allow(self.source, &["NAME"])?;
                    self.assembly = name("NAME")?;
                    assembly = Some(block.at);
                }
                "ENDASSEMBLY" if outside && assembly.is_some() => assembly = None,
                "INSTANCE" if outside && assembly.is_some() => {
                    block.allow(self.source, &["NAME", "PART"])?;
                    let of = name("PART")?;
                    let Some((_, uses, content)) = parts.get_mut(&of) else {
                        return Err(self.error(
                            block.at,
                            DeckProblem::Undefined {
                                what: "part",
                                name: excerpt(&of),
                            },
                        ));
                    };
                    *uses += 1;
                    let content = content.clone();
                    self.instance(name("NAME")?, block)?;
                    instance = Some(block.at);
                    for block in content {
                        self.sort_out(block, true, false, &mut scoped)?;
                    }
                }
                "ENDINSTANCE" if instance.is_some() => instance = None,
                "PART" | "ENDPART" | "ASSEMBLY" | "ENDASSEMBLY" | "INSTANCE" | "ENDINSTANCE" => {
                    return Err(self.misplaced(block));
                }
                _ => match &part {
                    Some(name) => {
                        if let Some((_, _, content)) = parts.get_mut(name) {
                            content.push(block);
                        }
                    }
                    None => {
                        match block.key.as_str() {
                            "STEP" if step.is_none() && outside && assembly.is_none() => step = Some(block.at),
                            "ENDSTEP" if step.is_some() => step = None,
                            "STEP" | "ENDSTEP" => return Err(self.misplaced(block)),
                            _ => {}
                        }
                        self.sort_out(block, instance.is_some(), step.is_some(), &mut scoped)?;
                    }
                },
            }
        }
        let open_part = part.and_then(|name| parts.get(&name).map(|(line, ..)| *line));
        for (open, keyword) in [
            (open_part, "PART"),
            (instance, "INSTANCE"),
            (assembly, "ASSEMBLY"),
            (step, "STEP"),
        ] {
            if let Some(line) = open {
                return Err(self.unclosed(line, keyword));
            }
        }
        let mut unused: Vec<_> = parts.iter().filter(|(_, (_, uses, _))| *uses == 0).collect();
        unused.sort_by_key(|(name, _)| *name);
        for (name, (line, ..)) in unused {
            let place = self.deck.place(*line);
            self.deck
                .notes
                .push(format!("part `{name}` ({place}) has no instance and is left out"));
        }
        Ok(scoped)
    }

    fn sort_out<'b>(
        &mut self,
        block: &'b Block<'a>,
        in_instance: bool,
        in_step: bool,
        scoped: &mut Vec<Scoped<'a, 'b>>,
    ) -> Result<(), Error> {
        self.spend(1 + block.data.len() * usize::from(in_instance), block.at)?;
        match fate(&block.key) {
            Fate::Refused(remedy) => Err(self.refused(block, remedy)),
            Fate::Ignored => {
                count(&mut self.deck.ignored, block);
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
        if let Some(first) = self.deck.instances.iter().position(|known| *known == name) {
            return Err(self.duplicate(block.at, "instance", name, self.frames[first].1));
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
        self.deck.instances.push(name);
        self.frames.push((frame, block.at));
        Ok(())
    }

    pub(super) fn vector(&self, line: &Data<'_>, what: &'static str, text: [&str; 3]) -> Result<Vector3<f64>, Error> {
        let mut vector = Vector3::zeros();
        for (value, text) in vector.iter_mut().zip(text) {
            *value = line.number(self.source, what, text)?;
        }
        Ok(vector)
    }

    /// Accounts for `count` members, so that short texts cannot fill the memory.
    pub(super) fn spend(&mut self, count: usize, at: Line) -> Result<(), Error> {
        let limit = MEMBERS[0] + MEMBERS[1] * self.source.size();
        self.members = self.members.saturating_add(count);
        if self.members > limit {
            return Err(self.error(at, DeckProblem::TooLarge { limit }));
        }
        Ok(())
    }

    pub(super) fn error(&self, at: Line, problem: DeckProblem) -> Error {
        self.source.error(at, problem)
    }

    pub(super) fn refused(&self, block: &Block<'_>, remedy: &'static str) -> Error {
        self.error(
            block.at,
            DeckProblem::Keyword {
                keyword: block.keyword.clone(),
                remedy,
            },
        )
    }

    fn misplaced(&self, block: &Block<'_>) -> Error {
        self.refused(
            block,
            "blocks may not cross, and are closed in the order they were opened; move it",
        )
    }

    fn unclosed(&self, line: Line, keyword: &str) -> Error {
        self.error(
            line,
            DeckProblem::Syntax {
                found: format!("*{keyword}"),
                reason: "the block is never closed by its *END line",
            },
        )
    }

    pub(super) fn duplicate(&self, at: Line, what: &'static str, name: String, first: Line) -> Error {
        let first = self.deck.place(first);
        self.error(at, DeckProblem::Duplicate { what, name, first })
    }

    /// Splits a label or set name of `instance` into an instance and the rest.
    pub(super) fn scope<'t>(&self, instance: u32, text: &'t str) -> (u32, &'t str) {
        let text = match (instance, text.split_once('.')) {
            (0, Some((first, rest))) if !self.assembly.is_empty() && first.eq_ignore_ascii_case(&self.assembly) => rest,
            _ => text,
        };
        if let (0, Some((first, rest))) = (instance, text.split_once('.')) {
            let found = self.deck.instances.iter().position(|i| i.eq_ignore_ascii_case(first));
            if let Some(found) = found.filter(|found| *found > 0) {
                return (found as u32, rest);
            }
        }
        (instance, text)
    }

    /// The qualified name of what `text` means in `instance`.
    pub(super) fn full_name(&self, instance: u32, text: &str) -> String {
        let (instance, rest) = self.scope(instance, text);
        qualified(&self.deck.instances[instance as usize], rest)
    }

    /// The instance of a block: the one it stands in, or its `INSTANCE` parameter.
    pub(super) fn instance_of(&self, instance: u32, block: &Block<'_>) -> Result<u32, Error> {
        let Some(name) = block.optional("INSTANCE") else {
            return Ok(instance);
        };
        let found = self.deck.instances.iter().position(|i| i.eq_ignore_ascii_case(name));
        match found.filter(|found| *found > 0) {
            Some(found) => Ok(found as u32),
            None => Err(self.error(
                block.at,
                DeckProblem::Undefined {
                    what: "instance",
                    name: excerpt(name),
                },
            )),
        }
    }

    /// The node with this label (or the nodes of this set), as `instance` names it.
    pub(super) fn node_list(&self, instance: u32, line: &Data<'_>, text: &str) -> Result<Vec<u32>, Error> {
        let (scope, rest) = self.scope(instance, text);
        if rest.starts_with(|c: char| c.is_ascii_digit()) && rest.bytes().all(|c| c.is_ascii_digit()) {
            let label = Label {
                instance: scope,
                number: line.label(self.source, "node", rest)?,
            };
            return Ok(vec![self.node(line.at, label)?]);
        }
        let name = self.full_name(instance, text);
        match self.deck.node_sets.get(&name) {
            Some(set) => Ok(set.clone()),
            None => Err(self.undefined(line.at, "node set", &name)),
        }
    }

    /// The one node that `text` names.
    pub(super) fn one_node(&self, instance: u32, line: &Data<'_>, text: &str) -> Result<u32, Error> {
        let nodes = self.node_list(instance, line, text)?;
        match nodes[..] {
            [node] => Ok(node),
            _ => Err(self.error(
                line.at,
                DeckProblem::Count {
                    what: format!("nodes of `{}`", excerpt(text)),
                    found: nodes.len(),
                    expected: 1,
                },
            )),
        }
    }

    pub(super) fn node(&self, at: Line, label: Label) -> Result<u32, Error> {
        let found = self.nodes.get(&label).copied();
        found.ok_or_else(|| self.undefined(at, "node", &self.deck.name(label)))
    }

    pub(super) fn undefined(&self, at: Line, what: &'static str, name: &str) -> Error {
        let name = excerpt(name);
        self.error(at, DeckProblem::Undefined { what, name })
    }
}

/// Counts a keyword that is not read.
pub(super) fn count(list: &mut Vec<Ignored>, block: &Block<'_>) {
    match list.iter_mut().find(|known| known.keyword == block.keyword) {
        Some(known) => known.count += 1,
        None => list.push(Ignored {
            keyword: block.keyword.clone(),
            count: 1,
            first_line: block.at,
        }),
    }
}
