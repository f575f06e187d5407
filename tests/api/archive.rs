//! ZIP archives of several individuals: entries, names, equal bytes, and refused requests.

use std::io::Read;

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::json;

/// Returns the entries of a ZIP file by name, in order.
fn entries(bytes: Vec<u8>) -> Vec<(String, Vec<u8>)> {
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
    assert_eq!(entries(server.get(&twice).await.expect(200).body).len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn archive_is_refused_when_it_names_something_unknown_or_is_too_large() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let id = lineage.random_child(1).await;
    let unknown = "01900000-0000-7000-8000-000000000000";
    let many: Vec<String> = (0..129).map(|n| format!("01900000-0000-7000-8000-{n:012}")).collect();
    let rows = [
        (400, String::new(), "individuals"),
        (400, "individuals=".to_owned(), "is not an id"),
        (400, format!("individuals={id},x"), "x is not an id"),
        (400, format!("individuals={id}&formats=docx"), "glsl-es-300"),
        (400, format!("individuals={id}&size=4096"), "2048"),
        (400, format!("individuals={id}&colour=red"), "colour"),
        (400, format!("individuals={}", many.join(",")), "128"),
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
    let path = format!("/v1/exports.zip?individuals={few}&formats=merl,rgl-bsdf");
    let problem = server.get(&path).await.problem(422);
    let words = "18 tables of 9 individuals; an archive has at most 16";
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

    for (id, format, reason) in
        [(&ids[0], "vrm-mtoon", "clear bodies"), (&ids[1], "wgsl", "by brdf")]
    {
        let path = format!("/v1/exports.zip?individuals={id}&formats={format}");
        let problem = server.get(&path).await.problem(422);
        assert!(text_of(&problem["detail"]).contains(reason), "{problem}");
    }
}
