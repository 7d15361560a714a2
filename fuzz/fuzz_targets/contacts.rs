#![no_main]

use feeler_fuzz::contacts::{check, Case};

libfuzzer_sys::fuzz_target!(|case: Case| check(case));
