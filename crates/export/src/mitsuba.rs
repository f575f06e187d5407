//! Plugin for the path tracer Mitsuba 3: a file of Python that registers the material.
//!
//! f is the printed code on arrays of Dr.Jit. Directions are sampled by the table of `sampling`,
//! which is in the file as base64 of compressed numbers of 16 bits.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_eval::energy_limit;
use brood_program::Program;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::model::Layers;
use crate::sampling::SamplingTable;
use crate::{module, python};

/// Length of the lines of base64.
const LINE: usize = 100;

/// Returns the file. Texture coordinates are within [-`uv`, `uv`].
pub(crate) fn plugin(program: &Program, uv: f32) -> String {
    let table = SamplingTable::of(program);
    let (constants, functions) = module::with_library(&module::functions(program, uv));
    let code = python::translate(&(constants + "\n" + &functions));
    let is_anisotropic = table.shape[1] > 1;
    let mut flags = String::new();
    if is_anisotropic {
        flags += " | mi.BSDFFlags.Anisotropic";
    }
    let has_bumps = program.bumps().is_some();
    if module::reads_texture(program) {
        flags += " | mi.BSDFFlags.SpatiallyVarying";
    }
    // Where the texture is mirrored, v grows against the second tangent.
    let across = if has_bumps { "dr.sign(dr.dot(si.dp_dv, si.sh_frame.t))" } else { "1" };
    let boolean = |is: bool| if is { "True" } else { "False" };
    let [inclinations, azimuths, rows, columns] = table.shape;
    let values = [
        ("@NAME@", name(program)),
        ("@SHARE@", table.share.to_string()),
        ("@SHAPE@", format!("({inclinations}, {azimuths}, {rows}, {columns})")),
        ("@POWER@", table.power.to_string()),
        ("@FIXED@", boolean(table.is_fixed).to_owned()),
        ("@PERIOD@", format!("{:?}", table.period)),
        ("@BYTES@", bytes(&table)),
        ("@FLAGS@", flags),
        ("@ACROSS@", across.to_owned()),
        ("@CODE@", code.trim().to_owned()),
    ];
    let text =
        values.iter().fold(include_str!("mitsuba/module.py").to_owned(), |text, (mark, value)| {
            text.replace(mark, value)
        });
    head(program, &table) + &text
}

/// Name of the plugin.
fn name(program: &Program) -> String {
    format!("brood_{}", &program.hash().to_string()[..8])
}

/// Docstring of the module.
fn head(program: &Program, table: &SamplingTable) -> String {
    let layers = Layers::of(program.layers());
    let limit = energy_limit(program);
    let energy = if limit.bound() > 1.0 + 1e-6 {
        format!(
            "It reflects up to {:.4} times the light that it receives: the energy limit is off.\n\
             Pictures in which light is reflected several times become too bright.",
            limit.bound(),
        )
    } else {
        format!("It reflects at most {:.4} of the light that it receives.", limit.bound())
    };
    format!(
        r#""""A material bred by brood, as a plugin for Mitsuba 3.

    pip install mitsuba
    python THIS_FILE.py picture.png

renders it. In a program of your own, or in a notebook, import this file; if it is material.py:

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    import material
    scene = mi.load_dict({{"type": "sphere", "bsdf": {{"type": material.NAME}}, ...}})

It needs a variant that compiles and has three colour channels or one, such as llvm_ad_rgb,
cuda_ad_rgb or llvm_ad_mono. The variants that begin with llvm need LLVM 19 or later (on Debian:
libllvm19), which they look for at $DRJIT_LIBLLVM_PATH.

The material is {properties}, for any directions.
{energy}
Program {hash}, {operations} operations.
Sampling: one sample in an even sky has {table:.3} times the squared mean as variance, {cosine:.3} if sampled
by the cosine alone.
"""

"#,
        properties = module::properties(program, &layers),
        hash = program.hash(),
        operations = program.operations(),
        table = table.variance.table,
        cosine = table.variance.cosine,
    )
}

/// The values of the table, as lines of base64.
fn bytes(table: &SamplingTable) -> String {
    let bytes: Vec<u8> = table.values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    let compressed = encoder.write_all(&bytes).and_then(|()| encoder.finish());
    let text = BASE64_STANDARD.encode(compressed.expect("a vector takes everything"));
    let lines = text.as_bytes().chunks(LINE).map(String::from_utf8_lossy);
    lines.collect::<Vec<_>>().join("\n")
}
