#![no_main]

use feeler_fuzz::saved_scene::{check, Case};

libfuzzer_sys::fuzz_target!(|case: Case| check(case));
