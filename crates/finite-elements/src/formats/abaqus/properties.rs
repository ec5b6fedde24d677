//! Materials, sections, springs and point masses.

use super::deck::{DeckMass, DeckMaterial, DeckSpring, Label};
use super::reader::{Point, Reader};
use super::text::{Block, excerpt};
use crate::error::{DeckProblem, Error};

impl Reader<'_> {
    pub(super) fn property(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        match block.key.as_str() {
            "SPRING" => self.spring(instance, block),
            "MASS" => self.mass(instance, block),
            "ROTARYINERTIA" => self.rotary_inertia(instance, block),
            "BEAMSECTION" => self.beam_section(instance, block),
            _ => self.section(instance, block),
        }
    }

    pub(super) fn material(&mut self, block: &Block<'_>) -> Result<(), Error> {
        if block.key != "MATERIAL" {
            return self.constants(block);
        }
        block.allow(self.source, &["NAME"])?;
        let name = block.required(self.source, "NAME")?;
        let known = self.deck.materials.iter().find(|m| m.name.eq_ignore_ascii_case(name));
        if let Some(known) = known {
            return Err(self.duplicate(block.at, "material", excerpt(name), known.line));
        }
        self.deck.materials.push(DeckMaterial {
            name: name.to_owned(),
            elastic: None,
            density: None,
            line: block.at,
        });
        Ok(())
    }

    /// `*ELASTIC` or `*DENSITY`, at one temperature.
    fn constants(&mut self, block: &Block<'_>) -> Result<(), Error> {
        let elastic = block.key == "ELASTIC";
        if elastic {
            block.allow(self.source, &["TYPE"])?;
            block.choice(self.source, "TYPE", &["ISOTROPIC", "ISO"])?;
        } else {
            block.allow(self.source, &[])?;
        }
        let [line] = block.data[..] else {
            return Err(self.error(
                block.at,
                DeckProblem::Count {
                    what: format!("data lines of *{} (one temperature)", block.keyword),
                    found: block.data.len(),
                    expected: 1,
                },
            ));
        };
        let columns = line.columns::<3>(self.source)?;
        let mut values = [0.0; 3];
        for (value, text) in values.iter_mut().zip(columns) {
            *value = line.number(self.source, "material constant", text)?;
        }
        let keyword = block.keyword.clone();
        let place = block.at;
        let Some(material) = self.deck.materials.last_mut() else {
            return Err(self.refused(block, "move it below its *MATERIAL"));
        };
        let again = if elastic {
            material.elastic.replace([values[0], values[1]]).is_some()
        } else {
            material.density.replace(values[0]).is_some()
        };
        if again {
            let (name, first) = (format!("{keyword} of {}", excerpt(&material.name)), material.line);
            return Err(self.duplicate(place, "material constant", name, first));
        }
        Ok(())
    }

    /// Index of the material that a section names.
    pub(super) fn material_index(&self, block: &Block<'_>) -> Result<u16, Error> {
        let name = block.required(self.source, "MATERIAL")?;
        let found = self
            .deck
            .materials
            .iter()
            .position(|m| m.name.eq_ignore_ascii_case(name));
        let Some(material) = found else {
            return Err(self.undefined(block.at, "material", name));
        };
        u16::try_from(material).map_err(|_| {
            self.error(
                block.at,
                DeckProblem::Count {
                    what: "materials".into(),
                    found: material,
                    expected: usize::from(u16::MAX),
                },
            )
        })
    }

    fn section(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["ELSET", "MATERIAL"])?;
        let set = self.full_name(instance, block.required(self.source, "ELSET")?);
        let index = self.material_index(block)?;
        if self.facets.sets.contains_key(&set) {
            return Err(self.refused(
                block,
                "its set holds elements that are no solids; give the solids a set of their own, and the others no section",
            ));
        }
        let Some(elements) = self.deck.element_sets.get(&set) else {
            return Err(self.undefined(block.at, "element set", &set));
        };
        for &element in elements {
            let label = self.deck.elements[element as usize].label;
            if let Some(known) = self.deck.elements[element as usize].material.replace(index)
                && known != index
            {
                let name = self.deck.name(label);
                let first = self.deck.elements[element as usize].line;
                return Err(self.duplicate(block.at, "section with another material for element", name, first));
            }
        }
        Ok(())
    }

    /// `*SPRING` of `SPRING1` elements: a component, then a stiffness.
    fn spring(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["ELSET"])?;
        let [first, second] = block.data[..] else {
            return Err(self.error(
                block.at,
                DeckProblem::Count {
                    what: "data lines of *SPRING (component; stiffness)".into(),
                    found: block.data.len(),
                    expected: 2,
                },
            ));
        };
        let [component] = first.columns::<1>(self.source)?;
        let component = match component {
            "1" => 0,
            "2" => 1,
            "3" => 2,
            _ => return Err(first.invalid(self.source, "component", component, "1, 2 or 3")),
        };
        let [text] = second.columns::<1>(self.source)?;
        let stiffness = second.number(self.source, "stiffness", text)?;
        if !(stiffness > 0.0) {
            return Err(second.invalid(self.source, "stiffness", text, "positive (N/m)"));
        }
        let nodes = self.take_up(
            instance,
            block,
            Point::Spring,
            ["set of SPRING1 elements", "SPRING1 element"],
        )?;
        self.deck.springs.extend(nodes.into_iter().map(|node| DeckSpring {
            node,
            component,
            stiffness,
            line: block.at,
        }));
        Ok(())
    }

    /// `*MASS` of `MASS` elements.
    fn mass(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["ELSET", "TYPE"])?;
        block.choice(self.source, "TYPE", &["ISOTROPIC"])?;
        let [line] = block.data[..] else {
            return Err(self.error(
                block.at,
                DeckProblem::Count {
                    what: "data lines of *MASS (the mass)".into(),
                    found: block.data.len(),
                    expected: 1,
                },
            ));
        };
        let [text] = line.columns::<1>(self.source)?;
        let mass = line.number(self.source, "mass", text)?;
        if !(mass > 0.0) {
            return Err(line.invalid(self.source, "mass", text, "positive (kg)"));
        }
        let nodes = self.take_up(instance, block, Point::Mass, ["set of MASS elements", "MASS element"])?;
        self.deck.masses.extend(nodes.into_iter().map(|node| DeckMass {
            node,
            mass,
            line: block.at,
        }));
        Ok(())
    }

    /// Nodes of the elements in the set of a block, all of one kind, which are in use from now on. `names` are those of
    /// the set and of an element in messages.
    pub(super) fn take_up(
        &mut self,
        instance: u32,
        block: &Block<'_>,
        kind: Point,
        names: [&'static str; 2],
    ) -> Result<Vec<u32>, Error> {
        let set = self.full_name(instance, block.required(self.source, "ELSET")?);
        let Some(labels) = self.point_sets.get(&set).cloned() else {
            return Err(self.undefined(block.at, names[0], &set));
        };
        let node = |label: &Label| match self.points.get(label) {
            Some((found, node, _)) if *found == kind => Ok(*node),
            _ => Err(self.undefined(block.at, names[1], &self.deck.name(*label))),
        };
        let nodes = labels.iter().map(node).collect::<Result<Vec<_>, _>>()?;
        self.spend(nodes.len(), block.at)?;
        for label in labels {
            if !self.used_points.insert(label) {
                let (name, first) = (self.deck.name(label), self.points[&label].2);
                return Err(self.duplicate(block.at, "property of element", name, first));
            }
        }
        Ok(nodes)
    }
}
