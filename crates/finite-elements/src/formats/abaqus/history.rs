//! Supports, loads and steps.

use super::deck::{LoadCase, Step};
use super::keywords::{Fate, fate};
use super::reader::{Reader, count};
use super::text::{Block, Data, excerpt};
use crate::error::{DeckProblem, Error};

impl Reader<'_> {
    /// Steps are closed in the order they were opened; that is known by now.
    pub(super) fn history(&mut self, block: &Block<'_>) -> Result<(), Error> {
        if let Fate::Procedure = fate(&block.key) {
            if let Some(step) = self.deck.steps.last_mut() {
                count(&mut step.procedures, block);
            }
            return Ok(());
        }
        match block.key.as_str() {
            "STEP" => self.step(block),
            "ENDSTEP" => {
                self.in_step = false;
                self.in_case = None;
                Ok(())
            }
            "SUBSTRUCTURELOADCASE" | "LOADCASE" => self.case(block),
            "ENDLOADCASE" => {
                self.in_case = None;
                Ok(())
            }
            "CLOAD" => self.loads(block),
            _ => self.supports(block),
        }
    }

    fn step(&mut self, block: &Block<'_>) -> Result<(), Error> {
        block.allow(
            self.source,
            &[
                "NAME",
                "NLGEOM",
                "PERTURBATION",
                "INC",
                "UNSYMM",
                "AMPLITUDE",
                "EXTRAPOLATION",
            ],
        )?;
        let name = match block.optional("NAME") {
            Some(name) if !name.is_empty() => name.to_owned(),
            _ => format!("Step-{}", self.deck.steps.len() + 1),
        };
        if let Some(known) = self
            .deck
            .steps
            .iter()
            .find(|step| step.name.eq_ignore_ascii_case(&name))
        {
            return Err(self.duplicate(block.at, "step", name, known.line));
        }
        self.in_step = true;
        self.deck.steps.push(Step {
            name,
            procedures: Vec::new(),
            supports: Default::default(),
            cases: Vec::new(),
            line: block.at,
        });
        Ok(())
    }

    fn case(&mut self, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["NAME"])?;
        let name = block.required(self.source, "NAME")?;
        let Some(step) = self.deck.steps.last_mut().filter(|_| self.in_step) else {
            return Err(self.refused(block, "move it into a *STEP"));
        };
        let matches = |case: &LoadCase| {
            case.name
                .as_deref()
                .is_some_and(|known| known.eq_ignore_ascii_case(name))
        };
        if step.cases.iter().any(matches) {
            let line = step.line;
            return Err(self.duplicate(block.at, "load case", excerpt(name), line));
        }
        step.cases.push(LoadCase {
            name: Some(name.to_owned()),
            loads: Default::default(),
        });
        self.in_case = Some(step.cases.len() - 1);
        Ok(())
    }

    fn loads(&mut self, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["OP"])?;
        block.choice(self.source, "OP", &["MOD", "NEW"])?;
        if !self.in_step {
            return Err(self.refused(block, "move it into a *STEP"));
        }
        let mut loads = Vec::new();
        for line in &block.data {
            let [of, component, value] = line.columns::<3>(self.source)?;
            let nodes = self.node_list(0, line, of)?;
            let component = self.component(line, component)?;
            let value = line.number(self.source, "load", value)?;
            self.spend(nodes.len(), line.at)?;
            loads.extend(nodes.into_iter().map(|node| ((node, component), (value, line.at))));
        }
        let in_case = self.in_case;
        let Some(step) = self.deck.steps.last_mut() else {
            return Ok(());
        };
        let at = in_case.unwrap_or_else(|| {
            let own = step.cases.iter().position(|case| case.name.is_none());
            own.unwrap_or_else(|| {
                step.cases.push(LoadCase {
                    name: None,
                    loads: Default::default(),
                });
                step.cases.len() - 1
            })
        });
        for ((node, component), (value, line)) in loads {
            // Whether a second value adds to the first or replaces it depends on the code that reads the deck.
            if let Some((_, first)) = step.cases[at].loads.insert((node, component), (value, line)) {
                let name = format!("component {} of node {}", component + 1, self.deck.node_name(node));
                return Err(self.duplicate(line, "load on", name, first));
            }
        }
        Ok(())
    }

    fn supports(&mut self, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["OP", "TYPE"])?;
        block.choice(self.source, "OP", &["MOD", "NEW"])?;
        block.choice(self.source, "TYPE", &["DISPLACEMENT"])?;
        for line in &block.data {
            let [of, first, last, value] = line.columns::<4>(self.source)?;
            let nodes = self.node_list(0, line, of)?;
            if line.number(self.source, "prescribed motion", value)? != 0.0 {
                return Err(line.invalid(self.source, "prescribed motion", value, "zero; use loads instead"));
            }
            let components = match first.to_ascii_uppercase().as_str() {
                "ENCASTRE" => vec![0, 1, 2, 3, 4, 5],
                "PINNED" => vec![0, 1, 2],
                "XSYMM" => vec![0, 4, 5],
                "YSYMM" => vec![1, 3, 5],
                "ZSYMM" => vec![2, 3, 4],
                "XASYMM" => vec![1, 2, 3],
                "YASYMM" => vec![0, 2, 4],
                "ZASYMM" => vec![0, 1, 5],
                name if name.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    return Err(self.named_support(line, first));
                }
                _ => {
                    let (first, last) = self.component_range(line, first, last)?;
                    (first..=last).collect()
                }
            };
            self.spend(nodes.len() * components.len(), line.at)?;
            let supports = match self.deck.steps.last_mut().filter(|_| self.in_step) {
                Some(step) => &mut step.supports,
                None => &mut self.deck.supports,
            };
            for node in nodes {
                for &component in &components {
                    supports.entry((node, component)).or_insert(line.at);
                }
            }
        }
        Ok(())
    }

    fn named_support(&self, line: &Data<'_>, found: &str) -> Error {
        self.error(
            line.at,
            DeckProblem::Value {
                what: "type of support",
                found: excerpt(found),
                requirement: "components 1-6, ENCASTRE, PINNED, XSYMM, YSYMM, ZSYMM, XASYMM, YASYMM or ZASYMM",
            },
        )
    }
}
