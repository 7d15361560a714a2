#![no_main]

use feeler_fuzz::distance::{check, Case};

libfuzzer_sys::fuzz_target!(|case: Case| check(case));
