#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    joton_fuzz::let_guarded_panics_pass();
    joton_fuzz::checks::exr(bytes);
});
