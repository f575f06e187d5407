//! Tests of exported WGSL on the available adapter, by value: models against the suite of
//! `brood_export::conformance`, programs with layers and styles against the canonical evaluator.
//! Skipped without an adapter, like other tests of evaluators.

use brood_brdf::{Input, Lighting};
use brood_eval::conformance::{layered_programs, lit_points};
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_export::conformance::{ErrorTally, cases, pairs, styled_calls, styles};
use brood_export::{Format, Within, export, export_material};
use brood_genome::ModelKind;
use brood_program::Program;
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};

use crate::device::Device;
use crate::guard::Guard;
use crate::pipeline::{bind_group_layout, build_pipeline};
use crate::shader::{ENTRY_POINT, Kernel};
use crate::{GpuError, GpuOptions};

const PAIRS: usize = 256;
const LANES: usize = 64;
/// Number of floats per row: wi, wo and a texture position.
const ROW: usize = 8;

fn device() -> Option<Device> {
    match Device::open(&GpuOptions::default()) {
        Ok(device) => Some(device),
        Err(error) => {
            let required = std::env::var_os("BROOD_REQUIRE_GPU").is_some_and(|v| v == "1");
            assert!(!required && error == GpuError::NoAdapter, "{error}");
            eprintln!("skipped: {error}");
            None
        }
    }
}

/// Returns f of each row, by the function `evolved` of a module in the local frame.
fn run(device: &Device, module: &str, rows: &[[f32; ROW]]) -> Vec<[f32; 3]> {
    let call = "evolved(vec3f(row(0u), row(1u), row(2u)), vec3f(row(3u), row(4u), row(5u)), \
                vec3f(0.0, 0.0, 1.0), vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), \
                vec2f(row(6u), row(7u)))";
    run_rows(device, &format!("{module}{}", main_of(call, ROW)), rows.as_flattened(), ROW)
}

/// Entry point that calls a function of `row(k)`, the numbers of a row.
fn main_of(call: &str, width: usize) -> String {
    format!(
        "
@group(0) @binding(1) var<storage, read> rows: array<f32>;
@group(0) @binding(3) var<storage, read_write> values: array<f32>;
var<private> first: u32;
fn row(k: u32) -> f32 {{ return rows[first + k]; }}
@compute @workgroup_size({LANES})
fn {ENTRY_POINT}(@builtin(global_invocation_id) id: vec3u) {{
  first = {width}u * id.x;
  if (first >= arrayLength(&rows)) {{ return; }}
  let f = {call};
  values[3u * id.x] = f.x;
  values[3u * id.x + 1u] = f.y;
  values[3u * id.x + 2u] = f.z;
}}
"
    )
}

/// Runs a shader on rows of `width` numbers.
fn run_rows(device: &Device, text: &str, rows: &[f32], width: usize) -> Vec<[f32; 3]> {
    let count = rows.len() / width;
    let layout = bind_group_layout(&device.api, Kernel::Reflectance);
    let pipeline = build_pipeline(device, &layout, text, Guard::Plain).unwrap();
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    let bytes = |count: usize| u64::try_from(4 * count).unwrap();
    let (input, output) = (bytes(rows.len()), bytes(3 * count));
    let zero = device.buffer("zero", 16, wgpu::BufferUsages::UNIFORM);
    let unread = device.buffer("unread", 16, usage);
    let directions = device.buffer("directions", input, usage);
    let values = device.buffer("values", output, usage | wgpu::BufferUsages::COPY_SRC);
    let reading = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let answer = device.buffer("answer", output, reading);
    device.queue.write_buffer(&directions, 0, bytemuck::cast_slice(rows));
    let entries: Vec<wgpu::BindGroupEntry<'_>> = [&zero, &directions, &unread, &values]
        .into_iter()
        .zip(0..)
        .map(|(buffer, binding)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let group = device.api.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &entries,
    });
    let mut encoder = device.api.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(u32::try_from(count.div_ceil(LANES)).unwrap(), 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&values, 0, &answer, 0, output);
    let submission = device.queue.submit([encoder.finish()]);
    let mut found: Vec<f32> = Vec::new();
    let read = |bytes: &[u8]| found.extend_from_slice(bytemuck::cast_slice(bytes));
    device.read(&answer, output, submission, read).unwrap();
    found.chunks(3).map(|f| [f[0], f[1], f[2]]).collect()
}

fn row(pair: [DVec3; 2], uv: DVec2) -> [f32; ROW] {
    let ([wi, wo], uv) = (pair.map(|w| w.as_vec3()), uv.as_vec2());
    [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, uv.x, uv.y]
}

#[test]
fn exported_models_are_near_the_reference_and_reciprocal() {
    let Some(device) = device() else { return };
    let pairs = pairs(PAIRS);
    let rows: Vec<_> = pairs.iter().map(|pair| row(*pair, DVec2::ZERO)).collect();
    let swapped: Vec<_> = pairs.iter().map(|[wi, wo]| row([*wo, *wi], DVec2::ZERO)).collect();
    for kind in ModelKind::ALL {
        let mut tally = ErrorTally::new(kind);
        for case in cases(kind) {
            let module = export(&case.program, Format::Wgsl);
            let found = run(&device, &module, &rows);
            for ((f, wanted), pair) in found.iter().zip(case.reference_values(&pairs)).zip(&pairs) {
                tally.add(*f, &wanted, || format!("{} {pair:?}", case.model));
            }
            if case.is_reciprocal() {
                let back = run(&device, &module, &swapped);
                let differs = found.iter().zip(&back).position(|(f, b)| f != b);
                assert_eq!(differs, None, "{} {:?}", case.model, differs.map(|k| pairs[k]));
            }
        }
        println!("{kind}: {:?}", tally.summary());
        tally.check();
    }
}

/// Given the same inputs, exported styles have the canonical bits where the adapter rounds each
/// operation; one that fuses some stays near.
#[test]
fn exported_styles_have_the_colours_of_the_canonical_evaluator() {
    let Some(device) = device() else { return };
    for (lights, style) in (1..=8).cycle().zip(&styles()) {
        let lighting = Lighting { lights, has_shadows: true };
        let set = lit_points(lights as u64, PAIRS, lighting);
        let inputs: Vec<Input> = style.painted(lighting).inputs().iter().collect();
        let arguments: Vec<String> = (0..inputs.len()).map(row_of).collect();
        let call = format!("styled_program({})", arguments.join(", "));
        let within = Within { lights, ..Within::default() };
        let module = export_material(style, Format::Wgsl, within).unwrap().into_text();
        check_colors(&device, (&module, &call), style, (&set, &inputs));
    }
}

/// As by their inputs, but by the structures, so that each field is the input of its name. Of clear
/// bodies also the colours without glass.
#[test]
fn exported_styles_have_these_colours_from_the_fields_of_their_structures() {
    let Some(device) = device() else { return };
    let mut clear = 0;
    for (lights, style) in (1..=8).cycle().zip(&styles()) {
        let set = lit_points(lights as u64, PAIRS, Lighting { lights, has_shadows: true });
        let within = Within { lights, ..Within::default() };
        let module = export_material(style, Format::Wgsl, within).unwrap().into_text();
        let calls = styled_calls(style, (Format::Wgsl, lights), row_of);
        clear += calls.len() / 2;
        for call in calls {
            check_colors(&device, (&module, &call.code), &call.style, (&set, &call.inputs));
        }
    }
    assert!(clear > 8, "only {clear} clear bodies");
}

/// Expression of a number of the row.
fn row_of(k: usize) -> String {
    format!("row({k}u)")
}

/// Checks the colours that a call returns for rows of these inputs.
fn check_colors(
    device: &Device,
    (module, call): (&str, &str),
    style: &Program,
    (set, inputs): (&SampleSet, &[Input]),
) {
    let width = inputs.len().max(1);
    let columns: Vec<&[f32]> = inputs.iter().map(|input| set.input(*input)).collect();
    let mut rows = vec![0.0; width * PAIRS];
    for (k, row) in rows.chunks_exact_mut(width).enumerate() {
        row.iter_mut().zip(&columns).for_each(|(number, column)| *number = column[k]);
    }
    let text = format!("{module}{}", main_of(call, width));
    let found = run_rows(device, &text, &rows, width);
    let mut wanted = Vec::new();
    CanonicalEvaluator::default().eval(&[style], set, &mut wanted).unwrap();
    for (k, found) in found.iter().enumerate() {
        for channel in 0..3 {
            let wanted = wanted[channel * PAIRS + k];
            let apart = (found[channel] - wanted).abs();
            assert!(apart < 1e-3, "{call}, point {k}: {found:?} {wanted}\n{module}");
        }
    }
}

#[test]
fn layers_are_added_to_the_squares_before_the_output_stage() {
    let Some(device) = device() else { return };
    let pairs: Vec<_> = pairs(PAIRS).into_iter().filter(|[wi, wo]| wi.z.min(wo.z) > 0.05).collect();
    let uv = |k: usize| DVec2::new(k as f64 / 64.0, 1.0 - k as f64 / 256.0);
    let directions: Vec<_> =
        pairs.iter().map(|[wi, wo]| brood_brdf::DirectionPair::new(*wi, *wo).unwrap()).collect();
    let uvs: Vec<DVec2> = (0..pairs.len()).map(uv).collect();
    let set = SampleSet::from_pairs(&directions, &uvs);
    let rows: Vec<_> = pairs.iter().zip(&uvs).map(|(pair, uv)| row(*pair, *uv)).collect();
    let programs: Vec<Program> = layered_programs();
    let mut errors = Vec::new();
    for program in &programs {
        let found = run(&device, &export(program, Format::Wgsl), &rows);
        let mut wanted = Vec::new();
        CanonicalEvaluator::default().eval(&[program], &set, &mut wanted).unwrap();
        for (k, found) in found.iter().enumerate() {
            for channel in 0..3 {
                let wanted = wanted[channel * pairs.len() + k];
                errors.push(f64::from((found[channel] - wanted).abs() / (1e-3 + wanted.abs())));
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |share: usize| errors[errors.len() * share / 100];
    println!("median {:.1e}, 99 of 100 within {:.1e}", at(50), at(99));
    assert!(at(50) < 1e-7 && at(99) < 5e-6, "{} {}", at(50), at(99));
}
