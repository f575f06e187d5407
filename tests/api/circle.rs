//! Pictures over the light's whole circle: animations, animated sheets, strips, and their common
//! exposure.

use brood_tests::{TestLineage, TestServer, ids, text_of};
use serde_json::json;

/// Returns the names of a PNG's chunks.
fn chunks(bytes: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    let mut at = 8;
    while at < bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        names.push(String::from_utf8(bytes[at + 4..at + 8].to_vec()).unwrap());
        at += length + 12;
    }
    names
}

#[tokio::test(flavor = "multi_thread")]
async fn strip_and_animation_show_the_light_going_around() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let id = &lineage.random_child(4).await;
    let path = format!("/v1/individuals/{id}/strip.png?size=40&frames=8");
    let strip = server.get(&path).await.expect(200);
    let picture = strip.picture();
    assert_eq!(picture.dimensions(), (320, 40));
    // Each picture equals the one requested alone, at the exposure of the whole circle.
    let detail = server.get(&format!("/v1/individuals/{id}")).await.expect(200).json();
    let exposure = detail["exposure_ev"].as_f64().unwrap();
    let scene = json!({"film": {"exposure": exposure}});
    let scene = server.post("/v1/scenes", &scene).await.expect(201).json();
    for place in [0u32, 3] {
        let (scene, degrees) = (text_of(&scene["id"]), 45 * place);
        let path =
            format!("/v1/individuals/{id}/render.png?size=40&scene={scene}&light_deg={degrees}");
        let alone = server.get(&path).await.expect(200).picture();
        let cell = image::imageops::crop_imm(&picture, 40 * place, 0, 40, 40).to_image();
        assert!(cell == alone, "place {place}");
    }
    let path = format!("/v1/individuals/{id}/render.apng?size=40&frames=8&seconds=2");
    let animation = server.get(&path).await.expect(200);
    assert_eq!(animation.header("content-type"), "image/apng");
    let count = |name: &str| chunks(&animation.body).iter().filter(|one| *one == name).count();
    assert_eq!((count("acTL"), count("fcTL"), count("fdAT") > 6), (1, 8, true));
    let first = image::imageops::crop_imm(&picture, 0, 0, 40, 40).to_image();
    assert!(animation.picture() == first, "a reader without animation shows the first picture");
    let tag = animation.header("etag");
    let again = server.request(reqwest::Method::GET, &path).header("if-none-match", tag);
    server.send(again).await.expect(304);
    for (query, status) in [("frames=1", 400), ("size=4", 400), ("seconds=0", 400), ("fps=3", 400)]
    {
        server.get(&format!("/v1/individuals/{id}/render.apng?{query}")).await.problem(status);
    }
    server.get(&format!("/v1/individuals/{id}/strip.png?size=1024&frames=120")).await.problem(422);
}

#[tokio::test(flavor = "multi_thread")]
async fn sheet_of_a_generation_is_animated_around_its_centre() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = lineage.random(4).await;
    let body = json!({"parents": [ids(&first)[0]], "seed": 9});
    let generation = lineage.breed(body).await;
    let path =
        format!("/v1/generations/{}/sheet.apng?size=24&frames=4", text_of(&generation["id"]));
    let animation = server.get(&path).await.expect(200);
    let still = format!("/v1/generations/{}/sheet.png", text_of(&generation["id"]));
    let still = server.get(&still).await.expect(200).picture();
    assert_eq!(still.dimensions().0, still.dimensions().1);
    let shown = animation.picture();
    assert_eq!(shown.dimensions().0, 6 * 24 + 7, "six cells and the gaps around them");
    assert_eq!(chunks(&animation.body).iter().filter(|name| *name == "fcTL").count(), 4);
}

#[tokio::test(flavor = "multi_thread")]
async fn lineages_are_listed_with_the_picture_of_a_favourite_or_of_the_newest_centre() {
    let server = TestServer::start();
    let empty = TestLineage::new(&server).await;
    let lineage = TestLineage::new(&server).await;
    let cover = async |id: &str| {
        let list = server.get("/v1/lineages").await.expect(200).json();
        let items = list["items"].as_array().unwrap();
        items.iter().find(|one| one["id"] == json!(id)).unwrap()["cover"].clone()
    };
    let first = lineage.random(4).await;
    assert_eq!(cover(&lineage.id).await, first["individuals"][0]["thumbnail"]);
    let second = lineage.breed(json!({"parents": [ids(&first)[2]], "count": 3})).await;
    assert_eq!(cover(&lineage.id).await, second["centre"]["thumbnail"]);
    let starred = &first["individuals"][3];
    let path = format!("/v1/individuals/{}", text_of(&starred["id"]));
    server.patch(&path, Some("\"1\""), &json!({"favourite": true})).await.expect(200);
    let url = cover(&lineage.id).await;
    assert_eq!(url, starred["thumbnail"]);
    server.get(&text_of(&url)).await.expect(200).picture();
    assert!(cover(&empty.id).await.is_null());
}
