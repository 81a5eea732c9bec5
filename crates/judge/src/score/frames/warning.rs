//! Warning before a loss: does a score rise while the tracker is still on target?
//!
//! ```text
//! imminent:  O_t < 1 and a loss begins in one of the frames t + 1 .. t + k
//! safe:      O_t < 1 and none does
//! left out:  O_t = 1; no annotation; fewer than k frames follow, and no loss begins in them
//! ```
//!
//! `O_t` is the tracking error, `t` a 0-based frame, `k` a number of frames. Losses are those of `frames/1`,
//! see [`super::truth`]. AUROC over these frames is 0.5 for a score that merely separates lost frames from
//! good ones, however well; high is good.

use super::truth::Rule;

/// Numbers of frames before a loss that count as imminent.
pub const HORIZONS: [usize; 3] = [5, 15, 30];

/// For each frame of a track, true if a loss is imminent, from the tracking errors; `None` for frames that
/// are left out.
pub fn imminent(error: &[f64], horizon: usize) -> Vec<Option<bool>> {
    let losses = Rule::NoOverlap.losses(error);
    let mut starts = losses.iter().map(|range| range.start).peekable();
    let frame = |(t, &now): (usize, &f64)| {
        while starts.next_if(|start| *start <= t).is_some() {}
        let is_imminent = starts.peek().is_some_and(|start| start - t <= horizon);
        let is_known = is_imminent || t + horizon < error.len();
        (Rule::NoOverlap.judge(now) == Some(false) && is_known).then_some(is_imminent)
    };
    error.iter().enumerate().map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const N: f64 = f64::NAN;

    fn text(error: &[f64], horizon: usize) -> String {
        let word = |e: &Option<bool>| e.map_or('-', |is_imminent| if is_imminent { '1' } else { '0' });
        imminent(error, horizon).iter().map(word).collect()
    }

    // By hand: losses begin in frames 3 and 8; a track that begins lost has no loss there.
    #[test]
    fn frames_before_a_loss_are_imminent() {
        let error = [1.0, 0.2, 0.9, 1.0, 1.0, 0.5, N, 0.0, 1.0, 0.1, 0.3, 0.0];
        assert_eq!(text(&error, 1), "-01--0-1-00-");
        assert_eq!(text(&error, 2), "-11--0-1-0--");
        assert_eq!(text(&error, 3), "-11--1-1----");
        assert_eq!(text(&[], 5), "");
        assert_eq!(text(&[0.0; 4], 2), "00--");
    }

    proptest! {
        #[test]
        fn a_longer_horizon_has_more_imminent_frames_and_fewer_safe_ones(
            error in prop::collection::vec(prop_oneof![Just(1.0), Just(N), 0.0..1.0_f64], 0..60),
            horizon in 0..40_usize,
        ) {
            for (short, long) in imminent(&error, horizon).iter().zip(imminent(&error, horizon + 1)) {
                prop_assert!(*short != Some(true) || long == Some(true), "{short:?} {long:?}");
                prop_assert!(long != Some(false) || *short == Some(false), "{short:?} {long:?}");
            }
        }
    }
}
