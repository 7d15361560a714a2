//! The instruction sets, and which of them the CPU has.

use std::sync::OnceLock;

use super::arithmetic::Kernel;
#[cfg(all(target_arch = "aarch64", target_endian = "little"))]
use super::neon;
use super::portable;
#[cfg(target_arch = "x86_64")]
use super::{avx2, avx512};

/// An instruction set the kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Level {
    /// Plain code, as good as the compiler's own vectors for the baseline CPU.
    Portable,
    /// NEON (64-bit ARM).
    Neon,
    /// AVX2 and FMA (x86-64-v3).
    Avx2,
    /// AVX-512 F, BW, DQ, VL (x86-64-v4).
    Avx512,
}

impl Level {
    /// All levels this CPU has, the best last.
    pub fn available() -> Vec<Level> {
        let all = [Level::Portable, Level::Neon, Level::Avx2, Level::Avx512];
        all.into_iter().filter(|level| level.is_available()).collect()
    }

    /// The best level this CPU has.
    #[inline]
    pub fn best() -> Level {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| Level::available().pop().unwrap_or(Level::Portable))
    }

    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Level::Portable => "portable",
            Level::Neon => "neon",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }

    /// Whether this CPU has it.
    pub fn is_available(self) -> bool {
        match self {
            Level::Portable => true,
            #[cfg(all(target_arch = "aarch64", target_endian = "little"))]
            Level::Neon => neon::is_there(),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => avx2::is_there(),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => avx512::is_there(),
            _ => false,
        }
    }

    /// This level, or the best one where the CPU lacks it.
    pub fn checked(self) -> Checked {
        Checked(if self.is_available() { self } else { Level::best() })
    }
}

/// A level this CPU has.
#[derive(Debug, Clone, Copy)]
pub struct Checked(Level);

impl Checked {
    /// Which one.
    pub fn level(self) -> Level {
        self.0
    }

    /// Runs a kernel compiled for this level.
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            // SAFETY: only `Level::checked` makes such a value, and it asked the CPU.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512::run_avx512(kernel) },
            // SAFETY: the same.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2::run_avx2(kernel) },
            // SAFETY: the same.
            #[cfg(all(target_arch = "aarch64", target_endian = "little"))]
            Level::Neon => unsafe { neon::run_neon(kernel) },
            _ => kernel.run(portable::TOKEN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::arithmetic::{CacheLine, Kernel, Simd, LANES, WIDE_LANES};
    use super::*;

    /// What is appended of the numbers 100 to 115 and of those from 1000 on, for each choice of lanes.
    struct Appended;

    impl Kernel for Appended {
        type Output = (Vec<Vec<u32>>, Vec<Vec<u64>>);

        fn run<S: Simd>(self, s: S) -> Self::Output {
            let (from, wide_from) = (std::array::from_fn(|i| 100 + i as u32), std::array::from_fn(|i| 1000 + i as u64));
            let single = (0..=u16::MAX).map(|chosen| {
                let mut to = vec![7; 3 + LANES];
                let end = s.append(chosen, &from, &mut to, 3);
                assert_eq!(to[..3], [7; 3]);
                to[3..end].to_vec()
            });
            let wide = (0..=u8::MAX).map(|chosen| {
                let mut to = vec![7; 1 + WIDE_LANES];
                let end = s.append_wide(chosen, &wide_from, &mut to, 1);
                assert_eq!(to[0], 7);
                to[1..end].to_vec()
            });
            (single.collect(), wide.collect())
        }
    }

    #[test]
    fn chosen_lanes_are_appended_in_order() {
        for level in Level::available() {
            let (single, wide) = level.checked().run(Appended);
            for (chosen, found) in single.iter().enumerate() {
                let expected: Vec<u32> = (0..16).filter(|i| chosen >> i & 1 == 1).map(|i| 100 + i).collect();
                assert_eq!(*found, expected, "{} {chosen:016b}", level.name());
            }
            for (chosen, found) in wide.iter().enumerate() {
                let expected: Vec<u64> = (0..8).filter(|i| chosen >> i & 1 == 1).map(|i| 1000 + i).collect();
                assert_eq!(*found, expected, "{} {chosen:08b}", level.name());
            }
        }
    }

    /// Comparisons and choices of single and double numbers: the bits of `a > b`, and the numbers chosen by them.
    struct Compared([f32; LANES], [f32; LANES]);

    impl Kernel for Compared {
        type Output = (u16, [f32; LANES], u8, [f64; WIDE_LANES]);

        fn run<S: Simd>(self, s: S) -> Self::Output {
            let (a, b) = (s.load(&self.0), s.load(&self.1));
            let (none, mut chosen) = (s.above(a, a), [0.0; LANES]);
            let above = s.above(a, b) | none;
            s.store(s.blend(above, a, b), &mut chosen);
            let wide = |x: &[f32; LANES]| s.wide_load(&std::array::from_fn(|i| f64::from(x[i])));
            let (a, b) = (wide(&self.0), wide(&self.1));
            let (wide_above, mut wide_chosen) = (s.wide_above(a, b), [0.0; WIDE_LANES]);
            s.wide_store(s.choose(wide_above, a, b), &mut wide_chosen);
            (s.lanes(above), chosen, s.bits(wide_above), wide_chosen)
        }
    }

    #[test]
    fn comparisons_choose_by_lane() {
        let numbers = [1.0, -1.0, 0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE / 4.0];
        for level in Level::available() {
            for turn in 0..LANES {
                let a: [f32; LANES] = std::array::from_fn(|i| numbers[i % 8]);
                let b: [f32; LANES] = std::array::from_fn(|i| numbers[(i + turn + i / 8) % 8]);
                let (above, chosen, wide_above, wide_chosen) = level.checked().run(Compared(a, b));
                for i in 0..LANES {
                    let expected = if a[i] > b[i] { a[i] } else { b[i] };
                    assert_eq!(above >> i & 1 == 1, a[i] > b[i], "{} {} {}", level.name(), a[i], b[i]);
                    assert_eq!(chosen[i].to_bits(), expected.to_bits(), "{} {} {}", level.name(), a[i], b[i]);
                    if i < WIDE_LANES {
                        assert_eq!(wide_above >> i & 1 == 1, a[i] > b[i], "{} {} {}", level.name(), a[i], b[i]);
                        assert_eq!(wide_chosen[i].to_bits(), f64::from(expected).to_bits(), "{}", level.name());
                    }
                }
            }
        }
    }

    /// Corners of triangles at some places, or lines.
    struct Gathered<'a>(&'a [u32], bool);

    impl Kernel for Gathered<'_> {
        type Output = ();

        fn run<S: Simd>(self, s: S) {
            let points = [[0.0; 3], [1.0; 3], [2.0; 3]];
            let faces = [[0, 1, 2], [2, 1, 0], [0, 1, 3]];
            if self.1 {
                s.faces_part(&faces, &points, self.0);
            } else {
                s.lines_part(&[CacheLine { wide: points[0], narrow: [0.0; 10] }; 3], self.0);
            }
        }
    }

    #[test]
    fn no_lane_reads_beyond_a_list() {
        for level in Level::available() {
            let is_read = |places: &[u32; LANES], by_faces: bool| {
                std::panic::catch_unwind(|| level.checked().run(Gathered(places, by_faces))).is_ok()
            };
            assert!(is_read(&[1; LANES], true) && is_read(&[2; LANES], false), "{}", level.name());
            // As many lanes as any part has at least: face 2 names a point that is not there.
            for lane in 0..2 {
                for (place, by_faces) in [(2, true), (3, true), (u32::MAX, true), (3, false), (u32::MAX, false)] {
                    let mut places = [1; LANES];
                    places[lane] = place;
                    assert!(!is_read(&places, by_faces), "{} {lane} {place} {by_faces}", level.name());
                }
            }
        }
    }
}
