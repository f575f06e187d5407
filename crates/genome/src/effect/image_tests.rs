//! Tests of control images in genomes.

use serde_json::{Value, json};

use super::*;
use crate::{BirthKey, EffectLock, Genome, Locks, Variation};

fn imaged() -> (Genome, [ImageHash; 3]) {
    let hashes = [b"a", b"b", b"c"].map(|content| ImageHash::of(content));
    let [a, b, c] = hashes;
    let text = format!(
        "brood 1\n.effect light\nmap {c}\ndark {a} 0.25\nbrush 0.5\n.effect silhouette\nimage {b}\nmap {a} 0\n"
    );
    (text.parse().unwrap(), hashes)
}

#[test]
fn images_are_read_and_written_and_keep_the_bytes_of_others() {
    let (genome, [a, b, c]) = imaged();
    let dark = genome.effects()[0].image("dark").unwrap();
    assert_eq!((dark.image, dark.share), (a, 0.25));
    assert_eq!(genome.images(), [a, c, b]);
    let written = genome.to_string();
    assert!(written.contains(&format!("\ndark {a} 0.25\nmap {c}\n")), "{written}");
    assert_eq!(written.parse::<Genome>().as_ref(), Ok(&genome));
    let json = genome.to_json();
    let shown = &json["effects"][0]["parameters"]["dark"];
    assert_eq!(*shown, json!({"image": a.to_string(), "share": 0.25}));
    assert_eq!(Genome::from_json(json).as_ref(), Ok(&genome));
    let bytes = genome.canonical_bytes();
    assert_eq!(Genome::from_canonical_bytes(&bytes).as_ref(), Ok(&genome));
    for length in 0..bytes.len() {
        assert!(Genome::from_canonical_bytes(&bytes[..length]).is_err());
    }
}

#[test]
fn invalid_images_are_refused_with_their_place() {
    let hash = ImageHash::of(b"a");
    let text =
        |lines: &str| format!("brood 1\n.effect light\n{lines}").parse::<Genome>().unwrap_err();
    for (lines, line, column, words) in [
        (format!("dark {hash} 2"), 3, 6, "a share must be between 0 and 1, got 2"),
        ("dark red.png".to_owned(), 3, 6, "64 hexadecimal digits"),
        ("dark".to_owned(), 3, 1, "got 0 values"),
        (format!("dark {hash}\ndark {hash}"), 4, 1, "dark is given twice"),
        (format!("image {hash}"), 3, 1, "light has no parameter `image`"),
        (format!(".effect glass\nimage {hash}"), 4, 1, "glass has no parameter `image`"),
    ] {
        let error = text(&lines);
        assert!(error.to_string().contains(words), "{lines}: {error}");
        assert_eq!((error.line, error.column), (line, column), "{lines}: {error}");
    }
    let four: Vec<String> = (0..5u8).map(|at| ImageHash::of(&[at]).to_string()).collect();
    let lines = format!(
        "dark {}\nbright {}\nmap {}\n.effect silhouette\nimage {}\nmap {}\n",
        four[0], four[1], four[2], four[3], four[4]
    );
    assert!(text(&lines).to_string().contains("at most 4 different images, got 5"));
    let json = |parameters: Value| {
        let light = json!({"kind": "light", "parameters": parameters});
        let genome: Genome = "brood 1\n.effect light\n".parse().unwrap();
        let mut json = genome.to_json();
        json["effects"][0] = light;
        Genome::from_json(json).unwrap_err()
    };
    for (parameters, pointer) in [
        (json!({"dark": 1}), "/effects/0/parameters/dark"),
        (json!({"dark": {"image": "x"}}), "/effects/0/parameters/dark/image"),
        (json!({"basis": {"image": hash}}), "/effects/0/parameters/basis"),
        (json!({"dark": {"image": hash, "share": -1}}), "/effects/0/parameters/dark"),
    ] {
        assert_eq!(json(parameters.clone()).pointer, pointer, "{parameters}");
    }
}

#[test]
fn images_are_inherited_and_locked() {
    let (genome, [a, ..]) = imaged();
    let key = |slot| BirthKey { seed: 3, slot, attempt: 0 };
    let lock = EffectLock { effect: EffectKind::Light, name: "dark".to_owned() };
    let locks = Locks { effect_parameters: vec![lock], ..Locks::default() };
    assert!(locks.validate_for(&genome).is_ok());
    let mut shares = Vec::new();
    for slot in 0..40 {
        let child = Variation::mutate(&genome, 0.5).birth(key(slot));
        let map = child.effects()[0].image("map").unwrap();
        shares.push(map.share);
        let kept = Variation::mutate(&genome, 0.5).with_locks(Some(&locks)).birth(key(slot));
        assert_eq!(kept.effects()[0].image("dark"), genome.effects()[0].image("dark"));
    }
    assert!(shares.iter().any(|share| *share < 0.9) && shares.contains(&1.0), "{shares:?}");
    // Crossing keeps to the largest number of images.
    let more = |seed: u8| {
        let names: Vec<String> = (0..4).map(|at| ImageHash::of(&[seed, at]).to_string()).collect();
        let text = format!(
            "brood 1\n.effect light\ndark {}\nmap {}\n.effect silhouette\nimage {}\n\
             .effect highlight\nmap {}\n",
            names[0], names[1], names[2], names[3]
        );
        text.parse::<Genome>().unwrap()
    };
    let (first, second) = (more(1), more(2));
    for slot in 0..60 {
        let child = Variation::crossover(&first, &second, 0.5, 0.0).birth(key(slot));
        assert!(child.images().len() <= IMAGES_MAX);
        let own: Vec<ImageHash> = [&first, &second].iter().flat_map(|one| one.images()).collect();
        assert!(child.images().iter().all(|image| own.contains(image)));
    }
    assert!(genome.images().contains(&a));
}
