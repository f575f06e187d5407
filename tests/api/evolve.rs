//! `brood evolve`: questions and answers over standard streams, and the files it leaves when it
//! ends or is killed.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use brood_tests::{binary, brood};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Running `brood evolve`.
struct Talk {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

impl Talk {
    fn begin(words: &[&str]) -> Self {
        let mut child = Command::new(binary())
            .args(["evolve", "--dialect", "smooth registers 7"])
            .args(words)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (child.stdin.take(), child.stdout.take().unwrap());
        Self { child, input, output: BufReader::new(output) }
    }

    fn asked(&mut self) -> Value {
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"))
    }

    fn tell(&mut self, line: &Value) {
        writeln!(self.input.as_mut().unwrap(), "{line}").unwrap();
    }

    /// Answers a question with each genome's distance from fifty operations.
    fn answer(&mut self, asked: &Value) {
        let genomes = asked["genomes"].as_array().unwrap();
        let error = |genome: &Value| (genome["operations"].as_f64().unwrap() - 50.0).abs();
        self.tell(&json!({ "errors": genomes.iter().map(error).collect::<Vec<_>>() }));
    }
}

fn hashes(asked: &Value) -> Vec<&str> {
    asked["genomes"].as_array().unwrap().iter().map(|one| one["hash"].as_str().unwrap()).collect()
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

#[test]
fn errors_decrease_over_generations() {
    let folder = TempDir::new().unwrap();
    let out = path(folder.path(), "out");
    let mut talk = Talk::begin(&["--count", "12", "--kept", "8", "--seed", "5", "-o", &out]);
    let mut best = Vec::new();
    for generation in 0..8 {
        let asked = talk.asked();
        assert_eq!(asked["generation"], generation);
        assert_eq!(hashes(&asked).len(), 12);
        best.extend(asked["best"].as_f64());
        talk.answer(&asked);
    }
    let last = talk.asked();
    assert!(last["best"].as_f64().unwrap() < best[0], "{best:?}");
    assert_eq!(last["evaluations"], 96);
    // End of input ends the command.
    talk.input = None;
    let end = talk.asked();
    assert_eq!(end["end"], true);
    assert_eq!(end["front"][0]["error"], last["best"]);
    assert!(talk.child.wait().unwrap().success());
    let best = path(folder.path(), "out/best.brood");
    brood(["inspect", &best]).success();
    let front = std::fs::read_to_string(folder.path().join("out/front.csv")).unwrap();
    assert!(front.starts_with("genome,operations,error\nfront/00.brood,"), "{front}");
}

#[test]
fn run_resumes_where_it_was_killed() {
    let folder = TempDir::new().unwrap();
    let state = path(folder.path(), "state");
    let mut whole = Talk::begin(&["--count", "6", "--seed", "2"]);
    let mut broken = Talk::begin(&["--count", "6", "--seed", "2", "--state", &state]);
    for _ in 0..3 {
        let asked = broken.asked();
        assert_eq!(hashes(&whole.asked()), hashes(&asked));
        whole.answer(&asked);
        broken.answer(&asked);
        // The next question shows that the state is saved.
        let next = broken.asked();
        broken.child.kill().unwrap();
        broken.child.wait().unwrap();
        broken = Talk::begin(&["--count", "6", "--seed", "2", "--state", &state]);
        let again = broken.asked();
        assert_eq!(again, next);
        let expected = whole.asked();
        assert_eq!(hashes(&again), hashes(&expected));
        broken.answer(&again);
        whole.answer(&expected);
    }
    for mut talk in [whole, broken] {
        talk.asked();
        talk.tell(&json!({ "end": true }));
        assert_eq!(talk.asked()["end"], true);
        assert!(talk.child.wait().unwrap().success());
    }
}

#[test]
fn invalid_answers_are_refused_in_one_line() {
    for (answer, words) in [
        ("{\"errors\": [1]}", "expected 6 errors, one for each genome, got 1"),
        ("{\"error\": [1]}", "unknown field `error`"),
        ("{}", "{\"errors\": [...]} or {\"end\": true}"),
        ("1 2 3", "read a line of input"),
    ] {
        let mut talk = Talk::begin(&["--count", "6"]);
        talk.asked();
        writeln!(talk.input.as_mut().unwrap(), "{answer}").unwrap();
        let finished = talk.child.wait_with_output().unwrap();
        let text = String::from_utf8(finished.stderr).unwrap();
        assert_eq!(finished.status.code(), Some(1), "{answer}");
        assert!(text.starts_with("error: ") && text.contains(words), "{answer}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
    let folder = TempDir::new().unwrap();
    let state = path(folder.path(), "state");
    std::fs::write(&state, b"something else").unwrap();
    let finished = brood(["evolve", "--state", &state]);
    assert!(finished.stderr.contains("a later version of this program"), "{}", finished.stderr);
}
