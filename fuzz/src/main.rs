//! Fuzzer of one parser, named by `BROOD_PARSER`. Started by `cargo xtask fuzz`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| brood_fuzz::chosen()(bytes));
