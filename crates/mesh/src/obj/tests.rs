use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::{ObjError, ObjErrorKind, ObjFile, ObjLimits, parse_obj};

fn parse(text: &str) -> Result<ObjFile, ObjError> {
    parse_obj(text.as_bytes(), &ObjLimits::default())
}

fn warnings(text: &str) -> Vec<(u32, String)> {
    parse(text).unwrap().warnings.into_iter().map(|w| (w.line, w.text)).collect()
}

const SQUARE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\n";

#[test]
fn faces_are_the_same_in_every_index_form() {
    let full = parse(&format!("{SQUARE}f 1/1/1 2/2/1 3/3/1 4/4/1")).unwrap().mesh;
    assert_eq!((full.vertex_count(), full.triangle_count(), full.has_uv()), (4, 2, true));
    assert_eq!(full.parts().normals, [DVec3::Z; 4]);
    assert!(full.parts().tangents.iter().all(|u| (*u - DVec3::X).length() < 1e-15));
    assert_eq!(full.parts().uvs[2], DVec2::ONE);
    for form in [
        "f -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1",
        "f 1/1 2/2 3/3 4/4",
        "f 1/1/ 2/2 \\\r\n 3/3/1\t4/4 # comment\r\n",
        "g a\no b\ns off\nusemtl c\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1",
    ] {
        assert_eq!(parse(&format!("{SQUARE}{form}")).unwrap().mesh, full, "{form}");
    }
    for form in ["f 1//1 2//1 3//1 4//1", "f 1 2 3 4"] {
        let mesh = parse(&format!("{SQUARE}{form}")).unwrap().mesh;
        assert_eq!(mesh.parts().positions, full.parts().positions, "{form}");
        assert_eq!(mesh.parts().normals, full.parts().normals, "{form}");
        assert!(!mesh.has_uv());
    }
}

#[test]
fn file_parses_with_extra_numbers_byte_order_mark_and_forward_indices() {
    let text = "\u{feff}f 1/1 2/2 3/3\nv 0 0 0 1 .5 .5 .5\nv +1e0 0 0 1\nv 0 1. 0\nvt 0 0 0\nvt 1\nvt 0 1 0\n";
    let mesh = parse(text).unwrap().mesh;
    assert_eq!(mesh.parts().positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(mesh.parts().uvs, [DVec2::ZERO, DVec2::X, DVec2::Y]);
}

#[test]
fn corners_share_a_vertex_only_when_all_indices_are_equal() {
    let text = format!("{SQUARE}vn 0 0 -1\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/2 4/4/1");
    assert_eq!(parse(&text).unwrap().mesh.vertex_count(), 5);
}

#[test]
fn smooth_normals_ignore_texture_seams_and_repeated_positions() {
    // Two squares at a right angle along x = 0, with texture seams or with repeated positions.
    let places = "v 0 0 0\nv 0 1 0\nv -1 1 0\nv -1 0 0\nv 0 0 -1\nv 0 1 -1\n";
    let seam = format!("{places}vt 0 0\nvt 1 0\nf 1/1 2/1 3/1 4/1\nf 5/2 6/2 2/2 1/2\n");
    let repeated = format!("{places}v 0 0 0\nv -0 1 0\nf 1 2 3 4\nf 5 6 8 7\n");
    for text in [seam, repeated] {
        let mesh = parse(&text).unwrap().mesh;
        assert_eq!(mesh.vertex_count(), 8);
        let parts = mesh.parts();
        let shared: Vec<DVec3> = (0..8)
            .filter(|k| parts.positions[*k] == DVec3::ZERO)
            .map(|k| parts.normals[k])
            .collect();
        assert_eq!(shared.len(), 2);
        for n in shared {
            assert!((n - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-12, "{n}");
        }
    }
}

#[test]
fn parser_returns_line_when_file_is_malformed() {
    let cases = [
        ("", "line 1: the file has no face"),
        ("v 0 0 0\n\n# end", "line 3: the file has no face"),
        ("v 0 0 nan\n", "line 1: vertex coordinate is not a finite number"),
        ("\nv 0 -inf 0\n", "line 2: vertex coordinate is not a finite number"),
        ("v 1e39 0 0\n", "line 1: vertex coordinate is not a finite number"),
        ("v 0 0 0\nvt 1e999\n", "line 2: texture coordinate is not a finite number"),
        ("vn 0 0 x\n", "line 1: normal coordinate is not a number"),
        ("v 0 0\n", "line 1: vertex coordinate: expected at least 3 numbers"),
        ("v 0 0 0\nf 1 1\n", "line 2: face must have at least 3 corners"),
        ("f\n", "line 1: face must have at least 3 corners"),
        (
            "v 0 0 0\nf 1 0 1\n",
            "line 2: vertex index is 0; indices start at 1, or at -1 counting backwards",
        ),
        ("v 0 0 0\nf 1 1 2\n\n", "line 2: vertex index is out of range"),
        ("v 0 0 0\nf 1 1 -2\n", "line 2: vertex index is out of range"),
        ("v 0 0 0\nf 1/1 1/1 1/1", "line 2: texture coordinate index is out of range"),
        ("v 0 0 0\nf 1//2 1//2 1//2", "line 2: normal index is out of range"),
        (
            "v 0 0 0\n\nf 1 1 \\\n 1 a\n",
            "line 3: face corner must have the form v, v/t, v//n or v/t/n",
        ),
        ("v 1 1 1\nf 1 1 1\n#\n", "line 3: the mesh has no extent"),
    ];
    for (text, expected) in cases {
        assert_eq!(parse(text).unwrap_err().to_string(), expected, "{text:?}");
    }
}

#[test]
fn file_is_rejected_when_it_exceeds_a_limit() {
    let limits = ObjLimits { bytes: 200, vertices: 4, triangles: 2, polygon_corners: 5 };
    let kind = |text: &str| parse_obj(text.as_bytes(), &limits).unwrap_err().kind;
    let too_many = |what, limit| ObjErrorKind::TooMany { what, limit };
    assert!(parse_obj(format!("{SQUARE}f 1 2 3 4").as_bytes(), &limits).is_ok());
    assert_eq!(kind(&" ".repeat(201)), ObjErrorKind::TooManyBytes { limit: 200 });
    assert_eq!(kind(&"v 0 0 0\n".repeat(5)), too_many("vertices", 4));
    assert_eq!(kind(&format!("{SQUARE}f 1 2 3 4\nf 1 2 3")), too_many("triangles", 2));
    assert_eq!(kind(&format!("{SQUARE}f 1 2 3 4 1 2")), too_many("corners in a face", 5));
    let text = format!("{SQUARE}f 1/1 2/2 3/3\nf 1/2 2/3 3/1");
    assert_eq!(kind(&text), too_many("vertices after joining equal corners", 4));
}

#[test]
fn warnings_are_unique_and_have_the_first_line() {
    let text = format!(
        "mtllib a.mtl\nmtllib b.mtl\n{SQUARE}vw 1\nvw 2\ncurv 3\nl 1 2\np 1\nl 2 3\nf 1 2 3 4\n\
         f 1 1 2\nvn 0 0 0\nf 1//2 2//2 3//2\n"
    );
    let expected = [
        (1, "mtllib is ignored: other files are not read"),
        (12, "unknown keyword `vw` is ignored"),
        (14, "unknown keyword `curv` is ignored"),
        (15, "lines (l) are ignored"),
        (16, "points (p) are ignored"),
        (21, "no texture coordinates: u and v are 0, tangents depend on the normals alone"),
        (21, "triangles with zero area: 1"),
        (21, "zero-length normals, replaced by smooth normals: 3"),
    ];
    assert_eq!(warnings(&text), expected.map(|(line, text)| (line, text.to_owned())));
    let degenerate = format!("{SQUARE}vn 0 0 1\nf 1/1 2/1 3/1\nf 1 3 4\n");
    let expected = [
        "vertices without texture coordinates, where u and v are 0: 3",
        "vertices whose texture coordinates give no tangent, derived from the normal instead: 6",
    ];
    let texts: Vec<String> = warnings(&degenerate).into_iter().map(|w| w.1).collect();
    assert_eq!(texts, expected);
}

#[test]
fn warnings_are_bounded_when_file_is_noise() {
    let noise: String = (0..1000).map(|k| format!("{}{k}\u{1b}[31m\n", "x".repeat(k))).collect();
    let list = warnings(&format!("{noise}{SQUARE}f 1/1 2/2 3/3\n"));
    assert_eq!(list.len(), 21);
    assert!(list.iter().all(|w| w.1.len() < 180 && w.1.is_ascii()));
    assert!(list.iter().all(|w| !w.1.contains('\u{1b}')));
}

/// Valid file with every kind of statement.
const VALID: &str = "mtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nv 0.2 0.3 -1e2\nvt 0 0\nvt 1 .5\n\
    vn 0 1 0\ng part\ns 1\nusemtl m\nf 1 2 3 4\nf 1/1/1 2/2/1 -1/-1/-1\nf 3//1 4//1 5//1 1//1 2//1\nl 1 2\n";

proptest! {
    #[test]
    fn parser_never_panics_when_bytes_are_arbitrary(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = parse_obj(&bytes, &ObjLimits::default());
    }

    #[test]
    fn parser_never_panics_when_a_valid_file_is_mutated(
        edits in prop::collection::vec((0..VALID.len(), any::<u8>(), 0..3u8), 1..12),
        words in prop::collection::vec((0..VALID.len(), 0..10usize), 0..4),
    ) {
        let inserted = ["nan ", "-1 ", "f 1 2 3\n", "\\\n", "1e38 ", "/", "999999999999 ", "\nf ", "v 1 1 1\n", "-0"];
        let mut bytes = VALID.as_bytes().to_vec();
        for (at, word) in words {
            let at = at.min(bytes.len());
            bytes.splice(at..at, inserted[word].bytes());
        }
        for (at, byte, edit) in edits {
            let at = at % bytes.len().max(1);
            match edit {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, b"0123456789/- \n.evtnf"[usize::from(byte) % 20]),
                _ => { bytes.remove(at); }
            }
        }
        let _ = parse_obj(&bytes, &ObjLimits::default());
    }

    #[test]
    fn parser_round_trips_coordinates(
        numbers in prop::collection::vec(-1e30..1e30f64, 9),
    ) {
        let vertices: String = numbers.chunks(3).map(|v| format!("v {} {:e} {}\n", v[0], v[1], v[2])).collect();
        let mesh = parse(&format!("{vertices}f 1 2 3")).unwrap().mesh;
        let read: Vec<f64> = mesh.parts().positions.iter().flat_map(|p| p.to_array()).collect();
        prop_assert_eq!(read, numbers);
    }
}

#[test]
fn valid_file_of_mutation_test_parses() {
    assert_eq!(parse(VALID).unwrap().mesh.triangle_count(), 6);
}
