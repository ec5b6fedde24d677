//! Elements as version 2.2 lists them: once for each physical group that they are in.

use super::parts::{Block, Kind, Shape};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// How many groups an entity may be in: the lists made of a file stay as small as it is.
pub(super) const MOST_GROUPS: usize = 16;

/// A line of `$Elements`.
pub(super) struct ListedElement {
    pub(super) at: usize,
    pub(super) kind: Kind,
    pub(super) tag: u64,
    /// Physical group, or 0.
    pub(super) group: u32,
    pub(super) entity: u32,
    /// Where its nodes begin.
    pub(super) nodes: usize,
}

/// All lines of `$Elements`.
#[derive(Default)]
pub(super) struct Listed {
    pub(super) elements: Vec<ListedElement>,
    pub(super) nodes: Vec<u32>,
}

impl Listed {
    fn nodes(&self, element: &ListedElement) -> &[u32] {
        &self.nodes[element.nodes..element.nodes + element.kind.n_nodes()]
    }

    /// The elements, each once, gathered by type, entity and groups; or place and tag of one that is in too many groups.
    pub(super) fn blocks(&self) -> Result<Vec<Block>, (usize, u64)> {
        // For each line the first of the same element, and the groups beside that of the first line.
        let mut first: HashMap<(Shape, &[u32]), usize> = HashMap::new();
        let mut more: BTreeMap<usize, BTreeSet<u32>> = BTreeMap::new();
        let mut again = HashSet::new();
        if self.has_repetitions() {
            for (number, element) in self.elements.iter().enumerate() {
                let key = (element.kind.shape(), self.nodes(element));
                let known = *first.entry(key).or_insert(number);
                if known != number && self.elements[known].entity == element.entity {
                    again.insert(number);
                    let groups = more.entry(known).or_default();
                    groups.insert(element.group);
                    if groups.len() >= MOST_GROUPS {
                        return Err((element.at, element.tag));
                    }
                }
            }
        }
        let mut numbers: BTreeMap<(Shape, u32, BTreeSet<u32>), usize> = BTreeMap::new();
        let mut blocks: Vec<Block> = Vec::new();
        for (number, element) in self.elements.iter().enumerate() {
            if again.contains(&number) {
                continue;
            }
            let mut groups = more.remove(&number).unwrap_or_default();
            groups.insert(element.group);
            groups.remove(&0);
            let key = (element.kind.shape(), element.entity, groups);
            let block = match numbers.get(&key) {
                Some(&block) => block,
                None => {
                    blocks.push(Block {
                        at: element.at,
                        kind: element.kind,
                        entity: element.entity.cast_signed(),
                        groups: key.2.clone(),
                        tags: Vec::new(),
                        nodes: Vec::new(),
                    });
                    numbers.insert(key, blocks.len() - 1);
                    blocks.len() - 1
                }
            };
            blocks[block].tags.push(element.tag);
            blocks[block].nodes.extend_from_slice(self.nodes(element));
        }
        Ok(blocks)
    }

    /// Whether an entity has elements in several groups, without which no element is listed twice.
    fn has_repetitions(&self) -> bool {
        let mut group_of = HashMap::new();
        self.elements.iter().any(|element| {
            let key = (element.kind.dimension(), element.entity);
            *group_of.entry(key).or_insert(element.group) != element.group
        })
    }
}
