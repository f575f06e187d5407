//! Command line and server give the same materials and the same pictures.

use std::path::Path;

use brood_tests::{ServerOptions, TestLineage, TestServer, brood, hashes, ids, text_of};
use reqwest::Method;
use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{Connection, SqliteConnection};
use tempfile::TempDir;

/// Runs `brood breed` into this folder; returns the printed hashes by slot.
fn breed(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let mut words = vec!["breed"];
    words.extend(arguments);
    let folder = folder.to_string_lossy();
    words.extend(["-o", folder.as_ref()]);
    let printed = brood(words).success().stdout;
    let lines: Vec<&str> = printed.lines().filter(|line| !line.trim().is_empty()).collect();
    lines
        .iter()
        .map(|line| {
            let hash = line.split_whitespace().find(|word| word.len() == 64);
            hash.unwrap_or_else(|| panic!("no hash in {line:?}")).to_owned()
        })
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn bred_children_equal_those_of_the_server() {
    let server = TestServer::start();
    // The command line's default; saturation 1 leaves the colours as evolved.
    let body = json!({"name": "first", "thumbnail_px": 32, "saturation": 1.0});
    let lineage = TestLineage::with(&server, body).await;
    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name);

    let first = lineage.breed(json!({"parents": [], "count": 20, "seed": 77})).await;
    let random = breed(&here("a"), &["--seed", "77", "--count", "20"]);
    assert_eq!(random, hashes(&first));

    let body = json!({"parents": [ids(&first)[4]], "count": 20, "seed": 78, "mutation": 0.45});
    let second = lineage.breed(body).await;
    let parent = here("a").join("04.brood").to_string_lossy().into_owned();
    let arguments = ["--parent", &parent, "--seed", "78", "--count", "20", "--mutation", "0.45"];
    assert_eq!(breed(&here("b"), &arguments), hashes(&second));

    let parents = [ids(&second)[0].clone(), ids(&first)[9].clone()];
    let body = json!({"parents": parents, "count": 5, "seed": 79, "recombination": 0.25});
    let third = lineage.breed(body).await;
    let (one, two) = (here("b").join("00.brood"), here("a").join("09.brood"));
    let (one, two) = (one.to_string_lossy(), two.to_string_lossy());
    let arguments = ["--parent", &one, "--parent", &two, "--seed", "79", "--count", "5"];
    let arguments = [&arguments[..], &["--recombination", "0.25"]].concat();
    assert_eq!(breed(&here("c"), &arguments), hashes(&third));

    assert!(here("a").join("sheet.png").is_file());
    let file = std::fs::read(here("c").join("02.brood")).unwrap();
    let path = format!("/v1/genomes/{}", hashes(&third)[2]);
    let request = server.request(Method::GET, &path).header("accept", "text/x-brood");
    assert_eq!(
        server.send(request).await.expect(200).body,
        file,
        "a genome file is the genome's text"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn rendered_picture_equals_that_of_the_server() {
    let server = TestServer::start();
    let body = json!({"name": "first", "thumbnail_px": 48, "saturation": 1.0});
    let lineage = TestLineage::with(&server, body).await;
    let generation = lineage.breed(json!({"parents": [], "count": 3, "seed": 8})).await;
    let folder = TempDir::new().unwrap();
    breed(folder.path(), &["--seed", "8", "--count", "3"]);
    for (slot, child) in ids(&generation).iter().enumerate() {
        let genome = folder.path().join(format!("{slot:02}.brood"));
        let out = folder.path().join(format!("{slot}.png"));
        let (genome, out) = (genome.to_string_lossy(), out.to_string_lossy());
        let arguments = ["render", &genome, "--size", "48", "--backend", "cpu", "-o", &out];
        brood(arguments).success();
        let here = image::open(out.as_ref()).unwrap().to_rgba8();
        let path = format!("/v1/individuals/{child}/render.png?size=48");
        assert_eq!(server.get(&path).await.expect(200).picture(), here);
    }
}

#[test]
fn drawn_seed_is_printed_and_reproduces_the_brood() {
    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let drawn = brood(["breed", "--count", "3", "--size", "16", "-o", &here("a")]).success();
    let words: Vec<&str> = drawn.stderr.split_whitespace().collect();
    let seed = words.windows(2).find(|pair| pair[0] == "seed").expect("the seed is printed")[1];
    let rest = ["--count", "3", "--size", "16", "-o", &here("b")];
    let again = brood(["breed", "--seed", seed].iter().chain(&rest)).success();
    assert_eq!(again.stdout, drawn.stdout);
    let other = brood(["breed", "--count", "3", "--size", "16", "-o", &here("c")]).success();
    assert_ne!(other.stdout, drawn.stdout, "each brood draws its own seed");
}

#[tokio::test(flavor = "multi_thread")]
async fn backup_is_complete_when_made_while_the_server_breeds() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("brood.db");
    let (data, target) = (server.data().to_string_lossy(), file.to_string_lossy());
    let arguments = ["backup", target.as_ref(), "--data", data.as_ref()];
    brood(arguments).success();
    assert_eq!(brood(arguments).code, 1, "an existing backup is not overwritten");
    // A server on the backup alone has everything; pictures are derived.
    let restored = TestServer::start_on(ServerOptions::default(), folder);
    let path = format!("/v1/generations/{}", text_of(&generation["id"]));
    assert_eq!(restored.get(&path).await.expect(200).json(), generation);
    let url = text_of(&generation["individuals"][1]["thumbnail"]);
    let picture = restored.get(&url).await.expect(200).body;
    assert_eq!(picture, server.get(&url).await.expect(200).body);
}

#[tokio::test(flavor = "multi_thread")]
async fn database_is_checked_while_the_server_runs_and_compacted_when_it_does_not() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let data = server.data().to_string_lossy().into_owned();
    let run = |words: &[&str]| brood([words, &["--data", &data, "--json"]].concat());
    let json = |words: &[&str]| -> Value {
        serde_json::from_str(&run(words).success().stdout).expect("the answer is JSON")
    };
    let checked = json(&["check"]);
    assert_eq!((&checked["genomes"], &checked["problems"]), (&json!(4), &json!([])));
    let refused = run(&["compact"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("another brood server is using"), "{}", refused.stderr);
    let empty = TempDir::new().unwrap();
    let nothing = brood(["check", "--data", &empty.path().to_string_lossy()]);
    assert!(
        nothing.code == 1 && nothing.stderr.contains("holds no brood.db"),
        "{}",
        nothing.stderr
    );
    assert_eq!(server.terminate(), 0);

    let compacted = json(&["compact"]);
    assert_eq!(compacted["genomes"], 0, "genomes are packed when they are stored");
    server.restart_with(ServerOptions::default());
    let path = format!("/v1/generations/{}", text_of(&generation["id"]));
    assert_eq!(server.get(&path).await.expect(200).json(), generation);
    assert_eq!(server.terminate(), 0);

    let options = SqliteConnectOptions::new().filename(server.data().join("brood.db"));
    let mut database = SqliteConnection::connect_with(&options).await.unwrap();
    let damage = "UPDATE genome SET bytes = x'00' WHERE hash = (SELECT min(hash) FROM genome)";
    sqlx::query(damage).execute(&mut database).await.unwrap();
    database.close().await.unwrap();
    let found = run(&["check"]);
    assert_eq!(found.code, 1);
    assert!(found.stderr.contains("the database is damaged"), "{}", found.stderr);
    let found: Value = serde_json::from_str(&found.stdout).expect("the answer is JSON");
    assert_eq!(found["problems"].as_array().map(Vec::len), Some(1));
}

/// At equal height, field of view and exposure the middle of a wider picture is the square picture.
#[tokio::test(flavor = "multi_thread")]
async fn wide_and_tall_pictures_have_the_pixels_of_the_square_one() {
    let server = TestServer::start();
    let scene = json!({"mesh": "knob", "camera": {"orbit_deg": [40, 25], "distance": 5}, "film": {"exposure": -1}});
    let stored = server.post("/v1/scenes", &scene).await.expect(201).json();
    let body = json!({"name": "shape", "scene": stored["id"], "saturation": 1.0});
    let lineage = TestLineage::with(&server, body).await;
    let child = lineage.random_child(8).await;
    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(here("scene.json"), scene.to_string()).unwrap();
    let individual = server.get(&format!("/v1/individuals/{child}")).await.expect(200).json();
    let path = format!("/v1/genomes/{}", text_of(&individual["hash"]));
    let request = server.request(Method::GET, &path).header("accept", "text/x-brood");
    std::fs::write(here("a.brood"), server.send(request).await.expect(200).body).unwrap();
    let rendered = |size: &str, name: &str, more: &[&str]| {
        let (genome, scene, out) = (here("a.brood"), here("scene.json"), here(name));
        let how = ["--samples", "1", "--backend", "cpu", "--scene", &scene, "--size", size];
        brood([&["render", genome.as_str(), "-o", &out], &how[..], more].concat()).success();
        image::open(out).unwrap()
    };
    let [square, wide, tall] =
        ["64", "96x64", "32x64"].map(|size| rendered(size, "a.png", &[]).to_rgba8());
    assert_eq!((wide.dimensions(), tall.dimensions()), ((96, 64), (32, 64)));
    let crop = |picture: &image::RgbaImage, x: u32, width: u32| {
        image::imageops::crop_imm(picture, x, 0, width, 64).to_image()
    };
    assert_eq!(crop(&wide, 16, 64), square);
    assert_eq!(crop(&square, 16, 32), tall);
    let part = rendered("96x64", "b.png", &["--area", "70,3,26,50"]).to_rgba8();
    assert_eq!(part, image::imageops::crop_imm(&wide, 70, 3, 26, 50).to_image());
    // Linear pictures have the same shape.
    let [square, linear] = [("64", "a.exr"), ("96x64", "b.exr")]
        .map(|(size, name)| rendered(size, name, &[]).to_rgba32f());
    assert_eq!(linear.dimensions(), (96, 64));
    assert_eq!(image::imageops::crop_imm(&linear, 16, 0, 64, 64).to_image(), square);
    // The server renders the same bits.
    let path = |query: &str| format!("/v1/individuals/{child}/render.png?samples=1&size={query}");
    assert_eq!(server.get(&path("96x64")).await.expect(200).picture(), wide);
    assert_eq!(server.get(&path("32x64")).await.expect(200).picture(), tall);
}

#[test]
fn command_fails_with_one_line_and_its_exit_code() {
    let folder = TempDir::new().unwrap();
    let bad = folder.path().join("bad.brood");
    std::fs::write(&bad, "brood 1\n.dialect paper smooth registers 7\nMAX R0, R1, R2\n").unwrap();
    let bad = bad.to_string_lossy();
    let rows: [(i32, &[&str]); 9] = [
        (1, &["inspect", &bad]),
        (1, &["inspect", "nothing-here.brood"]),
        (1, &["render", &bad, "--size", "16", "-o", "never.png"]),
        (2, &["render"]),
        (2, &["render", &bad, "--size", "0x16", "-o", "never.png"]),
        (2, &["render", &bad, "--size", "16x4097", "-o", "never.png"]),
        (2, &["render", &bad, "--size", "16,16", "-o", "never.png"]),
        (1, &["breed", "--size", "32x16", "-o", "never.png"]),
        (2, &["frobnicate"]),
    ];
    for (code, arguments) in rows {
        let refused = brood(arguments);
        assert_eq!(refused.code, code, "{arguments:?}: {}", refused.stderr);
        assert!(!refused.stderr.trim().is_empty());
        assert!(!refused.stderr.contains("panicked"), "{}", refused.stderr);
    }
    let said = brood(["inspect", &bad]).stderr;
    assert!(said.contains('3'), "the error must name the line: {said}");
    assert!(!Path::new("never.png").exists());
}

#[test]
fn presets_are_listed_printed_and_match_their_pictures_on_the_page() {
    let list = brood(["preset"]).success().stdout;
    let names: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 12, "{list}");
    let folder = TempDir::new().unwrap();
    let pictures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../web/presets");
    for name in &names {
        let text = brood(["preset", name]).success().stdout;
        let genome = folder.path().join("preset.brood");
        std::fs::write(&genome, text).unwrap();
        let picture = folder.path().join("preset.png");
        let paths = [&genome, &picture].map(|path| path.to_str().unwrap().to_owned());
        let [genome, picture] = &paths;
        brood(["render", genome, "--size", "96", "--backend", "cpu", "-o", picture]).success();
        let shown = std::fs::read(pictures.join(format!("{name}.png"))).unwrap();
        assert!(
            std::fs::read(picture).unwrap() == shown,
            "web/presets/{name}.png is out of date: render it again and review it"
        );
    }
    let refused = brood(["preset", "lead"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("no preset is named lead"), "{}", refused.stderr);
}

#[test]
fn genome_is_exported_to_a_file_or_to_the_screen() {
    let folder = TempDir::new().unwrap();
    let genome = folder.path().join("gold.brood");
    std::fs::write(&genome, brood(["preset", "gold"]).success().stdout).unwrap();
    let genome = genome.to_str().unwrap();
    let printed = brood(["export", genome, "--format", "wgsl"]).success().stdout;
    assert!(printed.contains("fn evolved(wi: vec3f"), "{printed}");
    let file = folder.path().join("gold.glsl");
    brood(["export", genome, "-o", file.to_str().unwrap()]).success();
    assert!(std::fs::read_to_string(&file).unwrap().contains("vec3 evolved(vec3 wi"));
    let refused = brood(["export", genome, "--format", "cg"]);
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("glsl-es-300, glsl-410, wgsl"), "{}", refused.stderr);
}
