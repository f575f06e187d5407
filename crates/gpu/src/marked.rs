//! Code marked `NoContraction`: WGSL translated here instead of in the graphics API, because WGSL itself has no word
//! for it, and every sum and product of the result decorated.

#![expect(unsafe_code, reason = "handing our own SPIR-V to the driver")]

use wgpu::naga;

use crate::GpuError;
use crate::shader::ENTRY_POINT;

/// Words before the first instruction.
const HEADER: usize = 5;
const OP_DECORATE: u32 = 71;
const NO_CONTRACTION: u32 = 42;

/// A module of generated WGSL, every arithmetic result marked. Only devices with passthrough take it.
///
/// # Errors
/// [`GpuError::Rejected`] where the device does not, or the text is not valid.
pub(crate) fn module(api: &wgpu::Device, text: &str) -> Result<wgpu::ShaderModule, GpuError> {
    if !api.features().contains(wgpu::Features::PASSTHROUGH_SHADERS) {
        return Err(GpuError::Rejected("the adapter takes no SPIR-V of our own".to_owned()));
    }
    let words = mark(&translate(text)?);
    let entry_points =
        [wgpu::PassthroughShaderEntryPoint { name: ENTRY_POINT.into(), workgroup_size: (0, 0, 0) }];
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some("marked interpreter"),
        entry_points: entry_points.as_slice().into(),
        spirv: Some(words.into()),
        ..Default::default()
    };
    // SAFETY: the words are naga's translation of a module that it validated, bounds checks included, and decorations
    // that change rounding only; the text is our own.
    Ok(unsafe { api.create_shader_module_passthrough(descriptor) })
}

/// SPIR-V of a compute shader, indices checked, in the version that every driver takes.
fn translate(text: &str) -> Result<Vec<u32>, GpuError> {
    use naga::back::spv;
    use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    let rejected = |reason: String| GpuError::Rejected(reason);
    let module =
        naga::front::wgsl::parse_str(text).map_err(|e| rejected(e.emit_to_string(text)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| rejected(e.emit_to_string(text)))?;
    let bindings = module.global_variables.iter().filter_map(|(_, variable)| variable.binding);
    let binding_map = bindings.map(|at| {
        let info = spv::BindingInfo {
            descriptor_set: at.group,
            binding: at.binding,
            binding_array_size: None,
        };
        (at, info)
    });
    let options = spv::Options {
        flags: spv::WriterFlags::empty(),
        fake_missing_bindings: false,
        binding_map: binding_map.collect(),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Restrict,
            image_load: BoundsCheckPolicy::Restrict,
            binding_array: BoundsCheckPolicy::Restrict,
        },
        // Registers are written before they are read, and so is everything else.
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        ..spv::Options::default()
    };
    let entry = spv::PipelineOptions {
        shader_stage: naga::ShaderStage::Compute,
        entry_point: ENTRY_POINT.to_owned(),
    };
    spv::write_vec(&module, &info, &options, Some(&entry)).map_err(|e| rejected(e.to_string()))
}

/// The module with a decoration for the result of every floating-point sum, difference, product and negation.
fn mark(words: &[u32]) -> Vec<u32> {
    let mut decorations = Vec::new();
    let mut declarations = None;
    for (at, opcode) in instructions(words) {
        if is_arithmetic(opcode) {
            decorations.extend([3 << 16 | OP_DECORATE, words[at + 2], NO_CONTRACTION]);
        }
        // OpTypeVoid to OpTypeForwardPointer; decorations belong before the first of them.
        if (19..=39).contains(&opcode) {
            declarations.get_or_insert(at);
        }
    }
    let declarations = declarations.expect("every module declares a type");
    [&words[..declarations], &decorations, &words[declarations..]].concat()
}

/// Place and opcode of every instruction.
fn instructions(words: &[u32]) -> impl Iterator<Item = (usize, u32)> {
    let mut at = HEADER;
    std::iter::from_fn(move || {
        let head = *words.get(at)?;
        let this = at;
        at += ((head >> 16) as usize).max(1);
        Some((this, head & 0xffff))
    })
}

/// FNegate, FAdd, FSub, FMul, FDiv, FRem, FMod, VectorTimesScalar, Dot.
fn is_arithmetic(opcode: u32) -> bool {
    matches!(opcode, 127 | 129 | 131 | 133 | 136 | 140 | 141 | 142 | 148)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guard::Guard;
    use crate::shader::{Kernel, Style, Variant, source};
    use crate::shape::Shape;

    #[test]
    fn every_sum_and_product_is_marked_once_and_nothing_else_changes() {
        let style =
            Style { guard: Guard::NoContraction, shape: Shape::default(), contracts: false };
        for kernel in [Kernel::Reflectance, Kernel::Fitness] {
            let text = source(Variant { kernel, style, registers: 16 });
            let plain = translate(&text).unwrap();
            let marked = mark(&plain);
            let results: Vec<u32> = instructions(&plain)
                .filter(|(_, opcode)| is_arithmetic(*opcode))
                .map(|(at, _)| plain[at + 2])
                .collect();
            assert!(results.len() > 25, "{}", results.len());
            let decorated: Vec<u32> = instructions(&marked)
                .filter(|(at, opcode)| *opcode == OP_DECORATE && marked[at + 2] == NO_CONTRACTION)
                .map(|(at, _)| marked[at + 1])
                .collect();
            assert_eq!(decorated, results);
            let mut rest = marked[..HEADER].to_vec();
            for (at, opcode) in instructions(&marked) {
                let length = (marked[at] >> 16) as usize;
                if opcode != OP_DECORATE || marked[at + 2] != NO_CONTRACTION {
                    rest.extend(&marked[at..at + length]);
                }
            }
            assert_eq!(rest, plain);
        }
    }
}
