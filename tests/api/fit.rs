//! `brood fit`: written files, reproducibility, and refused input.

use std::fmt::Write;
use std::path::Path;

use brood_tests::brood;
use serde_json::Value;
use tempfile::TempDir;

/// Writes samples of a model as CSV, on a grid of directions.
fn samples(folder: &Path, model: &str) -> String {
    let mut pairs = String::from("wix,wiy,wiz,wox,woy,woz\n");
    for i in 0..8 {
        for o in 0..8 {
            for turn in 0..8 {
                let at = |k: i32| f64::from(10 * k + 3).to_radians().sin_cos();
                let ((si, ci), (so, co)) = (at(i), at(o));
                let (st, ct) = f64::from(25 * turn + 5).to_radians().sin_cos();
                writeln!(pairs, "{si},0,{ci},{},{},{co}", -so * ct, so * st).unwrap();
            }
        }
    }
    let (material, list) = (folder.join("model.brood"), folder.join("pairs.csv"));
    std::fs::write(&material, brood(["model", "show", model]).success().stdout).unwrap();
    std::fs::write(&list, &pairs).unwrap();
    let arguments = ["eval", material.to_str().unwrap(), list.to_str().unwrap()];
    let values = brood(arguments).success().stdout;
    let rows = pairs.lines().zip(values.lines()).map(|(pair, value)| format!("{pair},{value}\n"));
    let target = folder.join("target.csv");
    std::fs::write(&target, rows.collect::<String>()).unwrap();
    target.to_str().unwrap().to_owned()
}

#[test]
fn samples_are_fitted_and_results_are_written() {
    let folder = TempDir::new().unwrap();
    let target = samples(folder.path(), "coated");
    let fit = |out: &str, threads: &str| -> Value {
        let out = folder.path().join(out);
        let out = out.to_str().unwrap();
        let how = ["--generations", "3", "--threads", threads, "--size", "32", "--json"];
        let arguments = [&["fit", target.as_str(), "-o", out][..], &how[..]].concat();
        serde_json::from_str(&brood(arguments).success().stdout).unwrap()
    };
    let report = fit("one", "1");
    assert_eq!(report["target"]["kind"], "scattered samples");
    assert!(report["e_log"].as_f64().unwrap() < 0.01, "{report}");
    assert_eq!(report["physics"]["not_reciprocal"], 0);
    assert!(report["energy"]["max_albedo"].as_f64().unwrap() <= 1.0, "{report}");
    assert_eq!(report["search"]["generations"], 3);
    let read = |run: &str, name: &str| {
        std::fs::read(folder.path().join(run).join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    };
    for name in ["best.png", "target.png"] {
        assert_eq!(image::load_from_memory(&read("one", name)).unwrap().width(), 32);
    }
    let front = String::from_utf8(read("one", "front.csv")).unwrap();
    let rows: Vec<&str> = front.lines().collect();
    assert_eq!(rows[0], "genome,operations,numbers,e_log_fitted,e_log");
    assert!(rows.len() > 1, "{front}");
    for row in &rows[1..] {
        read("one", row.split(',').next().unwrap());
    }
    let best = folder.path().join("one/best.brood");
    brood(["inspect", best.to_str().unwrap()]).success();
    // Another number of threads gives the same genomes.
    fit("two", "2");
    for name in ["best.brood", "front.csv"] {
        assert_eq!(read("one", name), read("two", name), "{name}");
    }
}

#[test]
fn invalid_target_is_refused_with_a_reason() {
    let folder = TempDir::new().unwrap();
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let out = folder.path().join("out");
        let finished = brood(["fit", path.to_str().unwrap(), "-o", out.to_str().unwrap()]);
        assert_eq!(finished.code, 1, "{}", finished.stdout);
        assert!(!out.exists(), "no output folder is created");
        finished.stderr
    };
    let head = "wix,wiy,wiz,wox,woy,woz,r,g,b\n";
    let row = |value: &str| format!("0,0,1,0.6,0,0.8,{value},{value},{value}\n");
    let csv = |value: &str| format!("{head}{}", row(value).repeat(200));
    let said = refused("few.csv", format!("{head}{}", row("1").repeat(9)).as_bytes());
    assert!(said.contains("9 samples are above the surface"), "{said}");
    let said = refused("nan.csv", csv("NaN").as_bytes());
    assert!(said.contains("nan.csv"), "{said}");
    let said = refused("black.csv", csv("0").as_bytes());
    assert!(said.contains("it reflects nothing at any of 160 samples"), "{said}");
    let said = refused("bright.csv", csv("1e30").as_bytes());
    assert!(said.contains("must be a finite number"), "{said}");
    let said = refused("short.binary", &[90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0, 1, 2, 3]);
    assert!(said.contains("short.binary"), "{said}");
    let said = refused("cut.bsdf", b"tensor_file\0");
    assert!(said.contains("cut.bsdf"), "{said}");
    let said = refused("a.brood", b"brood 1\n.model lambert\n");
    assert!(said.contains("is a genome already"), "{said}");
    let good = folder.path().join("good.csv");
    std::fs::write(&good, csv("0.5")).unwrap();
    let finished = brood(["fit", good.to_str().unwrap(), "--seconds", "0", "-o", "x"]);
    assert!(finished.stderr.contains("--seconds must be above 0"), "{}", finished.stderr);
}
