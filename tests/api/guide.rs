//! The guide: its script works as described, and its example is the quoted preset.

use std::path::Path;
use std::process::Command;

use brood_tests::{TestServer, brood};
use tempfile::TempDir;

fn guide() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide.md");
    std::fs::read_to_string(path).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn script_of_the_guide_breeds_towards_detail() {
    let guide = guide();
    let (_, rest) = guide.split_once("```python\n").unwrap();
    let (script, _) = rest.split_once("```").unwrap();
    assert!(script.lines().count() <= 45, "the guide says forty lines");
    let server = TestServer::start();
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("breed.py"), script).unwrap();
    let mut python = Command::new("python3");
    let url = format!("http://{}", server.address());
    python.args(["breed.py", &url, "3"]).current_dir(folder.path());
    let run = tokio::task::spawn_blocking(move || python.output()).await.unwrap().unwrap();
    let printed = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(run.status.success(), "{printed}{}", String::from_utf8_lossy(&run.stderr));
    let bytes: Vec<u64> = printed
        .lines()
        .filter_map(|line| line.split_once(" has ")?.1.strip_suffix(" bytes")?.parse().ok())
        .collect();
    assert_eq!(bytes.len(), 3, "{printed}");
    assert!(std::fs::read(folder.path().join("detail.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn example_of_the_guide_equals_the_preset() {
    let text = brood(["preset", "red-plastic"]).success().stdout;
    assert!(guide().contains(text.trim_end()), "docs/guide.md quotes another red plastic");
}
