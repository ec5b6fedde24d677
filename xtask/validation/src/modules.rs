//! Proves that the files of a crate use one another one way only.
//!
//! A file uses another if its code names an item that is defined there. What a file hands on from others (`pub use`) and its tests do not count.

use anyhow::{Context, Result, anyhow};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree, Visibility};

/// Names of modules from the root of a crate on.
type Place = Vec<String>;

/// A file as the others see it.
#[derive(Default)]
struct Module {
    /// Modules in files of their own.
    children: BTreeSet<String>,
    /// Names that it hands on, with the items that they stand for.
    handed_on: BTreeMap<String, Place>,
    /// Paths that it names, with the modules within the file that name them.
    named: Vec<(Place, Place)>,
}

/// Circles of files in the crate whose sources are in a folder, each in words.
///
/// # Errors
/// A file that cannot be read, or is no Rust.
pub(crate) fn circles(source: &Path) -> Result<Vec<String>> {
    let mut modules = BTreeMap::new();
    collect(source, &Place::new(), &mut modules)?;
    let uses: BTreeMap<&Place, BTreeSet<&Place>> = modules
        .iter()
        .map(|(place, module)| (place, used(place, module, &modules)))
        .collect();
    let mut found = Vec::new();
    let mut done = BTreeSet::new();
    for place in modules.keys() {
        let ahead = reached(place, &uses);
        if done.contains(place) || !ahead.contains(place) {
            continue;
        }
        let circle: Vec<&Place> = ahead
            .into_iter()
            .filter(|other| reached(other, &uses).contains(place))
            .collect();
        let names = circle.iter().map(|place| match place.as_slice() {
            [] => "lib".to_owned(),
            path => path.join("::"),
        });
        found.push(names.collect::<Vec<_>>().join(", "));
        done.extend(circle);
    }
    Ok(found)
}

/// All files that one uses, directly or by others.
fn reached<'m>(from: &Place, uses: &BTreeMap<&'m Place, BTreeSet<&'m Place>>) -> BTreeSet<&'m Place> {
    let mut found = BTreeSet::new();
    let mut next: Vec<&Place> = uses[from].iter().copied().collect();
    while let Some(place) = next.pop() {
        if found.insert(place) {
            next.extend(uses[place].iter().copied());
        }
    }
    found
}

/// Reads the files of a folder and of the folders in it.
fn collect(folder: &Path, at: &Place, modules: &mut BTreeMap<Place, Module>) -> Result<()> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    paths.sort();
    for path in paths {
        let stem = path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
            .unwrap_or_default();
        if path.is_dir() {
            collect(&path, &[&at[..], &[stem]].concat(), modules)?;
        } else if path.extension().is_some_and(|kind| kind == "rs") && stem != "main" {
            let place = match stem.as_str() {
                "lib" | "mod" => at.clone(),
                _ => [&at[..], &[stem]].concat(),
            };
            modules.insert(place.clone(), read(&path, place)?);
        }
    }
    Ok(())
}

fn read(path: &Path, place: Place) -> Result<Module> {
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let file = syn::parse_file(&text).map_err(|error| anyhow!("{}: {error}", path.display()))?;
    let mut reader = Reader {
        place,
        module: Module::default(),
    };
    reader.visit_file(&file);
    Ok(reader.module)
}

struct Reader {
    /// Of the file, and of the module within it.
    place: Place,
    module: Module,
}

fn is_test(attributes: &[Attribute]) -> bool {
    let of_tests = |attribute: &Attribute| {
        let list = attribute.meta.require_list();
        attribute.path().is_ident("cfg") && list.is_ok_and(|list| list.tokens.to_string() == "test")
    };
    attributes.iter().any(of_tests)
}

impl Visit<'_> for Reader {
    fn visit_item(&mut self, item: &Item) {
        let attributes = match item {
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Mod(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &ItemMod) {
        let name = item.ident.to_string();
        if item.content.is_none() {
            self.module.children.insert(name);
            return;
        }
        self.place.push(name);
        visit::visit_item_mod(self, item);
        self.place.pop();
    }

    fn visit_item_use(&mut self, item: &ItemUse) {
        let mut leaves = Vec::new();
        flatten(&item.tree, &Place::new(), &mut leaves);
        for (name, path) in leaves {
            match item.vis {
                Visibility::Inherited => self.module.named.push((self.place.clone(), path)),
                _ => drop(self.module.handed_on.insert(name, path)),
            }
        }
    }

    fn visit_path(&mut self, path: &syn::Path) {
        let names = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.module.named.push((self.place.clone(), names));
        visit::visit_path(self, path);
    }

    // A visibility is no use.
    fn visit_visibility(&mut self, _: &Visibility) {}
}

/// The items that a `use` names, by their names here.
fn flatten(tree: &UseTree, before: &Place, leaves: &mut Vec<(String, Place)>) {
    let with = |name: &syn::Ident| [&before[..], &[name.to_string()]].concat();
    match tree {
        UseTree::Path(path) => flatten(&path.tree, &with(&path.ident), leaves),
        UseTree::Name(name) if name.ident == "self" => {
            leaves.push((before.last().cloned().unwrap_or_default(), before.clone()));
        }
        UseTree::Name(name) => leaves.push((name.ident.to_string(), with(&name.ident))),
        UseTree::Rename(rename) => leaves.push((rename.rename.to_string(), with(&rename.ident))),
        UseTree::Glob(_) => leaves.push((String::new(), before.clone())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, before, leaves)),
    }
}

/// A path from the root of the crate on; none of what is not in it, or begins with a name of the file's own.
fn absolute(at: &Place, path: &Place, module: &Module) -> Option<Place> {
    let mut place = at.clone();
    let mut rest = &path[..];
    match rest.first()?.as_str() {
        "crate" => (place, rest) = (Place::new(), &rest[1..]),
        "self" => rest = &rest[1..],
        "super" => {
            while rest.first().is_some_and(|name| name == "super") {
                place.pop();
                rest = &rest[1..];
            }
        }
        name if module.children.contains(name) && path.len() > 1 => {}
        _ => return None,
    }
    Some([&place[..], rest].concat())
}

/// The files with the items that one names.
fn used<'m>(place: &Place, module: &Module, modules: &'m BTreeMap<Place, Module>) -> BTreeSet<&'m Place> {
    let items = module.named.iter().filter_map(|(at, path)| absolute(at, path, module));
    let files = items.map(|item| file_of(&item, modules, 0));
    files.flatten().filter(|file| *file != place).collect()
}

/// The file in which an item is defined, whoever hands it on.
fn file_of<'m>(item: &Place, modules: &'m BTreeMap<Place, Module>, depth: usize) -> Option<&'m Place> {
    const DEEPEST: usize = 16;
    let lengths = (0..=item.len()).rev();
    let (file, module) = lengths
        .filter_map(|length| modules.get_key_value(&item[..length]))
        .next()?;
    let rest = &item[file.len()..];
    let handed_on = rest.first().and_then(|name| module.handed_on.get(name));
    let further = handed_on
        .filter(|_| depth < DEEPEST)
        .and_then(|path| absolute(file, path, module));
    match further {
        Some(path) => file_of(&[&path[..], &rest[1..]].concat(), modules, depth + 1),
        None => Some(file),
    }
}

#[cfg(test)]
mod tests {

    use super::circles;
    use std::fs;

    #[test]
    fn circles_are_named_and_what_is_handed_on_or_tested_is_none() {
        let folder = std::env::temp_dir().join(format!("modules-{}", std::process::id()));
        fs::create_dir_all(folder.join("b")).unwrap();
        let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
        write("lib.rs", "mod a; mod b; mod c; pub use a::A; pub use b::B;");
        write("a.rs", "pub struct A; #[cfg(test)] mod tests { use crate::B; }");
        write("b/mod.rs", "mod d; pub use d::D; pub struct B(crate::A);");
        write("b/d.rs", "pub struct D;");
        write("c.rs", "use super::{b::D, B}; // crate::c");
        assert!(circles(&folder).unwrap().is_empty());
        // A child that uses its parent, which uses it; and two siblings by way of a name that is handed on.
        write(
            "b/mod.rs",
            "mod d; pub use d::D; pub struct B(crate::A); fn f() { d::g() }",
        );
        write("b/d.rs", "pub struct D; pub(crate) fn g() { let _: super::B; }");
        write("a.rs", "pub struct A; fn c() { crate::c::h::<u8>(); }");
        write("c.rs", "use super::A; pub(super) fn h<T>() {}");
        assert_eq!(circles(&folder).unwrap(), ["a, c", "b, b::d"]);
        fs::remove_dir_all(&folder).unwrap();
    }
}
