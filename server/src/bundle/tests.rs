use super::{bundle, without_comments};

fn of(files: &[(&str, &str)]) -> Result<String, String> {
    let read = |path: &str| {
        files.iter().find(|(name, _)| *name == path).map(|(_, text)| (*text).to_owned())
    };
    bundle("main.js", &read).map_err(|error| error.to_string())
}

#[test]
fn modules_become_functions_in_the_order_of_their_imports() {
    let text = of(&[
        (
            "main.js",
            "/** About. */\nimport {\n  a, b as c,\n} from \"./x/a.js\";\nimport \"./side.js\";\n\
             import * as all from \"./x/b.js\";\nc(a, all.d);\n",
        ),
        ("x/a.js", "import{d as e}from\"./b.js\";const r=1;export{r as a,e as b};\n"),
        ("x/b.js", "export function d() {}\nexport const e = 1;\nexport class F {}\n"),
        ("side.js", "import f from \"./f.js\";\nimport { a } from \"./x/a.js\";\nf(a);\n"),
        ("f.js", "var n=1;export default function(s){return n}\n"),
    ])
    .unwrap();
    let expected = "\
const module_0 = (() => {
function d() {}
const e = 1;
class F {}
;return {d: d, e: e, F: F};
})();
const module_1 = (() => {
const {d: e} = module_0;
const r=1;
;return {a: r, b: e};
})();
const module_2 = (() => {
var n=1;const module_default = function(s){return n}
;return {default: module_default};
})();
const module_3 = (() => {
const {default: f} = module_2;
const {a: a} = module_1;
f(a);
;return {};
})();
const module_4 = (() => {
const {a: a, b: c} = module_1;
const all = module_0;
c(a, all.d);
;return {};
})();
";
    assert_eq!(text, expected);
}

#[test]
fn exports_of_another_module_are_passed_on() {
    let text = of(&[
        ("main.js", "import { b } from \"./a.js\";\nb();\n"),
        ("a.js", "export{c as b}from\"./c.js\";const d=1;export{d};\n"),
        ("c.js", "export async function c() {}\n"),
    ])
    .unwrap();
    assert!(text.contains("return {b: module_0.c, d: d};"), "{text}");
}

#[test]
fn unsupported_modules_are_rejected() {
    let with = |main: &str| {
        let other = ("a.js", "import { b } from \"./main.js\";\nexport const a = b;\n");
        of(&[("main.js", main), other]).unwrap_err()
    };
    for (main, expected) in [
        ("import { x } from \"./gone.js\";\n", "gone.js: does not exist"),
        ("import { a } from \"./a.js\";\nexport const b = 1;\n", "main.js: imports itself"),
        ("import { a } from \"lib\";\n", "the path lib must begin with"),
        ("import { a } from \"../../a.js\";\n", "leaves the folder"),
        ("const b = 1;\nimport { a } from \"./a.js\";\n", "must be at the beginning"),
        ("export let b = 1;\n", "cannot bundle: export let b"),
        ("export const { b } = c;\n", "cannot bundle: export const { b }"),
        ("export * from \"./a.js\";\n", "cannot bundle: export *"),
    ] {
        let error = with(main);
        assert!(error.contains(expected), "{main}: {error}");
    }
    let files = [("main.js", "import { x } from \"./a.js\";\n"), ("a.js", "export const y = 1;\n")];
    assert_eq!(of(&files).unwrap_err(), "main.js: a.js does not export x");
}

#[test]
fn only_comments_that_begin_a_line_are_removed() {
    let source = "/**\n * A.\n */\n/* one */\na(\"//x\"); // stays\n  // gone\n/* c */ b();\n\nc(`\n* d`);\n";
    assert_eq!(without_comments(source), "a(\"//x\"); // stays\nb();\nc(`\n* d`);\n");
}
