//! Every operation of every level against the plain twin, bit for bit.

use proptest::prelude::*;

use super::arithmetic::{
    few_lanes, part_lanes, Arithmetic, ByteBoxes, CacheLine, Kernel, Simd, Wide, LANES, WIDE_LANES,
};
use super::level::Level;

/// What the operations are done on.
#[derive(Debug)]
struct Given {
    single: [[f32; LANES]; 3],
    double: [[f64; WIDE_LANES]; 3],
    /// Lower and upper sides of sixteen boxes.
    sides: [[[f32; LANES]; 3]; 2],
    boxes: ByteBoxes,
    bytes: [u8; LANES],
    fields: [u32; LANES],
    places: [u32; LANES],
}

/// Results by name. All NaN count as one: which of them an operation makes is a matter of the CPU.
type Results = Vec<(&'static str, Vec<u64>)>;

fn single(numbers: &[f32]) -> Vec<u64> {
    numbers.iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits().into() }).collect()
}

fn double(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect()
}

/// A zero without its sign.
fn unsigned(x: f32) -> f32 {
    x + 0.0
}

/// All operations whose results are the same at each level.
struct Operations<'a>(&'a Given);

impl Kernel for Operations<'_> {
    type Output = Results;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Results {
        let given = self.0;
        let mut results = arithmetic(s, given);
        of_parts(s, given, &mut results);
        of_lists(s, given, &mut results);
        of_boxes(s, given, &mut results);
        results
    }
}

#[inline(always)]
fn arithmetic<S: Simd>(s: S, given: &Given) -> Results {
    let lanes = |x: S::F32| {
        let mut to = [0.0; LANES];
        s.store(x, &mut to);
        single(&to)
    };
    let wide_lanes = |x: S::F64| {
        let mut to = Wide::default();
        s.wide_store(x, &mut to);
        double(&*to)
    };
    let [a, b, c] = [s.load(&given.single[0]), s.load(&given.single[1]), s.load(&given.single[2])];
    let [p, q, r] = [s.wide_load(&given.double[0]), s.wide_load(&given.double[1]), s.wide_load(&given.double[2])];
    let (above, other) = (s.above(a, b), s.above(b, c));
    let (wide_above, wide_other) = (s.wide_above(p, q), s.wide_above(q, r));
    // Not promised for NaN.
    let number = |x: S::F32| s.blend(s.above(s.splat(f32::INFINITY), s.abs(x)), x, s.splat(-2.0));
    let (m, n) = (number(a), number(b));
    let numbers = [m, n, number(c)];
    vec![
        ("splat", lanes(s.splat(given.single[0][0]))),
        ("add", lanes(a + b)),
        ("subtract", lanes(a - b)),
        ("multiply", lanes(a * b)),
        ("min", lanes(s.min(a, b))),
        ("max", lanes(s.max(a, b))),
        ("abs", lanes(s.abs(a))),
        ("min_abs", lanes(s.min_abs(m, n))),
        ("max_abs", lanes(s.max_abs(m, n))),
        ("above", vec![s.lanes(above).into()]),
        ("above, either", vec![s.lanes(above | other).into()]),
        ("above, one", vec![s.lanes(above ^ other).into()]),
        ("blend", lanes(s.blend(above, a, c))),
        ("narrowed", lanes(s.narrowed(p, q))),
        ("wide_splat", wide_lanes(s.wide_splat(given.double[0][0]))),
        ("wide add", wide_lanes(p + q)),
        ("wide subtract", wide_lanes(p - q)),
        ("wide multiply", wide_lanes(p * q)),
        ("wide_divide", wide_lanes(s.wide_divide(p, q))),
        ("wide_abs", wide_lanes(s.wide_abs(p))),
        ("wide_min", wide_lanes(s.wide_min(p, q))),
        ("wide_max", wide_lanes(s.wide_max(p, q))),
        ("wide_above", vec![s.bits(wide_above).into()]),
        ("choose", wide_lanes(s.choose(wide_above, p, r))),
        ("differing", vec![s.bits(s.differing(wide_above, wide_other)).into()]),
        ("both", vec![s.bits(s.both(wide_above, wide_other)).into()]),
        ("either", vec![s.bits(s.either(wide_above, wide_other)).into()]),
        ("smallest3", single(&s.smallest3(&numbers).map(unsigned))),
        ("largest3", single(&s.largest3(&numbers).map(unsigned))),
    ]
}

/// Lanes part by part, and a few at a time, whatever their number.
#[inline(always)]
fn of_parts<S: Simd>(s: S, given: &Given, results: &mut Results) {
    let part = s.part();
    let [x, y, z] = &given.single;
    let mut found = [[0.0; LANES]; 9];
    let (mut above, mut few_above) = (0, 0);
    for at in (0..LANES).step_by(part_lanes::<S>()) {
        let (a, b) = (s.load_part(x, at), s.load_part(y, at));
        above |= part.lanes(part.above(a, b)) << at;
        let values = [
            a + b,
            part.min(a, b),
            part.max(a, b),
            part.blend(part.above(a, b), b, s.load_part(z, at)),
            s.widen_bytes(&given.bytes, at),
            s.widen_field(&given.fields, at, 0),
            s.widen_field(&given.fields, at, 1),
            s.widen_field(&given.fields, at, 2),
        ];
        for (value, to) in values.into_iter().zip(&mut found) {
            s.store_part(value, to, at);
        }
    }
    let few = s.few();
    for at in (0..LANES).step_by(few_lanes::<S>()) {
        let (a, b) = (s.load_few(x, at), s.load_few(y, at));
        few_above |= few.lanes(few.above(a, b)) << at;
        s.store_few(few.max(a, b), &mut found[8], at);
    }
    results.push(("part by part", found.iter().flat_map(|x| single(x)).collect()));
    results.push(("above, part by part", vec![above.into(), few_above.into()]));
}

/// Compares the operations that read from lists and write to them.
#[inline(always)]
fn of_lists<S: Simd>(s: S, given: &Given, results: &mut Results) {
    let points: [[f64; 3]; WIDE_LANES] = std::array::from_fn(|i| [0, 1, 2].map(|a| given.double[a][i]));
    let lines: [CacheLine; LANES] = std::array::from_fn(|i| CacheLine {
        wide: points[i % WIDE_LANES].map(|x| x + i as f64),
        narrow: std::array::from_fn(|k| (100 * i + k) as f32),
    });
    let faces: [[u32; 3]; LANES] = std::array::from_fn(|i| [i, 3 * i + 1, 5 * i + 2].map(|k| (k % WIDE_LANES) as u32));
    let part = s.part();
    let (lanes, wide) = (part_lanes::<S>(), part_lanes::<S>() / 2);
    let mut read = vec![[0.0; LANES]; 13 + 9];
    for at in (0..LANES).step_by(lanes) {
        let ([low, high], narrow) = s.lines_part(&lines, &given.places[at..]);
        let first = s.faces_part(&faces, &points, &given.places[at..]);
        let next = s.faces_part(&faces, &points, &given.places[at + wide..]);
        for k in 0..10 {
            s.store_part(narrow[k], &mut read[k], at);
        }
        for a in 0..3 {
            s.store_part(part.narrowed(low[a], high[a]), &mut read[10 + a], at);
            for c in 0..3 {
                s.store_part(part.narrowed(first[c][a], next[c][a]), &mut read[13 + 3 * c + a], at);
            }
        }
    }
    results.push(("lines_part, faces_part", read.iter().flat_map(|x| single(x)).collect()));
    let mut by_axis = Vec::new();
    for x in s.wide_points(std::array::from_fn(|i| &points[i])) {
        let mut to = [0.0; WIDE_LANES];
        s.wide_store(x, &mut to);
        by_axis.extend(double(&to));
    }
    results.push(("wide_points", by_axis));
    let mut by_lane = [[7.0; 4]; LANES];
    s.transposed(&[s.load(&given.single[0]), s.load(&given.single[1]), s.load(&given.single[2])], &mut by_lane);
    results.push(("transposed", single(by_lane.as_flattened())));
}

/// Comparisons of boxes, in float32 and in bytes.
#[inline(always)]
fn of_boxes<S: Simd>(s: S, given: &Given, results: &mut Results) {
    let [lower, upper] = &given.sides;
    let (mut apart, mut met) = (Vec::new(), Vec::new());
    for i in 0..LANES {
        // The fourth number is none of theirs.
        let of = |sides: &[[f32; LANES]; 3], i: usize| [sides[0][i], sides[1][i], sides[2][i], given.single[0][i]];
        let (next_lower, next_upper) = (of(lower, (i + 1) % LANES), of(upper, (i + 1) % LANES));
        let (lower, upper) = (of(lower, i), of(upper, i));
        apart.push(u64::from(s.is_apart([&lower, &upper], [&next_lower, &next_upper])));
        met.push(u64::from(s.children_meeting(&given.boxes, [&lower, &upper])));
    }
    results.push(("is_apart", apart));
    results.push(("children_meeting", met));
    let lanes = s.in_bytes(&given.boxes, [lower, upper]);
    let bytes = lanes.least.as_flattened().iter().map(|x| u64::from(*x));
    results.push(("in_bytes", bytes.chain([lanes.outside.into()]).collect()));
    let met = (0..2 * LANES).map(|i| s.lanes_meeting(&lanes, &given.boxes, i).into());
    results.push(("lanes_meeting", met.collect()));
}

/// `a * b + c` and `a * b - c`, single and double.
struct MultiplyAdd<'a>(&'a Given);

impl Kernel for MultiplyAdd<'_> {
    type Output = ([[f32; LANES]; 2], [[f64; WIDE_LANES]; 2]);

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let mut found = ([[0.0; LANES]; 2], [[0.0; WIDE_LANES]; 2]);
        let [a, b, c] = [s.load(&self.0.single[0]), s.load(&self.0.single[1]), s.load(&self.0.single[2])];
        s.store(s.mul_add(a, b, c), &mut found.0[0]);
        s.store(s.mul_sub(a, b, c), &mut found.0[1]);
        let [a, b, c] = [0, 1, 2].map(|i| s.wide_load(&self.0.double[i]));
        s.wide_store(s.wide_mul_add(a, b, c), &mut found.1[0]);
        s.wide_store(s.wide_mul_sub(a, b, c), &mut found.1[1]);
        found
    }
}

fn number() -> impl Strategy<Value = f32> {
    let special = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE / 4.0, f32::MAX];
    prop_oneof![
        2 => prop::sample::select(special.to_vec()),
        2 => (-3..=3i8).prop_map(f32::from),
        1 => (-600..600i16).prop_map(|x| 0.5 * f32::from(x)),
        3 => -2.0..2.0f32,
        1 => any::<f32>(),
    ]
}

/// Those of float32, and with bits that these have no room for.
fn wide_number() -> impl Strategy<Value = f64> {
    let finer = (number(), 0..1u64 << 29).prop_map(|(x, rest)| match f64::from(x) {
        x if x.is_finite() && x != 0.0 => f64::from_bits(x.to_bits() | rest),
        x => x,
    });
    prop_oneof![number().prop_map(f64::from), finer, any::<f64>()]
}

/// The next numbers of a list.
fn next<T: Copy, const N: usize>(list: &mut std::vec::IntoIter<T>) -> [T; N] {
    std::array::from_fn(|_| list.next().expect("as many as are taken"))
}

fn given() -> impl Strategy<Value = Given> {
    // As lists: arrays of strategies would fill the stack.
    let byte = prop_oneof![any::<u8>(), prop::sample::select(vec![0u8, 1, 127, 128, 254, 255])];
    let lists = (
        prop::collection::vec(number(), 9 * LANES),
        prop::collection::vec(wide_number(), 3 * WIDE_LANES),
        prop::collection::vec(prop_oneof![Just(0.0f32), number()], 4),
        prop::collection::vec(prop_oneof![Just(1.0f32), Just(100.0), number()], 4),
        prop::collection::vec(byte, 3 * 64 + LANES),
        prop::collection::vec(any::<u32>(), 2 * LANES),
    );
    lists.prop_map(|(single, double, origin, per_unit, bytes, words)| {
        let (mut single, mut double, mut bytes) = (single.into_iter(), double.into_iter(), bytes.into_iter());
        let (mut origin, mut per_unit, mut words) = (origin.into_iter(), per_unit.into_iter(), words.into_iter());
        Given {
            single: [0; 3].map(|_| next(&mut single)),
            sides: [0; 2].map(|_| [0; 3].map(|_| next(&mut single))),
            double: [0; 3].map(|_| next(&mut double)),
            boxes: ByteBoxes {
                sides: [0; 3].map(|_| next(&mut bytes)),
                origin: next(&mut origin),
                per_unit: next(&mut per_unit),
            },
            bytes: next(&mut bytes),
            fields: next(&mut words),
            places: next(&mut words).map(|place: u32| place % LANES as u32),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn every_operation_gives_the_bits_of_plain_code(given in given()) {
        let expected = Level::Portable.checked().run(Operations(&given));
        for level in Level::available() {
            let found = level.checked().run(Operations(&given));
            prop_assert_eq!(found.len(), expected.len());
            for ((name, found), (_, expected)) in found.iter().zip(&expected) {
                prop_assert_eq!(found, expected, "{} at level {}", name, level.name());
            }
        }
    }

    #[test]
    fn multiply_and_add_rounds_once_or_twice(given in given()) {
        let ([a, b, c], [p, q, r]) = (given.single, given.double);
        for level in Level::available() {
            let (found, wide_found) = level.checked().run(MultiplyAdd(&given));
            for (k, sign) in [1.0f32, -1.0].into_iter().enumerate() {
                for i in 0..LANES {
                    let once = a[i].mul_add(b[i], sign * c[i]);
                    let either = single(&[once, a[i] * b[i] + sign * c[i]]);
                    prop_assert!(either.contains(&single(&[found[k][i]])[0]), "{} {} {} {}", level.name(), a[i], b[i], c[i]);
                }
                let sign = f64::from(sign);
                for i in 0..WIDE_LANES {
                    let once = p[i].mul_add(q[i], sign * r[i]);
                    let either = double(&[once, p[i] * q[i] + sign * r[i]]);
                    prop_assert!(either.contains(&double(&[wide_found[k][i]])[0]), "{} {} {} {}", level.name(), p[i], q[i], r[i]);
                }
            }
        }
    }
}
