use proptest::prelude::*;

use super::*;
use crate::{BirthKey, Dialect, Genome, ParameterKind, Variation};

const TOON: &str = "brood 1
.effect light
palette #2b1e46 #A0405A #f2a65a #ffe3b0 # from dark to bright
edges 0.2 0.5 0.8
basis cubic
feather 0.15
from -0.4
to 0.95
.effect silhouette
color #1a1020
";

fn error(text: &str) -> String {
    text.parse::<Genome>().expect_err(text).to_string()
}

/// Effects with random values: always a light effect, and some of the others in any order.
fn effects() -> impl Strategy<Value = Vec<Effect>> {
    let color = any::<[u8; 3]>();
    let palette = prop::collection::vec((color, 0.0..=1.0f64), 2..=8).prop_map(|parts| {
        let mut edges: Vec<f64> = parts[1..].iter().map(|(_, edge)| *edge).collect();
        edges.sort_by(f64::total_cmp);
        let colors = parts.iter().map(|(color, _)| *color).collect();
        Palette::new(Some(colors), Some(edges)).expect("the edges ascend")
    });
    let order = Just(EffectKind::ALL[1..].to_vec()).prop_shuffle();
    let shares = prop::collection::vec(0.0..=1.0f64, 64);
    (palette, order, 0..=3usize, shares).prop_map(|(palette, order, count, shares)| {
        let mut shares = shares.into_iter().cycle();
        let mut effect = |kind: EffectKind, palette: Option<Palette>| {
            let mut values = ParameterValues::new(kind.name(), kind.parameters());
            for parameter in kind.parameters() {
                let mut draw = || {
                    let value = parameter.at_share(shares.next().expect("a cycle has no end"));
                    let is_choice = matches!(parameter.kind, ParameterKind::Choice { .. });
                    // `by brdf` needs a BRDF.
                    let most = if parameter.name == BY { 1.0 } else { f64::INFINITY };
                    if is_choice { value.floor().min(most) } else { value }
                };
                let drawn: Vec<f64> = (0..parameter.count()).map(|_| draw()).collect();
                values.set(parameter.name, &drawn).expect("the values are within the range");
            }
            let ends = [values.get("from").unwrap()[0], values.get("to").unwrap()[0]];
            values.set("from", &[ends[0].min(ends[1])]).unwrap();
            values.set("to", &[ends[0].max(ends[1])]).unwrap();
            Effect::new(kind, values, palette).expect("the ends ascend")
        };
        let light = effect(EffectKind::Light, Some(palette));
        let others: Vec<Effect> =
            order.into_iter().take(count).map(|kind| effect(kind, None)).collect();
        std::iter::once(light).chain(others).collect()
    })
}

#[test]
fn text_is_read_and_written() {
    let genome: Genome = TOON.parse().unwrap();
    let [light, silhouette] = genome.effects() else { panic!("two effects") };
    let palette = light.palette().unwrap();
    assert_eq!(palette.colors()[1], [0xa0, 0x40, 0x5a]);
    assert_eq!(palette.edges(), [0.2, 0.5, 0.8]);
    assert_eq!((light.word("basis"), light.scalar("to")), ("cubic", 0.95));
    assert_eq!(silhouette.color("color"), [26.0, 16.0, 32.0].map(|code| code / 255.0));
    let written = genome.to_string();
    assert!(written.contains("palette #2b1e46 #a0405a #f2a65a #ffe3b0\n"), "{written}");
    assert!(written.contains("\ncolor #1a1020\n") && !written.contains(".dialect"), "{written}");
    assert_eq!(written.parse::<Genome>().unwrap().hash(), genome.hash());
}

#[test]
fn errors_name_line_and_column() {
    let cases = [
        (".effect light\npalette #000000", "line 3, column 9: a palette must have 2 to 8"),
        (".effect light\npalette #00 #ffffff", "line 3, column 9: expected a colour"),
        (".effect light\nedges 0.9 0.1", "line 3, column 7: a palette of 2 colours has 1"),
        (
            ".effect light\nedges 0.9 0.1\npalette #000000 #888888 #ffffff",
            "line 3, column 7: edges must ascend, got 0.9 before 0.1",
        ),
        (".effect light\nedges 1.5", "line 3, column 7: edges must be between 0 and 1"),
        (".effect light\nto -0.5", "line 2, column 1: from must be at most to, got 0 and -0.5"),
        (".effect light\nfrom 0.9\nto 0.5", "line 3, column 6: from must be at most to"),
        (".effect glow", "line 2, column 9: unknown effect `glow`; known effects: light"),
        (".effect light\n.effect light", "line 3, column 1: a genome can have one light effect"),
        (".effect highlight", "line 2, column 1: the first effect must be light, got highlight"),
        (".effect light\ngloss 1", "line 3, column 1: light has no parameter `gloss`; it has pal"),
        (".effect light\n.effect silhouette\nedges 0.5", "line 4, column 1: silhouette has no"),
        (".effect light\nfeather 0.1\nfeather 0.1", "line 4, column 1: feather is given twice"),
        (".effect light\nfeather 2", "line 3, column 9: feather must be between 0 and 1"),
        (".effect light\nbasis round", "line 3, column 7: basis must be one of step, linear"),
        (".effect light\n.model lambert", "line 3, column 1: a genome with effects has no .model"),
        (".model lambert\n.effect light", "line 3, column 1: a genome with a .model line has no"),
        (".effect light\n.limit on", "line 3, column 1: a genome with effects has no .limit"),
        (".scale 1 1 1\n.effect light", "line 3, column 1: a genome with a .scale line has no"),
        (
            ".effect light\n.effect distance\ncolor 12",
            "line 4, column 7: color must be a colour like #2b1e46, got 12",
        ),
    ];
    for (text, expected) in cases {
        let found = error(&format!("brood 1\n{text}\n"));
        assert!(found.starts_with(expected), "{text}: {found}");
    }
}

#[test]
fn words_with_a_number_sign_are_comments_outside_of_colours() {
    let text = "brood 1\n.model lambert\nalbedo 0.5 0.5 0.5 #facade\n";
    assert!(text.parse::<Genome>().unwrap().effects().is_empty());
    let text = "brood 1\n.effect light #facade\nfeather 0.5 #decade\n";
    assert_eq!(text.parse::<Genome>().unwrap().effects()[0].scalar("feather"), 0.5);
}

#[test]
fn json_errors_point_at_the_value() {
    let json = |effects: &str| {
        let text = format!(r#"{{"brood": 1, "dialect": {{"length": 0}}, "effects": {effects}}}"#);
        Genome::from_json(serde_json::from_str(&text).unwrap())
    };
    assert!(json(r#"[{"kind": "light"}]"#).unwrap().is_painted());
    let pointers = [
        (r#"[{"kind": "glow"}]"#, "/effects/0/kind"),
        (r#"[{"kind": "distance"}]"#, "/effects/0/kind"),
        (r#"[{"kind": "light"}, {"kind": "light"}]"#, "/effects/1/kind"),
        (
            r##"[{"kind": "light", "parameters": {"palette": ["#000000"]}}]"##,
            "/effects/0/parameters/palette",
        ),
        (r#"[{"kind": "light", "parameters": {"palette": []}}]"#, "/effects/0/parameters/palette"),
        (
            r##"[{"kind": "light", "parameters": {"palette": ["#000000", "red"]}}]"##,
            "/effects/0/parameters/palette/1",
        ),
        (
            r#"[{"kind": "light", "parameters": {"edges": [0.5, 0.6]}}]"#,
            "/effects/0/parameters/edges",
        ),
        (
            r#"[{"kind": "light", "parameters": {"from": 1, "to": 0}}]"#,
            "/effects/0/parameters/from",
        ),
        (r#"[{"kind": "light", "parameters": {"glow": 1}}]"#, "/effects/0/parameters/glow"),
    ];
    for (effects, pointer) in pointers {
        assert_eq!(json(effects).unwrap_err().pointer, pointer, "{effects}");
    }
    let parts = [
        (r#""limit": true"#, "/limit"),
        (r#""layers": [{"model": "lambert"}]"#, "/layers"),
        (r#""scale": [1, 1, 2]"#, "/scale"),
    ];
    for (part, pointer) in parts {
        let text = format!(
            r#"{{"brood": 1, "dialect": {{"length": 0}}, {part}, "effects": [{{"kind": "light"}}]}}"#
        );
        let error = Genome::from_json(serde_json::from_str(&text).unwrap()).unwrap_err();
        assert_eq!(error.pointer, pointer);
    }
}

#[test]
fn painted_genomes_have_no_limit_and_no_output_stage() {
    let genome: Genome = TOON.parse().unwrap();
    let grey = crate::Output::saturation(0.0).unwrap();
    assert_eq!(genome.clone().with_limit(true).with_output(grey), genome);
    assert_eq!(
        Genome::of_effects(Vec::new()).unwrap_err(),
        crate::GenomeError::Empty,
        "a genome has parts"
    );
}

#[test]
fn bytes_of_genomes_without_effects_are_those_of_earlier_versions() {
    // Hashes of the version before effects.
    let lambert: Genome = "brood 1\n.model lambert\n".parse().unwrap();
    assert_eq!(&lambert.hash().to_string()[..16], "e34f8942ed4a88c6");
    let random = Variation::random(Dialect::default());
    let program = random.birth(BirthKey { seed: 1, slot: 0, attempt: 0 });
    assert_eq!(&program.hash().to_string()[..16], "0caf004ab1566231");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn text_json_and_bytes_round_trip(effects in effects(), seed: u64, has_program: bool) {
        let genome = match has_program {
            true => {
                let random = Variation::random(Dialect { length: 9, ..Dialect::default() });
                let program = random.birth(BirthKey { seed, slot: 0, attempt: 0 });
                let constants = Box::new(*program.constants());
                let instructions = program.instructions().to_vec();
                Genome::painted(*program.dialect(), instructions, constants, effects).unwrap()
            }
            false => Genome::of_effects(effects).unwrap(),
        };
        let bytes = genome.canonical_bytes();
        let again: [Genome; 3] = [
            genome.to_string().parse().unwrap(),
            Genome::from_json(genome.to_json()).unwrap(),
            Genome::from_canonical_bytes(&bytes).unwrap(),
        ];
        for again in again {
            prop_assert_eq!(again.canonical_bytes(), bytes.clone());
            prop_assert_eq!(&again, &genome);
        }
    }

    #[test]
    fn damaged_bytes_are_rejected_or_decode_to_another_genome(
        effects in effects(), at in any::<prop::sample::Index>(), flip in 1u8..,
    ) {
        let genome = Genome::of_effects(effects).unwrap();
        let mut bytes = genome.canonical_bytes();
        let at = at.index(bytes.len());
        prop_assert!(Genome::from_canonical_bytes(&bytes[..at]).is_err());
        bytes[at] ^= flip;
        match Genome::from_canonical_bytes(&bytes) {
            Err(error) => prop_assert!(!error.to_string().is_empty()),
            Ok(other) => {
                prop_assert!(other.hash() != genome.hash());
                prop_assert_eq!(other.canonical_bytes(), bytes);
            }
        }
    }

    #[test]
    fn children_of_painted_genomes_are_painted(effects in effects(), seed: u64, mutation: f32) {
        let mutation = mutation.abs().fract();
        let parent = Genome::of_effects(effects).unwrap();
        let start = crate::Start::Painted;
        let key = BirthKey { seed, slot: 3, attempt: 0 };
        let other = Variation::random(start.dialect()).with_start(start).birth(key);
        let child = Variation::mutate(&parent, mutation).birth(key);
        prop_assert!(child.is_painted());
        let child = Variation::crossover(&parent, &other, 0.5, mutation).birth(key);
        prop_assert!(child.is_painted());
        let child = Variation::crossover(&other, &parent, 0.5, mutation).birth(key);
        prop_assert!(child.is_painted());
    }
}

#[test]
fn directed_programs_need_effects() {
    let program = ".dialect directed smooth registers 12\nMUL R0, R10, R11.x\n";
    let painted = format!("brood 1\n.effect light\nbrush 1\n{program}");
    let genome: Genome = painted.parse().unwrap();
    assert!(genome.to_string().contains(".dialect directed smooth registers 12\n"));
    assert_eq!(Genome::from_json(genome.to_json()).unwrap(), genome);
    assert_eq!(Genome::from_canonical_bytes(&genome.canonical_bytes()), Ok(genome.clone()));
    let expected = "the opcode set `directed` is for genomes with effects that are not `by brdf`";
    assert!(error(&format!("brood 1\n{program}")).contains(expected));
    let mut json = genome.to_json();
    json.as_object_mut().unwrap().remove("effects");
    let found = Genome::from_json(json).unwrap_err();
    assert_eq!((found.pointer.as_str(), found.reason.as_str()), ("/dialect", expected));
}

#[test]
fn bytes_reject_a_limit_beside_effects() {
    let genome = Genome::of_effects(vec![Effect::of(EffectKind::Light)]).unwrap();
    let mut bytes = genome.canonical_bytes();
    // Version line, opcodes, parametrisation, registers and two bytes of the length.
    let switches = b"brood genome 1\n".len() + 5;
    assert_eq!(bytes[switches], 16);
    bytes[switches] |= 4;
    let refused = crate::GenomeError::from(EffectsError::NotByBrdf);
    assert_eq!(Genome::from_canonical_bytes(&bytes), Err(refused.into()));
}
