//! The scenarios of the driver's own tests, judged by the types of the maker's crate: states before the driver reads them, commands
//! after it wrote them.

#[path = "../../../crates/feeler-devices/tests/common/mod.rs"]
mod common;
#[path = "../../../crates/feeler-devices/tests/haply_scenarios/mod.rs"]
mod haply_scenarios;

use haply_judge as judge;
