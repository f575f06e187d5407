//! Rule for the files of a crate: no circles, so each file can be read after the files it uses.
//!
//! File A uses file B if the code of A names an item that B defines. Names are `use` declarations
//! and paths such as `crate::b::f`, `super::T` or `child::C`; re-exports are followed to the file
//! that defines the item. `mod` lines are not uses. A `pub use` is one only if the code of the same
//! file has the name. A parent that only declares and re-exports its children therefore uses none
//! of them, and they may use what the parent defines.
//!
//! Reads the files as text. Comments, items with `#[cfg(test)]` and test files do not count.
//! Methods, macros and names from glob imports are not followed.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::LazyLock;

use regex::Regex;

/// Source folders that are free of circles and stay so. Others are added when they are clean.
const FREE: [&str; 16] = [
    "crates/brdf/src/",
    "crates/eval/src/",
    "crates/export/src/",
    "crates/genome/src/",
    "crates/gpu/src/",
    "crates/inspect/src/",
    "crates/light/src/",
    "crates/mesh/src/",
    "crates/program/src/",
    "crates/protocol/src/",
    "crates/scene/src/",
    "crates/search/src/",
    "crates/storage/src/",
    "crates/target/src/",
    "server/src/",
    "worker/src/",
];

/// Largest number of re-exports on the way to an item. Ends chains that lead to themselves.
const MAX_REEXPORTS: usize = 16;

static USE: LazyLock<Regex> = LazyLock::new(|| {
    Regex::new(r"(?m)^\s*(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);").expect("pattern is valid")
});
static PATH: LazyLock<Regex> =
    LazyLock::new(|| Regex::new(r"[A-Za-z_]\w*(?:::[A-Za-z_]\w*)+").expect("pattern is valid"));
static WORD: LazyLock<Regex> =
    LazyLock::new(|| Regex::new(r"[A-Za-z_]\w*").expect("pattern is valid"));

/// Path of a module from the crate's root, which is empty.
type Module = Vec<String>;

/// A name that a `use` declaration brings into a file.
struct Import {
    /// Name in the file; `*` for all names of a module.
    name: String,
    path: Vec<String>,
    is_public: bool,
}

/// Names in the code of one file.
struct SourceFile {
    imports: Vec<Import>,
    /// Paths outside `use` declarations.
    paths: Vec<Vec<String>>,
    words: BTreeSet<String>,
}

/// Meaning of a path.
enum Target {
    Module(Module),
    /// An item that the module's own file defines.
    ItemOf(Module),
    /// An item of another crate, or a local name.
    Outside,
}

/// Collects the files of the crates that are checked.
#[derive(Default)]
pub struct Circles {
    crates: BTreeMap<&'static str, Files>,
}

#[derive(Default)]
struct Files {
    /// File name below the source folder, and the names in its code.
    files: BTreeMap<Module, (String, SourceFile)>,
}

impl Circles {
    /// Adds one Rust file that is not a test file. Ignores files of other crates.
    pub fn add(&mut self, name: &str, text: &str) {
        let Some(folder) = FREE.into_iter().find(|folder| name.starts_with(folder)) else { return };
        self.crates.entry(folder).or_default().add(&name[folder.len()..], text);
    }

    /// Returns one violation for each group of files that use each other in a circle.
    pub fn violations(&self) -> Vec<String> {
        let circles = self.crates.iter().flat_map(|(folder, files)| {
            files.circles().into_iter().map(move |circle| format!("{folder}{circle}"))
        });
        circles.collect()
    }
}

impl Files {
    fn add(&mut self, name: &str, text: &str) {
        let mut module: Module =
            name.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        let last = module.last().map(String::as_str);
        if last == Some("mod") || module == ["lib"] || module == ["main"] {
            module.pop();
        }
        self.files.insert(module, (name.to_owned(), SourceFile::new(text)));
    }

    /// Follows a path that stands in the file of `module`.
    fn resolve(&self, module: &[String], path: &[String], reexports: usize) -> Target {
        let mut here = module.to_vec();
        for (index, name) in path.iter().enumerate() {
            match name.as_str() {
                "crate" => here.clear(),
                "self" => {}
                "super" => {
                    here.pop();
                }
                name => match self.member(&here, name, reexports) {
                    Some(Target::Module(inner)) => here = inner,
                    Some(target) => return target,
                    None if index == 0 => return Target::Outside,
                    None => return Target::ItemOf(here),
                },
            }
        }
        Target::Module(here)
    }

    /// Meaning of a name in a module; `None` if neither a file nor an import has it.
    fn member(&self, module: &[String], name: &str, reexports: usize) -> Option<Target> {
        let child = [module, &[name.to_owned()]].concat();
        if self.files.contains_key(&child) {
            return Some(Target::Module(child));
        }
        let (_, file) = self.files.get(module)?;
        let import = file.imports.iter().find(|import| import.name == name)?;
        let Some(left) = reexports.checked_sub(1) else { return Some(Target::Outside) };
        Some(self.resolve(module, &import.path, left))
    }

    /// Modules that the file of `module` uses, each with one of the names.
    fn uses(&self, module: &Module, file: &SourceFile) -> BTreeMap<Module, String> {
        let imports =
            file.imports.iter().filter(|it| !it.is_public || file.words.contains(&it.name));
        let imports = imports.map(|it| (it.name.as_str(), &it.path));
        let paths = file.paths.iter().map(|path| (path[path.len() - 1].as_str(), path));
        let mut used = BTreeMap::new();
        for (name, path) in imports.chain(paths) {
            let target = match self.resolve(module, path, MAX_REEXPORTS) {
                Target::ItemOf(target) => target,
                Target::Module(target) if name == "*" => target,
                _ => continue,
            };
            if target != *module {
                used.entry(target).or_insert_with(|| name.to_owned());
            }
        }
        used
    }

    fn circles(&self) -> Vec<String> {
        let uses: BTreeMap<&Module, BTreeMap<Module, String>> = self
            .files
            .iter()
            .map(|(module, (_, file))| (module, self.uses(module, file)))
            .collect();
        let mut reported = BTreeSet::new();
        let mut found = Vec::new();
        for module in self.files.keys() {
            let Some(circle) = shortest_circle(&uses, module) else { continue };
            // The first circle speaks for all that share a file with it.
            let is_new = circle.iter().all(|module| !reported.contains(module));
            reported.extend(circle.clone());
            if is_new {
                found.push(self.describe(&uses, &circle));
            }
        }
        found
    }

    fn describe(
        &self,
        uses: &BTreeMap<&Module, BTreeMap<Module, String>>,
        circle: &[&Module],
    ) -> String {
        let file = |module: &Module| self.files[module].0.as_str();
        let next = circle.iter().cycle().skip(1);
        let steps: Vec<String> = circle
            .iter()
            .zip(next)
            .map(|(from, to)| format!("{} uses {} of {}", file(from), uses[from][*to], file(to)))
            .collect();
        format!(
            "{}: circle of files: {}; move what they share to a file below them",
            file(circle[0]),
            steps.join(", ")
        )
    }
}

/// Shortest way from a module back to itself, by breadth-first search.
fn shortest_circle<'a>(
    uses: &'a BTreeMap<&Module, BTreeMap<Module, String>>,
    start: &'a Module,
) -> Option<Vec<&'a Module>> {
    let mut previous: BTreeMap<&Module, &Module> = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(module) = queue.pop_front() {
        for used in uses.get(module)?.keys() {
            if used == start {
                let mut circle = vec![module];
                while circle[circle.len() - 1] != start {
                    circle.push(previous[circle[circle.len() - 1]]);
                }
                circle.reverse();
                return Some(circle);
            }
            if !previous.contains_key(used) {
                previous.insert(used, module);
                queue.push_back(used);
            }
        }
    }
    None
}

impl SourceFile {
    fn new(text: &str) -> Self {
        let code = code(text);
        let mut imports = Vec::new();
        for found in USE.captures_iter(&code) {
            expand(&[], &found[2], found.get(1).is_some(), &mut imports);
        }
        let rest = USE.replace_all(&code, "");
        let is_start = |at: usize| !rest[..at].ends_with(':');
        let paths = PATH.find_iter(&rest).filter(|found| is_start(found.start()));
        let paths = paths.map(|path| path.as_str().split("::").map(str::to_owned).collect());
        let words = WORD.find_iter(&rest).map(|word| word.as_str().to_owned()).collect();
        Self { imports, paths: paths.collect(), words }
    }
}

/// Text without comments and without items that only tests have.
fn code(text: &str) -> String {
    let mut code = String::new();
    // Indentation of the test item that is being skipped.
    let mut skipped = None;
    for line in text.lines() {
        let line = line.split("//").next().unwrap_or_default().trim_end();
        let indentation = line.len() - line.trim_start().len();
        match skipped {
            Some(start) => {
                // A formatted item ends on a line that is indented as its first one.
                if indentation == start && line.ends_with(['}', ';']) {
                    skipped = None;
                }
            }
            None if line.trim_start() == "#[cfg(test)]" => skipped = Some(indentation),
            None => {
                code.push_str(line);
                code.push('\n');
            }
        }
    }
    code
}

/// Splits the tree of a `use` declaration into its names.
fn expand(prefix: &[String], tree: &str, is_public: bool, imports: &mut Vec<Import>) {
    let (head, branches) = match tree.trim().split_once('{') {
        Some((head, rest)) => (head, rest.trim_end().strip_suffix('}')),
        None => (tree.trim(), None),
    };
    let (head, alias) = match head.split_once(" as ") {
        Some((head, alias)) => (head, Some(alias.trim())),
        None => (head, None),
    };
    let names = head.trim().trim_end_matches("::").split("::").map(str::trim);
    let mut path = prefix.to_vec();
    path.extend(names.filter(|name| !name.is_empty()).map(str::to_owned));
    let Some(branches) = branches else {
        let is_glob = path.last().is_some_and(|name| name == "*");
        if is_glob || (path.len() > 1 && path.last().is_some_and(|name| name == "self")) {
            path.pop();
        }
        let last = if is_glob { Some("*") } else { path.last().map(String::as_str) };
        let name = alias.or(last).unwrap_or_default().to_owned();
        imports.push(Import { name, path, is_public });
        return;
    };
    let (mut depth, mut start) = (0, 0);
    for (at, c) in branches.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                expand(&path, &branches[start..at], is_public, imports);
                start = at + 1;
            }
            _ => {}
        }
    }
    if !branches[start..].trim().is_empty() {
        expand(&path, &branches[start..], is_public, imports);
    }
}

#[cfg(test)]
mod tests {
    use super::Circles;

    fn violations(files: &[(&str, &str)]) -> Vec<String> {
        let mut circles = Circles::default();
        for (name, text) in files {
            circles.add(&format!("crates/brdf/src/{name}"), text);
        }
        circles.violations()
    }

    const ROOT: &str = "//! Root.\nmod a;\nmod b;\npub use a::{A, f as g};\npub use b::B;\n";

    #[test]
    fn circle_is_refused_when_files_use_each_other_through_reexports() {
        let a = "//! A.\nuse crate::{\n    B,\n};\npub struct A(B);\n";
        let b = "//! B.\npub struct B;\nfn f() {\n    super::g();\n}\n";
        let found = violations(&[("lib.rs", ROOT), ("a.rs", a), ("b.rs", b)]);
        let wanted = "crates/brdf/src/a.rs: circle of files: a.rs uses B of b.rs, b.rs uses g of a.rs; \
                      move what they share to a file below them";
        assert_eq!(found, [wanted]);
    }

    #[test]
    fn circle_is_refused_when_a_parent_uses_the_child_that_uses_it() {
        let parent = "//! A.\nmod c;\npub use c::C;\npub struct A;\nfn f() -> C { C }\n";
        let child = "//! C.\nuse super::A;\npub struct C(A);\n";
        let found = violations(&[("lib.rs", ROOT), ("a.rs", parent), ("a/c.rs", child)]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("a.rs uses C of a/c.rs, a/c.rs uses A of a.rs"), "{found:?}");
        let found = violations(&[("a/mod.rs", "mod c;\nfn f() { c::g() }"), ("a/c.rs", child)]);
        assert_eq!(found.len(), 1, "{found:?}");
    }

    #[test]
    fn files_pass_when_a_parent_only_declares_and_reexports() {
        let parent = "//! A.\nmod c;\npub use c::C;\npub struct A;\n";
        let child = "//! C.\nuse super::A;\npub struct C(A);\n";
        let found = violations(&[("lib.rs", ROOT), ("a.rs", parent), ("a/c.rs", child)]);
        assert_eq!(found, Vec::<String>::new());
    }

    #[test]
    fn uses_pass_when_they_stand_in_comments_or_tests_or_lead_out_of_the_crate() {
        let a = "//! [`crate::b::B`].\nuse std::fmt::{self, Debug};\npub struct A;\n\
                 #[cfg(test)]\nmod tests;\npub use other::B;\n\
                 #[cfg(test)]\nmod more {\n    use crate::b::B;\n}\n";
        let b = "//! B.\nuse crate::A;\npub struct B(A);\n";
        let files = [("lib.rs", ROOT), ("a.rs", a), ("b.rs", b)];
        assert_eq!(violations(&files), Vec::<String>::new());
    }
}
