//! ZIP archives of several individuals, of a brood and of a search's front: entries, names, equal
//! bytes, manifest, and refused requests.

use std::io::Read;

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

/// Returns the entries of a ZIP file by name, in order.
pub fn entries(bytes: Vec<u8>) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    (0..archive.len())
        .map(|index| {
            let mut entry = archive.by_index(index).unwrap();
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).unwrap();
            (entry.name().unwrap().into_owned(), bytes)
        })
        .collect()
}

/// Returns the manifest: the last entry.
pub fn manifest(entries: &[(String, Vec<u8>)]) -> Value {
    let (name, bytes) = entries.last().unwrap();
    assert_eq!(name, "manifest.json");
    serde_json::from_slice(bytes).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn archive_has_the_files_of_single_downloads_with_readable_names() {
    let server = TestServer::start();
    let first = TestLineage::with(&server, json!({"name": "Étude / 1", "thumbnail_px": 32})).await;
    let second = TestLineage::new(&server).await;
    let (one, other) = (first.random(1).await, second.random(2).await);
    let (one_id, other_id) = (ids(&one).swap_remove(2), ids(&other).swap_remove(0));
    let path =
        format!("/v1/exports.zip?individuals={one_id},{other_id}&formats=brood,png,wgsl&size=64");
    let answer = server.get(&path).await.expect(200);
    assert_eq!(answer.header("content-type"), "application/zip");
    assert!(answer.header("content-disposition").contains("brood-materials.zip"));

    let found = entries(answer.body.clone());
    let names: Vec<_> = found.iter().map(|(name, _)| name.as_str()).collect();
    let mark = |generation, slot: usize| hashes(generation)[slot][..4].to_owned();
    let (one_mark, other_mark) = (mark(&one, 2), mark(&other, 0));
    let expected = ["brood", "png", "wgsl"].map(|ending| format!("étude-1-{one_mark}.{ending}"));
    assert_eq!(names[..3], expected);
    assert_eq!(names[3], format!("first-{other_mark}.brood"));
    for (index, single) in [
        (1, format!("/v1/individuals/{one_id}/render.png?size=64")),
        (2, format!("/v1/individuals/{one_id}/exports/wgsl")),
        (4, format!("/v1/individuals/{other_id}/render.png?size=64")),
    ] {
        assert_eq!(found[index].1, server.get(&single).await.expect(200).body, "{single}");
    }
    assert!(found[0].1.starts_with(b"brood 1\n"));
    assert_eq!(server.get(&path).await.expect(200).body, answer.body, "the same bytes again");

    let twice = format!("/v1/exports.zip?individuals={one_id},{one_id}&formats=brood,brood");
    let found = entries(server.get(&twice).await.expect(200).body);
    assert_eq!(found.len(), 2, "a genome and the manifest");
}

#[tokio::test(flavor = "multi_thread")]
async fn archive_is_refused_when_it_names_something_unknown_or_is_too_large() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let id = lineage.random_child(1).await;
    let unknown = "01900000-0000-7000-8000-000000000000";
    let many: Vec<String> = (0..257).map(|n| format!("01900000-0000-7000-8000-{n:012}")).collect();
    let rows = [
        (400, String::new(), "individuals"),
        (400, "individuals=".to_owned(), "is not an id"),
        (400, format!("individuals={id},x"), "x is not an id"),
        (400, format!("individuals={id}&formats=docx"), "glsl-es-300"),
        (400, format!("individuals={id}&size=4096"), "2048"),
        (400, format!("individuals={id}&colour=red"), "colour"),
        (422, format!("individuals={}", many.join(",")), "256"),
        (400, format!("individuals={id}&generation={unknown}"), "exactly one"),
        (400, "generation=x".to_owned(), "generation"),
        (404, format!("generation={unknown}"), ""),
        (404, format!("job={unknown}"), ""),
        (404, format!("individuals={id},{unknown}"), ""),
    ];
    for (status, query, words) in rows {
        let answer = server.get(&format!("/v1/exports.zip?{query}")).await;
        let problem = answer.problem(status);
        assert!(text_of(&problem["detail"]).contains(words), "{query}: {problem}");
    }
    let few = ids(&lineage.breed(json!({"parents": [], "count": 9, "seed": 3})).await).join(",");
    let path = format!("/v1/exports.zip?individuals={few}&size=2048");
    let problem = server.get(&path).await.problem(422);
    assert!(text_of(&problem["detail"]).contains("33554432"), "{problem}");
    let many = lineage.breed(json!({"parents": [], "count": 17, "seed": 4})).await;
    let path = format!("/v1/exports.zip?generation={}&formats=rgl-bsdf", text_of(&many["id"]));
    let problem = server.get(&path).await.problem(422);
    let words = "17 tables; an archive has at most 16";
    assert!(text_of(&problem["detail"]).contains(words), "{problem}");
}

#[tokio::test(flavor = "multi_thread")]
async fn archive_leaves_out_what_paint_cannot_be_exported_as() {
    let server = TestServer::start();
    let body = json!({"name": "paint", "dialect": {"length": 0}, "thumbnail_px": 32});
    let made = server.post("/v1/lineages", &body).await.expect(201).json();
    let path = format!("/v1/lineages/{}/adoptions", text_of(&made["id"]));
    let presets =
        json!({"presets": ["paint-glass", "paint-gold-toon", "paint-toon", "model-gold"]});
    let made = server.post(&path, &presets).await.expect(201).json();
    let ids = ids(&made);
    let all = ids.join(",");
    let path = format!("/v1/exports.zip?individuals={all}&formats=brood,wgsl,vrm-mtoon");
    let found = entries(server.get(&path).await.expect(200).body);
    let endings = |ending: &str| found.iter().filter(|(name, _)| name.ends_with(ending)).count();
    assert_eq!((endings(".brood"), endings(".wgsl"), endings(".mtoon.json")), (4, 3, 0));
    let manifest = manifest(&found);
    let left_out = manifest["materials"][1]["left_out"].as_array().unwrap();
    assert_eq!(left_out.len(), 2, "{manifest}");
    assert_eq!(left_out[0]["format"], "wgsl");
    assert!(text_of(&left_out[0]["reason"]).contains("by brdf"), "{manifest}");

    for (id, format, reason) in
        [(&ids[0], "vrm-mtoon", "clear bodies"), (&ids[1], "wgsl", "by brdf")]
    {
        let path = format!("/v1/exports.zip?individuals={id}&formats={format}");
        let problem = server.get(&path).await.problem(422);
        assert!(text_of(&problem["detail"]).contains(reason), "{problem}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn whole_brood_is_archived_with_places_and_the_errors_of_tables() {
    let server = TestServer::start();
    let lineage = TestLineage::with(&server, json!({"name": "Brood", "thumbnail_px": 32})).await;
    let brood = lineage.random(1).await;
    let path = format!(
        "/v1/exports.zip?generation={}&formats=brood,merl,samples-csv,png&size=32",
        text_of(&brood["id"])
    );
    let found = entries(server.get(&path).await.expect(200).body);
    let manifest = manifest(&found);
    assert_eq!(manifest["generation"], brood["id"]);
    assert_eq!(manifest["size"], 32);
    let materials = manifest["materials"].as_array().unwrap();
    let listed = materials.iter().map(|one| text_of(&one["individual"])).collect::<Vec<_>>();
    assert_eq!(listed, ids(&brood));
    let mut names = Vec::new();
    for ((place, material), hash) in (1..).zip(materials).zip(hashes(&brood)) {
        assert_eq!((&material["place"], &material["hash"]), (&json!(place), &json!(hash)));
        let formats: Vec<_> = material["files"].as_array().unwrap().iter().collect();
        assert_eq!(formats.len(), 3, "random programs are anisotropic: {material}");
        assert_eq!(material["left_out"][0]["format"], "merl");
        assert!(text_of(&formats[1]["note"]).contains("8192 samples"), "{material}");
        assert!(formats[0]["note"].is_null() && formats[2]["note"].is_null());
        names.extend(formats.iter().map(|file| text_of(&file["name"])));
        assert!(names.last().unwrap().starts_with(&format!("brood-0{place}-{}", &hash[..4])));
    }
    names.push("manifest.json".to_owned());
    assert!(found.iter().map(|(name, _)| name).eq(&names), "{names:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn front_of_a_search_is_archived_by_rank_with_errors_and_costs() {
    let server = TestServer::start();
    let body = json!({
        "kind": "fit", "target": server.glossy_target().await, "name": "Été 1", "threads": 1,
        "strategy": "lobes", "generations": 3,
    });
    let id = text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    server.job_once(&id, |job| job["state"] == "succeeded").await;
    let front = server.get(&format!("/v1/jobs/{id}/front")).await.expect(200).json();
    let front = front["items"].as_array().unwrap();
    assert!(front.len() > 1, "{front:?}");
    let path = format!("/v1/exports.zip?job={id}&formats=glsl-es-300,brood");
    let found = entries(server.get(&path).await.expect(200).body);
    let manifest = manifest(&found);
    assert_eq!(manifest["job"], json!(id));
    let materials = manifest["materials"].as_array().unwrap();
    assert_eq!((materials.len(), found.len()), (front.len(), 2 * front.len() + 1));
    for (rank, (material, known)) in (1..).zip(materials.iter().zip(front)) {
        assert_eq!(material["place"], json!(rank));
        for field in ["e_log", "e_cbrt", "relative_l2", "operations", "numbers", "divisor"] {
            assert_eq!(material["found"][field], known[field], "{field}");
        }
        let name = text_of(&material["files"][0]["name"]);
        assert!(name.starts_with(&format!("été-1-{rank:02}-")), "{name}");
        let single =
            format!("/v1/individuals/{}/exports/glsl-es-300", text_of(&known["individual"]));
        let single = server.get(&single).await.expect(200).body;
        assert!(found.contains(&(name, single)));
    }
}
