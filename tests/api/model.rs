//! Reflectance models: listed, printed, evaluated, rendered and refused; bred alone and with
//! programs.

use brood_tests::{TestServer, brood, text_of};
use serde_json::json;
use tempfile::TempDir;

/// Writes a file and returns its path.
fn file(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// Returns the error text of a command that must fail.
fn refused(arguments: &[&str]) -> String {
    let finished = brood(arguments);
    assert_eq!(finished.code, 1, "{}", finished.stdout);
    finished.stderr
}

#[test]
fn every_listed_model_is_printed_and_its_text_is_rendered() {
    let folder = TempDir::new().unwrap();
    let listed: serde_json::Value =
        serde_json::from_str(&brood(["model", "list", "--json"]).success().stdout).unwrap();
    let names = |list: &str| -> Vec<String> {
        let all = listed[list].as_array().unwrap().iter();
        all.map(|entry| entry["name"].as_str().unwrap().to_owned()).collect()
    };
    assert!(names("models").len() >= 15 && names("substances").contains(&"gold".to_owned()));
    for name in names("models").iter().chain(&names("substances")) {
        let text = brood(["model", "show", name]).success().stdout;
        let model = file(&folder, "model.brood", &text);
        let out = folder.path().join(format!("{name}.png")).to_string_lossy().into_owned();
        brood(["render", &model, "--size", "24", "-o", &out]).success();
        let picture = image::open(&out).unwrap().to_rgba8();
        assert!(picture.pixels().any(|pixel| pixel.0[0] > 40), "{name} is black");
        let albedo = brood(["model", "albedo", &model, "--order", "8"]).success().stdout;
        assert_eq!(albedo.lines().count(), 16, "{albedo}");
        assert!(albedo.lines().last().unwrap().starts_with("# at most "), "{albedo}");
    }
}

#[test]
fn a_lambert_model_and_a_genome_of_the_same_colour_make_the_same_picture() {
    let folder = TempDir::new().unwrap();
    let model = file(&folder, "model.brood", "brood 1\n.model lambert\nalbedo 0.25 0.25 0.25\n");
    // f = 0.25 / pi
    let genome = "brood 1\n.dialect paper smooth registers 7\n.scale 0.07957747 0.07957747 0.07957747\n\
                  .const C0 1 1 1 0\nMOV R0, C0\n";
    let genome = file(&folder, "genome.brood", genome);
    let picture = |material: &str| {
        let out = folder.path().join("out.png").to_string_lossy().into_owned();
        let how = ["--size", "64", "--exposure", "0", "--mesh", "knob", "--backend", "cpu"];
        brood([&["render", material, "-o", &out][..], &how[..]].concat()).success();
        image::open(&out).unwrap().to_rgba8()
    };
    let (one, other) = (picture(&model), picture(&genome));
    let off = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 1;
    assert!(!one.as_raw().iter().zip(other.as_raw()).any(off), "the pictures differ");
}

#[test]
fn values_equal_the_model_and_invalid_files_are_refused_with_the_line() {
    let folder = TempDir::new().unwrap();
    let model = file(&folder, "model.brood", "brood 1\n.model lambert\nalbedo 0.5 0.25 1\n");
    let pairs =
        file(&folder, "pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0.6,0,0.8\n0,0,1,0,0,-1\n");
    let found = brood(["eval", &model, &pairs]).success().stdout;
    let rows: Vec<&str> = found.lines().collect();
    assert_eq!(rows[0], "r,g,b");
    let values: Vec<f64> = rows[1].split(',').map(|cell| cell.parse().unwrap()).collect();
    for (value, albedo) in values.iter().zip([0.5, 0.25, 1.0]) {
        assert!((value * std::f64::consts::PI - albedo).abs() < 1e-7, "{found}");
    }
    assert_eq!(rows[2], "0,0,0");
    let bad = file(&folder, "bad.brood", "brood 1\n.model ward\n\nalpha_x 3\n");
    let error = refused(&["render", &bad, "-o", "x.png"]);
    assert!(
        error.contains("line 4, column 9: alpha_x must be between 0.001 and 1, got 3"),
        "{error}"
    );
    let source = brood(["export", &model]).success().stdout;
    assert!(source.contains("vec3 evolved(") && source.contains("lambert"), "{source}");
}

#[test]
fn layers_add_up_and_obey_the_energy_limit() {
    let folder = TempDir::new().unwrap();
    let head = "brood 1\n.dialect paper smooth registers 7\n.const C0 1 1 1 0\n";
    // pi f is 0.7 from the models and pi from the program.
    let layers = ".model lambert\nalbedo 0.5 0.5 0.5\n.model lambert\nalbedo 0.2 0.2 0.2\n";
    let both = file(&folder, "both.brood", &format!("{head}{layers}MOV R0, C0\n"));
    let albedo = |file: &str| -> f64 {
        let text = brood(["model", "albedo", file, "--order", "16"]).success().stdout;
        text.lines().nth(1).unwrap().split(',').nth(1).unwrap().parse().unwrap()
    };
    assert!((albedo(&both) - 0.7 - std::f64::consts::PI).abs() < 0.01);
    let held = file(&folder, "held.brood", &format!("{head}{layers}.limit on\nMOV R0, C0\n"));
    let found = albedo(&held);
    assert!((0.98..=1.0).contains(&found), "{found}");
    let inspected = brood(["inspect", &held, "--json"]).success().stdout;
    let inspected: serde_json::Value = serde_json::from_str(&inspected).unwrap();
    assert!(inspected["code"].as_str().unwrap().contains("g^2 + lambert + lambert"), "{inspected}");
    assert_eq!(inspected["physics"]["not_reciprocal"], 0);
}

#[test]
fn models_are_bred_on_the_command_line_like_programs() {
    let folder = TempDir::new().unwrap();
    let place = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let breed = |options: &[&str], out: &str| {
        let how = ["breed", "--seed", "3", "--count", "4", "--size", "16", "-o", out];
        brood([&how[..], options].concat()).success();
        let text = |slot: u32| std::fs::read_to_string(format!("{out}/{slot:02}.brood")).unwrap();
        (0..4).map(text).collect::<Vec<String>>()
    };
    let (start, again) = (place("start"), place("again"));
    let born = breed(&["--models"], &start);
    assert_eq!(born, breed(&["--models"], &again));
    assert!(born.iter().all(|text| text.starts_with("brood 1\n.model ")), "{born:?}");
    let (first, second) = (format!("{start}/00.brood"), format!("{start}/01.brood"));
    let parents = ["--parent", &first, "--parent", &second];
    let crossed = breed(&parents, &place("crossed"));
    assert!(crossed.iter().all(|text| !born.contains(text)));
    let gold = file(&folder, "gold.brood", "brood 1\n.model conductor\nroughness 0.125\n");
    let locked = ["--parent", &gold, "--mutation", "1", "--lock", "L0.roughness"];
    let children = breed(&locked, &place("locked"));
    assert!(children.iter().all(|text| text.contains("\nroughness 0.125\n")), "{children:?}");
    assert!(children.iter().all(|text| text.contains(".model conductor")));
    let error = refused(&["breed", "--parent", &gold, "--lock", "L1", "-o", &place("none")]);
    assert!(error.contains("there is no layer 1: the parent has 1"), "{error}");
}

#[tokio::test(flavor = "multi_thread")]
async fn lineage_of_models_is_bred_recombined_with_programs_exported_and_imported() {
    let server = TestServer::start();
    let dialect = json!({"length": 0});
    let body = json!({"name": "metals", "dialect": dialect, "thumbnail_px": 16});
    let lineage = server.post("/v1/lineages", &body).await.expect(201).json();
    let lineage = format!("/v1/lineages/{}", text_of(&lineage["id"]));
    let generations = format!("{lineage}/generations");
    let body = json!({"parents": [], "count": 20, "seed": 5, "curation": "diverse"});
    let born = server.post(&generations, &body).await.expect(201).json();
    let one = &born["individuals"][0];
    assert_eq!(born["individuals"].as_array().unwrap().len(), 20);
    for individual in born["individuals"].as_array().unwrap() {
        server.get(&text_of(&individual["thumbnail"])).await.expect(200).picture();
    }
    let genome = format!("/v1/genomes/{}", text_of(&one["hash"]));
    let genome = server.get(&genome).await.expect(200).json();
    assert_eq!(genome["instructions"], json!([]));
    let parameters = genome["layers"][0]["parameters"].as_object().unwrap();
    let name = parameters.keys().next().unwrap();
    let locks = json!({"parameters": [{"layer": 0, "name": name}]});
    let body =
        json!({"parents": [one["id"]], "count": 6, "seed": 1, "mutation": 1, "locks": locks});
    let bred = server.post(&generations, &body).await.expect(201).json();
    for child in bred["individuals"].as_array().unwrap() {
        let child = format!("/v1/genomes/{}", text_of(&child["hash"]));
        let child = server.get(&child).await.expect(200).json();
        assert_eq!(child["layers"][0]["parameters"][name], parameters[name]);
    }
    let locks = json!({"parameters": [{"layer": 0, "name": "shine"}]});
    let body = json!({"parents": [one["id"]], "count": 6, "seed": 1, "locks": locks});
    let problem = server.post(&generations, &body).await.expect(422).json();
    assert_eq!(problem["pointer"], "/locks/parameters/0/name", "{problem}");
    let body = json!({"presets": ["velvet"]});
    let adopted = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
    let velvet = &adopted["individuals"][0];
    let body = json!({"parents": [one["id"], velvet["id"]], "count": 8, "seed": 2});
    let crossed = server.post(&generations, &body).await.expect(201).json();
    assert_eq!(crossed["individuals"].as_array().unwrap().len(), 8);
    let body = json!({"presets": ["brushed-metal"]});
    let adopted = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
    let metal = &adopted["individuals"][0];
    let body = json!({"parents": [velvet["id"], metal["id"]], "count": 8, "seed": 2});
    let problem = server.post(&generations, &body).await.expect(422).json();
    assert_eq!(problem["pointer"], "/parents/1", "{problem}");
    let export = format!("/v1/individuals/{}/exports/glsl-410", text_of(&one["id"]));
    let source = server.get(&export).await.expect(200).text();
    assert!(source.contains("vec3 evolved_models(vec3 wi, vec3 wo)"), "{source}");
    let render = format!("/v1/individuals/{}/render.png?size=48", text_of(&one["id"]));
    let picture = server.get(&render).await.expect(200).body;
    let file = server.get(&format!("{lineage}/file")).await.expect(200).body;
    let other = TestServer::start();
    let imported = other.post_bytes("/v1/lineages/import", "application/json", file).await;
    let id = text_of(&imported.expect(201).json()["id"]).to_owned();
    let there = other.get(&format!("/v1/lineages/{id}/generations")).await.expect(200).json();
    let oldest = there["items"].as_array().unwrap().iter().find(|item| item["seed"] == 5).unwrap();
    let twin = &oldest["individuals"][0];
    assert_eq!(twin["hash"], one["hash"]);
    let render = format!("/v1/individuals/{}/render.png?size=48", text_of(&twin["id"]));
    assert_eq!(other.get(&render).await.expect(200).body, picture);
}

#[tokio::test(flavor = "multi_thread")]
async fn individuals_list_their_models_when_bred_and_when_read() {
    let server = TestServer::start();
    let new = json!({"name": "models"});
    let lineage = server.post("/v1/lineages", &new).await.expect(201).json();
    let base = format!("/v1/lineages/{}", text_of(&lineage["id"]));
    let presets = json!({"presets": ["red-plastic", "model-two-layers"]});
    let born = server.post(&format!("{base}/adoptions"), &presets).await.expect(201).json();
    let id = text_of(&born["individuals"][1]["id"]);
    let again = server.get(&format!("/v1/individuals/{id}")).await.expect(200).json();
    assert!(born["individuals"][0].get("layers").is_none(), "{born}");
    for one in [&born["individuals"][1], &again] {
        assert_eq!(one["layers"], json!(["lambert", "ward", "cook-torrance"]));
    }
    let genome =
        server.get(&format!("/v1/genomes/{}", text_of(&again["hash"]))).await.expect(200).json();
    let names: Vec<_> =
        genome["layers"].as_array().unwrap().iter().map(|one| one["model"].clone()).collect();
    assert_eq!(json!(names), again["layers"]);
}

#[test]
fn materials_are_compared_by_pictures_curves_and_values() {
    let folder = TempDir::new().unwrap();
    let metal = file(&folder, "metal.brood", "brood 1\n.model conductor\n");
    let matt = file(&folder, "a, <b>.brood", "brood 1\n.model lambert\n");
    let out = folder.path().join("out");
    let place = out.to_string_lossy().into_owned();
    let arguments = ["compare", &metal, &matt, &metal, "--size", "32", "--json", "-o", &place];
    let report: serde_json::Value =
        serde_json::from_str(&brood(arguments).success().stdout).unwrap();
    let [first, second, third] = [0, 1, 2].map(|index| &report["materials"][index]);
    assert!(first["difference"].is_null() && second["difference"]["rmse"].as_f64() > Some(0.01));
    assert_eq!(third["difference"]["rmse"], 0.0);
    assert_eq!(second["phenomena"]["highlight"], json!([0.0, 0.0, 0.0]));
    assert_eq!(first["curves"].as_array().unwrap().len(), 20);
    let text = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert!(text("curves.csv").contains("\n\"a, <b>\",0,"));
    assert!(text("albedo.svg").starts_with("<svg") && text("fresnel.svg").contains("metal"));
    let page = text("index.html");
    assert!(page.contains("a, &lt;b&gt;") && !page.contains("<b>"), "{page}");
    for name in ["00-picture.png", "01-difference.png", "02-other-light.png"] {
        assert!(page.contains(name), "{name}");
        assert_eq!(image::open(out.join(name)).unwrap().to_rgb8().dimensions(), (32, 32));
    }
    assert_eq!(brood(["compare", &metal, "-o", &place]).code, 2);
}

#[test]
fn measurements_are_rendered_and_evaluated_and_invalid_ones_are_refused_with_the_row() {
    let folder = TempDir::new().unwrap();
    let head = "wix,wiy,wiz,wox,woy,woz,r,g,b\n";
    let rows = "0,0,1,0,0,1,0.25,0.125,0.5\n0.6,0,0.8,0,0,1,0.25,0.125,0.5\n0,0,-1,0,0,1,9,9,9\n";
    let csv = file(&folder, "even.csv", &format!("{head}{rows}"));
    let text = file(&folder, "even.brdf", "# grey\n2\n500 600\n0 0 0.5 0 0.25 0.25\n");
    let pairs = file(&folder, "pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0.6,0,0.8,0,0.6,0.8\n");
    for (material, wanted) in [(&csv, [0.25, 0.125, 0.5]), (&text, [0.25; 3])] {
        let found = brood(["eval", material, &pairs]).success();
        let row = found.stdout.lines().nth(1).unwrap();
        let values: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        for (value, wanted) in values.iter().zip(wanted) {
            assert!((value - wanted).abs() < 1e-12, "{row}");
        }
        let out = folder.path().join("out.png").to_string_lossy().into_owned();
        brood(["render", material, "--size", "24", "--swap", "-o", &out]).success();
        let picture = image::open(&out).unwrap().to_rgba8();
        assert!(picture.pixels().any(|pixel| pixel.0[0] > 40), "{material} is black");
    }
    let skipped = brood(["eval", &csv, &pairs]).success().stderr;
    assert!(skipped.contains("1 of 3 samples are not above the surface"), "{skipped}");
    let bad = file(&folder, "bad.csv", &format!("{head}0,0,1,0,0,2,1,1,1\n"));
    let error = refused(&["model", "albedo", &bad]);
    assert!(
        error.contains("row 1: wo: the length of the direction must be 1 within 0.001, got 2"),
        "{error}"
    );
    let formula = file(&folder, "formula.brdf", "analytic\n::begin parameters\n");
    assert!(refused(&["eval", &formula, &pairs]).contains("formula in GLSL"));
    let tensor = file(&folder, "cut.bsdf", "tensor_file");
    assert!(refused(&["eval", &tensor, &pairs]).contains("it ends within its head"));
}

/// Returns RGL tables of a material with a constant BRDF.
fn even_bsdf(rgb: [f32; 3]) -> Vec<u8> {
    let one = |count: usize| vec![1.0_f32; count];
    let colours = rgb.iter().flat_map(|value| [*value; 4]).collect::<Vec<_>>();
    let fields: [(&str, &[u64], Vec<f32>); 6] = [
        ("phi_i", &[1], vec![0.0]),
        ("theta_i", &[2], vec![0.0, 1.5]),
        ("ndf", &[2, 2], one(4)),
        ("sigma", &[2, 2], one(4)),
        ("vndf", &[1, 2, 2, 2], one(8)),
        ("rgb", &[1, 2, 3, 2, 2], colours.repeat(2)),
    ];
    let (mut head, mut body) = (b"tensor_file\0\x01\0".to_vec(), Vec::<u8>::new());
    head.extend(7_u32.to_le_bytes());
    let flag: (&str, &[u64]) = ("jacobian", &[1]);
    let sizes = fields.iter().map(|(name, shape, _)| (*name, *shape));
    let heads = |(name, shape): (&str, &[u64])| 13 + name.len() + 8 * shape.len();
    let start = head.len() + sizes.clone().chain([flag]).map(heads).sum::<usize>();
    let mut put = |(name, shape): (&str, &[u64]), (kind, bytes): (u8, &[u8])| {
        head.extend(u16::try_from(name.len()).unwrap().to_le_bytes());
        head.extend(name.as_bytes());
        head.extend(u16::try_from(shape.len()).unwrap().to_le_bytes());
        head.push(kind);
        head.extend(((start + body.len()) as u64).to_le_bytes());
        head.extend(shape.iter().flat_map(|size| size.to_le_bytes()));
        body.extend(bytes);
    };
    for (size, (.., numbers)) in sizes.zip(&fields) {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        put(size, (10, &bytes));
    }
    put(flag, (1, &[1]));
    head.extend(body);
    head
}

#[test]
fn negative_values_of_rgl_are_kept_when_requested() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("blue.bsdf");
    std::fs::write(&path, even_bsdf([0.5, -0.25, 2.0])).unwrap();
    let material = path.to_string_lossy().into_owned();
    let pairs = file(&folder, "pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0.6,0,0.8,0,0.6,0.8\n");
    let values = |options: &[&str]| -> Vec<f64> {
        let found = brood([&["eval", &material, &pairs], options].concat()).success().stdout;
        let row = found.lines().nth(1).unwrap();
        row.split(',').map(|cell| cell.parse().unwrap()).collect()
    };
    let (plain, kept) = (values(&[]), values(&["--keep-negative"]));
    assert_eq!((plain[0], 0.0, plain[2]), (kept[0], plain[1], kept[2]));
    assert!((kept[1] / kept[0] + 0.5).abs() < 1e-9, "{kept:?}");
    let least = |options: &[&str]| -> f32 {
        let out = folder.path().join("out.exr").to_string_lossy().into_owned();
        let words = ["render", &material, "--size", "24", "-o", &out];
        brood([&words, options].concat()).success();
        let picture = image::open(&out).unwrap().to_rgba32f();
        picture.pixels().map(|pixel| pixel.0[1]).fold(f32::INFINITY, f32::min)
    };
    assert_eq!(least(&[]), 0.0);
    assert!(least(&["--keep-negative"]) < -0.01);
    let metal = file(&folder, "metal.brood", &brood(["model", "show", "gold"]).success().stdout);
    let csv = file(&folder, "a.csv", "wix,wiy,wiz,wox,woy,woz,r,g,b\n0,0,1,0,0,1,1,1,1\n");
    for other in [&metal, &csv] {
        for words in [["render", other, "-o", "out.exr"], ["eval", other, &pairs, "--json"]] {
            let error = refused(&[&words[..], &["--keep-negative"]].concat());
            assert!(error.contains("--keep-negative needs an RGL .bsdf"), "{error}");
        }
    }
}
