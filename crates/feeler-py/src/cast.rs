//! Results of continuous queries.

use std::collections::HashMap;

use feeler_core as core;
use numpy::ndarray::{Array2, Array3};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyTuple};

use crate::arrays::{at, in_order, Index, IntoReadOnly};
use crate::containment::Containment;
use crate::old_names::old_attribute;
use crate::travel::{check_lengths, damaged, list, reduced, rows_of};
use crate::words::counted;

/// The first impact of a tool on a motion between two poses.
#[pyclass(frozen, module = "feeler._core")]
#[derive(Clone, Copy)]
pub struct Cast {
    fraction: f64,
    pose: [[f64; 4]; 4],
    point: core::Point,
    normal: core::Point,
    distance: f64,
    /// Of the tool and of the mock-up.
    triangles: [u32; 2],
    parts: [u32; 2],
}

impl Cast {
    pub fn new(core: core::Cast, mockup: &core::Mockup, tool: &core::Tool) -> Cast {
        let core::Cast { fraction, point, normal, distance, tool_triangle, mockup_triangle, .. } = core;
        let parts = [tool.part_of_face(tool_triangle), mockup.part_of_face(mockup_triangle)];
        let triangles = [tool_triangle, mockup_triangle];
        Cast { fraction, pose: core.pose.matrix(), point, normal, distance, triangles, parts }
    }

    /// All its numbers, and its ids.
    fn state(&self) -> ([f64; 24], [u32; 4]) {
        let mut numbers = [0.0; 24];
        numbers[..2].copy_from_slice(&[self.fraction, self.distance]);
        numbers[2..5].copy_from_slice(&self.point);
        numbers[5..8].copy_from_slice(&self.normal);
        numbers[8..].copy_from_slice(self.pose.as_flattened());
        (numbers, [self.triangles[0], self.triangles[1], self.parts[0], self.parts[1]])
    }

    fn of_state(numbers: &[f64; 24], ids: &[u32; 4]) -> Cast {
        Cast {
            fraction: numbers[0],
            distance: numbers[1],
            point: std::array::from_fn(|a| numbers[2 + a]),
            normal: std::array::from_fn(|a| numbers[5 + a]),
            pose: std::array::from_fn(|i| std::array::from_fn(|j| numbers[8 + 4 * i + j])),
            triangles: [ids[0], ids[1]],
            parts: [ids[2], ids[3]],
        }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Cast> {
        match casts_of(state.extract()?)?[..] {
            [cast] => Ok(cast),
            _ => Err(damaged("it is not one impact")),
        }
    }
}

/// A row of numbers and one of ids for each impact.
type Rows<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

fn rows_for<'py>(py: Python<'py>, casts: &[Cast]) -> Rows<'py> {
    let rows: Vec<_> = casts.iter().map(Cast::state).collect();
    let numbers = Array2::from_shape_fn((rows.len(), 24), |(n, i)| rows[n].0[i]);
    (numbers.into_read_only(py), Array2::from_shape_fn((rows.len(), 4), |(n, i)| rows[n].1[i]).into_read_only(py))
}

fn casts_of((numbers, ids): (PyReadonlyArray2<'_, f64>, PyReadonlyArray2<'_, u32>)) -> PyResult<Vec<Cast>> {
    let (numbers, ids) = (rows_of(&numbers)?, rows_of(&ids)?);
    check_lengths("rows of ids", ids.len(), numbers.len())?;
    Ok(numbers.iter().zip(&ids).map(|(numbers, ids)| Cast::of_state(numbers, ids)).collect())
}

#[pymethods]
impl Cast {
    /// The time of impact, as a fraction of the motion, 0 to 1; never late.
    #[getter]
    fn fraction(&self) -> f64 {
        self.fraction
    }

    /// `(4, 4)`: world_from_tool at the impact.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from_shape_fn((4, 4), |(i, j)| self.pose[i][j]).into_read_only(py)
    }

    /// `(3,)`: the point of impact on the mock-up, metres, world.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.point.to_vec().into_read_only(py)
    }

    /// `(3,)`: unit normal of the contact, from mock-up to tool, world.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.normal.to_vec().into_read_only(py)
    }

    /// The remaining distance of the two triangles at the pose, metres: at most the tolerance; 0 if they collide.
    #[getter]
    fn distance(&self) -> f64 {
        self.distance
    }

    /// The tool's triangle.
    #[getter]
    fn tool_triangle(&self) -> u32 {
        self.triangles[0]
    }

    /// The mock-up's triangle.
    #[getter]
    fn mockup_triangle(&self) -> u32 {
        self.triangles[1]
    }

    /// Index into `mockup.parts` of the part hit.
    #[getter]
    fn part(&self) -> u32 {
        self.parts[1]
    }

    /// Index into `tool.parts` of the tool's part that hits it.
    #[getter]
    fn tool_part(&self) -> u32 {
        self.parts[0]
    }

    fn __repr__(&self) -> String {
        format!("Cast(fraction={:?}, part={})", self.fraction, self.parts[1])
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        reduced(py, "Cast", rows_for(py, &[*self]))
    }
}

/// The first impact of a tool on each segment of a path, from one pose to the next.
///
/// True if the path is free. Its rows are the segments, one less than poses: `check[i]` is the `Cast` of segment `i`,
/// None if it is free. A path of one pose has one segment without motion.
#[pyclass(frozen, module = "feeler._core")]
pub struct PathCheck {
    count: usize,
    /// The segments that are hit, ascending, and the first impact on each.
    hits: Vec<(usize, Cast)>,
    /// Of the first pose; `None` where it was not asked for.
    inside: Option<Containment>,
}

impl PathCheck {
    pub fn new(
        core: core::PathCheck,
        mockup: &core::Mockup,
        tool: &core::Tool,
        inside: Option<Containment>,
    ) -> PathCheck {
        let hits = core.hits.into_iter().map(|(segment, cast)| (segment, Cast::new(cast, mockup, tool))).collect();
        PathCheck { count: core.segments, hits, inside }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<PathCheck> {
        type Inside<'py> = Option<PyRef<'py, Containment>>;
        type Hits<'py> = (PyReadonlyArray1<'py, u64>, PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, u32>);
        let (count, (segments, numbers, ids), inside): (usize, Hits<'_>, Inside<'_>) = state.extract()?;
        let (segments, casts) = (list(&segments), casts_of((numbers, ids))?);
        check_lengths("segments that are hit", segments.len(), casts.len())?;
        if segments.iter().any(|segment| *segment >= count as u64) {
            return Err(damaged(format!("a segment is hit that is not among its {count}")));
        }
        let hits = segments.iter().map(|segment| *segment as usize).zip(casts).collect();
        Ok(PathCheck { count, hits, inside: inside.map(|inside| inside.clone()) })
    }

    fn points_of<'py>(&self, py: Python<'py>, of: impl Fn(&Cast) -> core::Point) -> Bound<'py, PyArray2<f64>> {
        Array2::from_shape_fn((self.hits.len(), 3), |(i, a)| of(&self.hits[i].1)[a]).into_read_only(py)
    }

    fn column<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: impl Fn(&(usize, Cast)) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        self.hits.iter().map(of).collect::<Vec<T>>().into_read_only(py)
    }
}

#[pymethods]
impl PathCheck {
    /// Whether no segment has an impact, and the tool neither contains a part nor is inside one at the first
    /// pose.
    #[getter]
    fn is_free(&self) -> bool {
        self.hits.is_empty() && !self.inside.as_ref().is_some_and(Containment::is_any)
    }

    /// Containment at the first pose; None unless `inside` was set.
    #[getter]
    fn containment(&self) -> Option<Containment> {
        self.inside.clone()
    }

    /// `(segments,)`: the first impact of each segment, as a fraction of the segment; NaN if the segment is free.
    #[getter]
    fn fractions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let mut fraction = vec![f64::NAN; self.count];
        self.hits.iter().for_each(|(segment, cast)| fraction[*segment] = cast.fraction);
        fraction.into_read_only(py)
    }

    /// `(k,)`: the segments with an impact, ascending. The rows of the following arrays belong to them.
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.column(py, |(segment, _)| *segment as u64)
    }

    /// `(k, 4, 4)`: world_from_tool at the impact.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        Array3::from_shape_fn((self.hits.len(), 4, 4), |(n, i, j)| self.hits[n].1.pose[i][j]).into_read_only(py)
    }

    /// `(k, 3)`: as `Cast.point`.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points_of(py, |cast| cast.point)
    }

    /// `(k, 3)`: as `Cast.normal`.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points_of(py, |cast| cast.normal)
    }

    /// `(k,)`: as `Cast.tool_triangle`.
    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| cast.triangles[0])
    }

    /// `(k,)`: as `Cast.mockup_triangle`.
    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| cast.triangles[1])
    }

    /// `(k,)`: as `Cast.part`.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| cast.parts[1])
    }

    /// `(k,)`: as `Cast.tool_part`.
    #[getter]
    fn tool_parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| cast.parts[0])
    }

    /// The impact of the first segment that has one: `segments[0]`.
    #[getter]
    fn first(&self) -> Option<Cast> {
        self.hits.first().map(|(_, cast)| *cast)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    fn __bool__(&self) -> bool {
        self.is_free()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        at(py, &index, (self.count, "segment"), |i| {
            Ok(self.hits.binary_search_by_key(&i, |(segment, _)| *segment).ok().map(|place| self.hits[place].1))
        })
    }

    fn __repr__(&self) -> String {
        format!("PathCheck({}, {} hit)", counted(self.count, "segment"), self.hits.len())
    }

    #[classattr]
    #[pyo3(name = "_RENAMED")]
    fn renamed() -> HashMap<&'static str, &'static str> {
        HashMap::from([("free", "is_free"), ("fraction", "fractions")])
    }

    fn __getattr__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        old_attribute(slf, name)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let casts: Vec<Cast> = self.hits.iter().map(|(_, cast)| *cast).collect();
        let (numbers, ids) = rows_for(py, &casts);
        reduced(py, "PathCheck", (self.count, (self.segments(py), numbers, ids), self.inside.clone()))
    }
}
