//! Bundle of the page: all its modules as one script, so that a browser far away needs one request
//! and not one for each level of imports.
//!
//! Each module becomes a function that returns its exports, called after the modules it imports.
//! Supports the syntax that the page uses: static imports of relative paths at the beginning of a
//! module, and exports at the beginning of a line or at the end of a module. Everything else is an
//! error, as are circles of imports: there, and with exports that are reassigned, a function's
//! result would differ from a module's live exports.

use std::collections::HashMap;

#[cfg(test)]
mod tests;

/// Reason why modules cannot be bundled: file and words.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{file}: {words}")]
pub struct BundleError {
    file: String,
    words: String,
}

impl BundleError {
    /// Error for a file that does not exist.
    pub fn missing(file: &str) -> Self {
        Self { file: file.to_owned(), words: "does not exist".to_owned() }
    }
}

/// Returns the script of a module and all modules that it imports.
///
/// # Errors
/// [`BundleError`] if a module is missing or has unsupported syntax, or imports form a circle.
pub fn bundle(entry: &str, read: &dyn Fn(&str) -> Option<String>) -> Result<String, BundleError> {
    let mut bundler = Bundler { read, done: HashMap::new(), open: Vec::new(), text: String::new() };
    bundler.add(entry)?;
    Ok(bundler.text)
}

/// Names from `{a, b as c}`: outside name and own name for imports, own name and outside name for
/// exports.
type Names = Vec<(String, String)>;

struct Bundler<'a> {
    read: &'a dyn Fn(&str) -> Option<String>,
    /// Number and exported names of each finished module.
    done: HashMap<String, (usize, Vec<String>)>,
    /// Modules whose imports are being added.
    open: Vec<String>,
    text: String,
}

impl Bundler<'_> {
    fn add(&mut self, file: &str) -> Result<(), BundleError> {
        let fail = |words: String| BundleError { file: file.to_owned(), words };
        if self.done.contains_key(file) {
            return Ok(());
        }
        if self.open.iter().any(|one| one == file) {
            return Err(fail("imports itself, directly or through other modules".to_owned()));
        }
        let source = (self.read)(file).ok_or_else(|| BundleError::missing(file))?;
        let source = without_comments(&source);
        self.open.push(file.to_owned());
        let (head, body) = split_head(&source).map_err(fail)?;
        let mut bindings = String::new();
        let mut exports = Names::new();
        for Statement { clause, from } in head {
            let from = resolve(file, from).map_err(fail)?;
            self.add(&from)?;
            let (number, known) = &self.done[&from];
            match clause {
                Clause::Nothing => {}
                Clause::All(own) => {
                    bindings.push_str(&format!("const {own} = module_{number};\n"));
                }
                Clause::Import(names) => {
                    check_known(&from, known, &names).map_err(fail)?;
                    let names = list(&names);
                    bindings.push_str(&format!("const {{{names}}} = module_{number};\n"));
                }
                Clause::Export(names) => {
                    check_known(&from, known, &names).map_err(fail)?;
                    let names = names.into_iter();
                    exports.extend(
                        names.map(|(theirs, outside)| {
                            (format!("module_{number}.{theirs}"), outside)
                        }),
                    );
                }
            }
        }
        let body = strip_exports(body, &mut exports).map_err(fail)?;
        let body = body.trim_end();
        let returned: Vec<String> =
            exports.iter().map(|(own, outside)| format!("{outside}: {own}")).collect();
        let number = self.done.len();
        let returned = returned.join(", ");
        self.text.push_str(&format!(
            "const module_{number} = (() => {{\n{bindings}{body}\n;return {{{returned}}};\n}})();\n"
        ));
        self.open.pop();
        let names = exports.into_iter().map(|(_, outside)| outside).collect();
        self.done.insert(file.to_owned(), (number, names));
        Ok(())
    }
}

enum Clause {
    Nothing,
    All(String),
    Import(Names),
    Export(Names),
}

/// `import ... from "..."` or `export {...} from "..."`.
struct Statement<'a> {
    clause: Clause,
    from: &'a str,
}

/// Removes comments that begin a line, and empty lines; other comments stay. Lines of template
/// literals are treated alike: there they are comments of shaders.
fn without_comments(source: &str) -> String {
    let mut kept = String::with_capacity(source.len());
    let mut in_comment = false;
    for line in source.lines() {
        let text = line.trim();
        in_comment |= text.starts_with("/*");
        let code = match text.split_once("*/").filter(|_| in_comment) {
            Some((_, code)) => {
                in_comment = false;
                code.trim_start()
            }
            None if in_comment || text.starts_with("//") => "",
            None => line,
        };
        if !code.trim().is_empty() {
            kept.push_str(code);
            kept.push('\n');
        }
    }
    kept
}

/// Splits the imports at the beginning of a module from the rest.
fn split_head(source: &str) -> Result<(Vec<Statement<'_>>, &str), String> {
    let mut statements = Vec::new();
    let mut rest = source.trim_start();
    loop {
        let is_import = rest.starts_with("import") && !rest.starts_with("import(");
        let is_export =
            rest.strip_prefix("export").is_some_and(|it| it.trim_start().starts_with('{'));
        let Some((statement, after)) = rest.split_once(';').filter(|_| is_import || is_export)
        else {
            return Ok((statements, rest));
        };
        let Some((clause, from)) = statement[6..].split_once('"') else {
            // The list of a module's own exports.
            return Ok((statements, rest));
        };
        let from = from.strip_suffix('"').ok_or_else(|| format!("cannot read {statement}"))?;
        let clause = clause.trim().trim_end_matches("from").trim();
        let clause = match () {
            () if is_export => Clause::Export(names(clause)?),
            () if clause.is_empty() => Clause::Nothing,
            () => match clause.strip_prefix('*') {
                Some(all) => Clause::All(all.trim().trim_start_matches("as ").to_owned()),
                None if clause.starts_with('{') => Clause::Import(names(clause)?),
                None => Clause::Import(vec![("default".to_owned(), name(clause)?)]),
            },
        };
        statements.push(Statement { clause, from });
        rest = after.trim_start();
    }
}

/// Reads `{a, b as c}`.
fn names(clause: &str) -> Result<Names, String> {
    let inner = clause.strip_prefix('{').and_then(|it| it.strip_suffix('}'));
    let inner = inner.ok_or_else(|| format!("cannot read {clause}"))?;
    let parts = inner.split(',').map(str::trim).filter(|part| !part.is_empty());
    parts
        .map(|part| match part.split_once(" as ") {
            Some((first, second)) => Ok((name(first)?, name(second)?)),
            None => Ok((name(part)?, name(part)?)),
        })
        .collect()
}

/// Returns an identifier without surrounding space.
fn name(text: &str) -> Result<String, String> {
    let text = text.trim();
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '$';
    let is_name = !text.is_empty() && text.chars().all(is_part);
    is_name.then(|| text.to_owned()).ok_or_else(|| format!("{text} is not a name"))
}

fn list(names: &Names) -> String {
    let parts: Vec<String> = names.iter().map(|(theirs, own)| format!("{theirs}: {own}")).collect();
    parts.join(", ")
}

fn check_known(file: &str, known: &[String], names: &Names) -> Result<(), String> {
    match names.iter().find(|(theirs, _)| !known.contains(theirs)) {
        Some((missing, _)) => Err(format!("{file} does not export {missing}")),
        None => Ok(()),
    }
}

/// Removes the word `export` from declarations, and the list of exports at the end; adds their
/// names.
fn strip_exports(body: &str, exports: &mut Names) -> Result<String, String> {
    let mut body = body.trim_end();
    if let Some((before, exported)) = body.rsplit_once("export").filter(|(before, exported)| {
        let begins = before.is_empty() || before.ends_with([';', '}', '\n']);
        begins && exported.trim_start().starts_with('{') && exported.matches('}').count() == 1
    }) {
        exports.extend(names(exported.trim().trim_end_matches(';'))?);
        body = before;
    }
    let mut kept = String::with_capacity(body.len());
    for line in body.split_inclusive('\n') {
        if line.starts_with("import ") || line.starts_with("import{") {
            return Err(format!("an import must be at the beginning: {}", line.trim_end()));
        }
        match line.strip_prefix("export ") {
            Some(declared) => {
                let own = declared_name(declared)?;
                exports.push((own.clone(), own));
                kept.push_str(declared);
            }
            None => kept.push_str(line),
        }
    }
    if let Some((before, default)) = kept.split_once(";export default ") {
        exports.push(("module_default".to_owned(), "default".to_owned()));
        kept = format!("{before};const module_default = {default}");
    }
    Ok(kept)
}

/// Name that a declaration after `export` declares.
fn declared_name(declared: &str) -> Result<String, String> {
    let unsupported = || format!("cannot bundle: export {}", declared.trim_end());
    let rest = ["async function ", "function* ", "function ", "const ", "class "]
        .iter()
        .find_map(|kind| declared.strip_prefix(kind))
        .ok_or_else(unsupported)?;
    let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '$'));
    let own = name(&rest[..end.unwrap_or(rest.len())]).map_err(|_| unsupported())?;
    Ok(own)
}

/// Path of an imported module.
fn resolve(file: &str, from: &str) -> Result<String, String> {
    if !from.starts_with("./") && !from.starts_with("../") {
        return Err(format!("the path {from} must begin with ./ or ../"));
    }
    let mut parts: Vec<&str> = file.split('/').collect();
    parts.pop();
    for part in from.split('/') {
        match part {
            "." => {}
            ".." => {
                parts.pop().ok_or_else(|| format!("{from} leaves the folder of the page"))?;
            }
            part => parts.push(part),
        }
    }
    Ok(parts.join("/"))
}
