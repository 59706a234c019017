#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    joton_fuzz::checks::paths(bytes);
});
