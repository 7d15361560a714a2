//! Counting sort in linear time, stable, for few distinct keys of any size.

use feeler_core::index::interner::Interner;

/// Sorts lists by part; its working memory.
#[derive(Debug, Default)]
pub(crate) struct PartSort {
    numbers: Interner,
    /// By number of the part: the part, how many entries, and where the next one goes.
    parts: Vec<(u32, usize, usize)>,
    order: Vec<usize>,
    number_of: Vec<u32>,
}

impl PartSort {
    /// Puts a list into `out`, sorted by part; entries of one part stay in their order. Returns the parts, ascending, each with its
    /// entries.
    pub fn sort<'a, 'b, T: Copy, F: Fn(&T) -> u32>(
        &'a mut self,
        list: &[T],
        part: F,
        out: &'b mut Vec<T>,
    ) -> impl Iterator<Item = (u32, &'b [T])> + use<'a, 'b, T, F> {
        let PartSort { numbers, parts, order, number_of } = self;
        numbers.clear();
        parts.clear();
        number_of.clear();
        let mut last = None;
        for x in list {
            let part = part(x);
            // Entries of one part mostly come in runs.
            let number = match last {
                Some((of, number)) if of == part => number,
                _ => numbers.number(u64::from(part)).0,
            };
            last = Some((part, number));
            if parts.len() == number as usize {
                parts.push((part, 0, 0));
            }
            parts[number as usize].1 += 1;
            number_of.push(number);
        }
        order.clear();
        order.extend(0..parts.len());
        order.sort_unstable_by_key(|i| parts[*i].0);
        let mut from = 0;
        for i in order.iter() {
            parts[*i].2 = from;
            from += parts[*i].1;
        }
        out.clear();
        out.extend_from_slice(list);
        for (x, number) in list.iter().zip(number_of.iter()) {
            let to = &mut parts[*number as usize].2;
            out[*to] = *x;
            *to += 1;
        }
        let (order, parts, out) = (&*order, &*parts, &*out);
        order.iter().map(move |i| {
            let (part, count, to) = parts[*i];
            (part, &out[to - count..to])
        })
    }
}

/// Turns the lengths of lists, the second numbers, into empty ranges where each list begins when they are laid out one after the
/// other (an exclusive prefix sum): pushing an entry raises the range's end.
pub(crate) fn lay_out<'a>(lists: impl Iterator<Item = &'a mut (u32, u32)>) {
    let mut begin = 0;
    for of in lists {
        let count = of.1;
        *of = (begin, begin);
        begin += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sorts_as_a_stable_sort_does() {
        let list: Vec<(u32, usize)> = (0..1000).map(|i| ((i * i % 37 / 3 * 1000) as u32, i)).collect();
        let mut expected = list.clone();
        expected.sort_by_key(|x| x.0);
        let (mut sorter, mut found) = (PartSort::default(), Vec::new());
        for _ in 0..2 {
            let by_part: Vec<_> = sorter.sort(&list, |x| x.0, &mut found).map(|(part, x)| (part, x.to_vec())).collect();
            let chunks = expected.chunk_by(|x, y| x.0 == y.0).map(|x| (x[0].0, x.to_vec()));
            assert!(by_part.into_iter().eq(chunks));
            assert_eq!(found, expected);
        }
        assert_eq!(sorter.sort(&list[..0], |x| x.0, &mut found).count(), 0);
        assert!(found.is_empty());
    }
}
