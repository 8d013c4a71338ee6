//! The smallest part of a scene that still fails: parts are left out, in large groups first, while the failure stays (Zeller's
//! delta debugging).

/// Of `groups` of parts, those that are needed for `fails` to hold: first whole groups are left out, then single parts. No
/// single part of the result can be left out. `fails` is asked at most `most` times.
///
/// ```
/// use umbrage_verify::random::reduce;
/// let groups = vec![vec![0, 1, 2], vec![3], vec![4, 5]];
/// let fails = |parts: &[usize]| parts.contains(&1) && parts.contains(&5);
/// assert_eq!(reduce(&groups, fails, 100), [1, 5]);
/// ```
pub fn reduce(groups: &[Vec<usize>], mut fails: impl FnMut(&[usize]) -> bool, most: usize) -> Vec<usize> {
    let mut asked = 0;
    let mut ask = |groups: &[Vec<usize>]| {
        asked += 1;
        asked <= most && fails(&groups.concat())
    };
    let of_groups = smallest(groups.to_vec(), &mut ask);
    let single: Vec<Vec<usize>> = of_groups.concat().into_iter().map(|part| vec![part]).collect();
    smallest(single, &mut ask).concat()
}

/// Leaves out half of the list, a quarter, and so on to single members, as long as anything can be left out.
fn smallest(mut list: Vec<Vec<usize>>, fails: &mut impl FnMut(&[Vec<usize>]) -> bool) -> Vec<Vec<usize>> {
    let mut step = list.len().div_ceil(2);
    while step > 0 {
        let (mut first, before) = (0, list.len());
        while first < list.len() {
            let end = (first + step).min(list.len());
            let without = [&list[..first], &list[end..]].concat();
            if !without.is_empty() && fails(&without) {
                list = without;
            } else {
                first = end;
            }
        }
        // Where something went, what was needed with it may go, too.
        step = if step == 1 && list.len() < before { 1 } else { step / 2 };
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_can_go_stays() {
        let groups: Vec<Vec<usize>> = (0..40).map(|i| (3 * i..3 * i + 3).collect()).collect();
        let mut calls = 0;
        let kept = reduce(
            &groups,
            |parts| {
                calls += 1;
                [7, 64, 65, 119].iter().all(|part| parts.contains(part))
            },
            1000,
        );
        assert_eq!(kept, [7, 64, 65, 119]);
        assert!(calls < 120, "{calls}");
    }

    #[test]
    fn it_stops_when_told() {
        assert_eq!(reduce(&[vec![0], vec![1]], |_| true, 0), [0, 1]);
    }
}
