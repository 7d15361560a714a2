//! The cost of the steps of a query.

/// The cost of each step of a query on a machine, in seconds. The core has no clock: a caller with one measures them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CostConstants {
    /// A query, whatever it does.
    pub query: f64,
    /// A tool triangle placed.
    pub tool_triangle: f64,
    /// A voxel visited.
    pub voxel: f64,
    /// A list entry read.
    pub entry: f64,
    /// A pair of triangles met for the first time: remembered, and its boxes compared.
    pub pair: f64,
    /// A pair with overlapping boxes: the triangle test.
    pub test: f64,
}

impl Default for CostConstants {
    /// Measured on one machine of 2024; their ratios, which decide the size, differ little on others.
    fn default() -> CostConstants {
        CostConstants {
            query: 1.2e-5,
            tool_triangle: 4.0e-8,
            voxel: 3.0e-9,
            entry: 4.0e-10,
            pair: 9.0e-9,
            test: 3.5e-8,
        }
    }
}

impl CostConstants {
    crate::setters! {
        with_query: query: f64,
        with_tool_triangle: tool_triangle: f64,
        with_voxel: voxel: f64,
        with_entry: entry: f64,
        with_pair: pair: f64,
        with_test: test: f64,
    }
}
