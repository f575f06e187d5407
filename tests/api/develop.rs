//! Pictures of linear radiance, developed for browsers.

use std::io::Cursor;

use brood_tests::{TestServer, text_of};

/// Returns an EXR picture that is red to the right, and not a number in green.
fn encoded() -> Vec<u8> {
    let pixel = |x: u32, _| image::Rgb([0.02 * x as f32, f32::NAN, 0.0]);
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::Rgb32FImage::from_fn(40, 30, pixel);
    picture.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

#[tokio::test(flavor = "multi_thread")]
async fn linear_pictures_are_developed_for_browsers() {
    let server = TestServer::start();
    let path = "/v1/develop.png";
    let bytes = encoded();
    let shown = server.post_bytes(path, "image/x-exr", bytes).await.expect(200).picture();
    assert_eq!(shown.dimensions(), (40, 30));
    let [dark, bright] = [0, 39].map(|x| shown.get_pixel(x, 7).0);
    assert_eq!((dark, bright[1..].to_vec()), ([0, 0, 0, 255], vec![0, 0, 255]));
    assert!(bright[0] > 230, "automatic exposure: {bright:?}");
    let problem = server.post_bytes(path, "image/x-exr", vec![1, 2, 3]).await.problem(422);
    assert!(text_of(&problem["detail"]).contains("must be an EXR"), "{problem}");
    server.post_bytes(path, "image/png", vec![1]).await.problem(415);
}
