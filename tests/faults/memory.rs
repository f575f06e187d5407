//! Memory that a request takes: the peak of the server's process above its rest, for inputs that
//! are small on the wire and large when decoded, and for lineages with long histories.

use std::fs;
use std::io::{Cursor, Write};
use std::time::Duration;

use brood_tests::{TestServer, text_of};
use futures::future::join_all;
use serde_json::Value;

use super::import::long_file;

const REQUEST_MIB: u64 = 256;
const MIX_MIB: u64 = 512;

/// Memory of a process in MiB: `VmRSS` or `VmHWM`.
fn memory_mib(process: u32, name: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    line.trim_matches(|c: char| !c.is_ascii_digit()).parse::<u64>().unwrap() / 1024
}

/// Runs requests and checks the peak of the server's memory.
async fn within<T>(
    server: &TestServer,
    what: &str,
    most_mib: u64,
    requests: impl Future<Output = T>,
) -> T {
    // Lets the server finish what came before.
    tokio::time::sleep(Duration::from_millis(300)).await;
    let process = server.process();
    fs::write(format!("/proc/{process}/clear_refs"), "5").unwrap();
    let rest = memory_mib(process, "VmRSS:");
    let answer = requests.await;
    let peak = memory_mib(process, "VmHWM:").saturating_sub(rest);
    println!("fault: memory: {what}: {peak} MiB above {rest} MiB, at most {most_mib}");
    assert!(peak <= most_mib, "{what}: {peak} MiB");
    answer
}

/// PNG of one colour with 16 bits a channel.
fn deep_png(side: u32) -> Vec<u8> {
    let pixels = vec![0x80; 8 * side as usize * side as usize];
    let mut png = Cursor::new(Vec::new());
    let color = image::ColorType::Rgba16;
    let format = image::ImageFormat::Png;
    image::write_buffer_with_format(&mut png, &pixels, side, side, color, format).unwrap();
    png.into_inner()
}

/// Radiance HDR file of one colour, in runs.
fn hdr(width: u16, height: u16) -> Vec<u8> {
    let mut file = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    let mut row = vec![2, 2];
    row.extend(width.to_be_bytes());
    for value in [128, 128, 128, 129] {
        let mut left = width;
        while left > 0 {
            let run = left.min(127);
            row.extend([128 + run as u8, value]);
            left -= run;
        }
    }
    let mut bytes = std::mem::take(&mut file).into_bytes();
    (0..height).for_each(|_| bytes.write_all(&row).unwrap());
    bytes
}

#[tokio::test(flavor = "multi_thread")]
async fn decoded_pictures_are_bounded() {
    let server = TestServer::start();
    let image = deep_png(4096);
    let kind = "image/png";
    within(&server, "PNG of 4096 x 4096, 16 bits", REQUEST_MIB, async {
        server.post_bytes("/v1/images", kind, image.clone()).await.expect(201);
    })
    .await;
    let environment = hdr(4096, 2048);
    let kind = "image/vnd.radiance";
    within(&server, "environment of 4096 x 2048", REQUEST_MIB, async {
        server.post_bytes("/v1/environments", kind, environment.clone()).await.expect(201);
    })
    .await;
    let large = hdr(8192, 4096);
    let refused = within(&server, "environment of 8192 x 4096", 64, async {
        server.post_bytes("/v1/environments", kind, large).await.problem(413)
    })
    .await;
    assert!(text_of(&refused["detail"]).contains("8192 x 4096: scale it down"), "{refused}");
}

#[tokio::test(flavor = "multi_thread")]
async fn files_of_long_lineages_are_streamed() {
    let server = TestServer::start();
    // 100,000 individuals with one genome: 20 MB.
    let file = long_file(&server, 391).await;
    let body = file.to_string();
    let imported = within(&server, "import of 20 MB", REQUEST_MIB, async {
        let answer = server.post_bytes("/v1/lineages/import", "application/json", body).await;
        answer.expect(201).json()
    })
    .await;
    let path = format!("/v1/lineages/{}/file", text_of(&imported["id"]));
    let exported = within(&server, "export of 20 MB", REQUEST_MIB, async {
        server.get(&path).await.expect(200).json()
    })
    .await;
    assert_eq!(exported["genomes"], file["genomes"]);
    let count = |file: &Value| -> usize {
        let generations = file["generations"].as_array().unwrap().iter();
        generations.map(|one| one["individuals"].as_array().unwrap().len()).sum()
    };
    assert_eq!(count(&exported), 391 * 256);
    within(&server, "ten exports of 20 MB", MIX_MIB, async {
        for one in join_all((0..10).map(|_| server.get(&path))).await {
            one.expect(200);
        }
    })
    .await;
}
