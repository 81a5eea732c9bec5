use super::*;
use crate::detector::testing;
use crate::num::seed;
use proptest::prelude::*;
use rand::{Rng, RngExt};
use trackfail_testing::assert_near;

fn detect(text: &str, signal: &[f64]) -> DetectorOutput {
    testing::detect(&ENTRY, text, signal)
}

// By hand: X is 1.2, 1.2 * 4/3 and that times 10/7, which is an alarm and ends the test; then mu = 1/2, g = 1/4, v = 1/16,
// l = 2, and X is 1 + 2 (3/4 - 1/4) = 1 / alpha.
#[test]
fn a_wealth_at_the_limit_is_an_alarm() {
    let output = detect("{ below = 0.75, alpha = 0.5, after = \"restart\" }", &[0.5, 0.5, 0.5, 0.25]);
    assert_eq!((output.score[3], output.alarm), (2.0_f64.ln(), vec![false, false, true, true]));
}

#[test]
fn a_state_that_no_track_leads_to_is_refused() {
    let detector = ENTRY.build_from_text("{ below = 0.75 }").unwrap();
    let takes = |change: fn(&mut Bets), wealth: f64| {
        let mut bets =
            SequentialTest::new(Params { below: Some(0.75), ..Params::default() }).unwrap().begin().0;
        change(&mut bets);
        let memory = ((bets, wealth), crate::detector::labels::LossState::default());
        detector.stream().unwrap().restore(&crate::saved::to_bytes(&memory).unwrap())
    };
    assert!(takes(|_| {}, 0.0) && takes(|bets| bets.add(0.5, None), -2.0));
    let bad: [fn(&mut Bets); 5] = [
        |b| b.largest = -1.0,
        |b| b.largest = f64::NAN,
        |b| b.eps = 0.5,
        |b| b.sum = f64::INFINITY,
        |b| b.frames.push_back((0.5, 0.0)),
    ];
    assert_eq!(bad.map(|change| takes(change, 0.0)), [false; 5]);
    assert!(!takes(|_| {}, f64::NAN));
}

// Beside a value of 1, or its square, the next one is lost to rounding, and is missing when it leaves the window.
#[test]
fn sums_over_a_window_are_never_negative() {
    let third = 0.625 + 5e-10;
    for (window, qualities) in
        [(1, [0.0, 1.0, 1e-16, 0.0]), (2, [1.0, 0.75 + 1e-9, third, (0.5 + third) / 2.0])]
    {
        let mut bets = Bets { eps: 0.5, largest: 1.0, ..Bets::default() };
        qualities.iter().for_each(|quality| bets.add(*quality, Some(window)));
        assert!(bets.sum >= 0.0 && bets.squares >= 0.0, "{bets:?}");
    }
}

const Y: [f64; 12] = [0.125, 0.25, 0.0, 0.75, 0.5, 0.0, 0.0, 1.0, 0.125, 0.0625, 0.0, 0.0];

/// The wealth by its definition, eps and the largest bet being .5, over all frames or the last `window` of them. Before the
/// first frame the mean is eps, and its square the variance.
fn wealth(window: usize) -> [f64; 12] {
    let (mut squares, mut x) = (Vec::new(), 0.0);
    std::array::from_fn(|t| {
        let of_last = |list: &[f64], first: f64| {
            let last = &list[list.len().saturating_sub(window)..];
            (first + last.iter().sum::<f64>()) / (last.len() as f64 + 1.0)
        };
        let (off, variance) = (0.5 - of_last(&Y[..t], 0.5), of_last(&squares, 0.25));
        let bet = (off / (variance + off * off)).clamp(0.0, 1.0);
        x += f64::ln_1p(bet * (0.5 - Y[t]));
        squares.push((Y[t] - of_last(&Y[..=t], 0.5)).powi(2));
        x
    })
}

#[test]
fn the_wealth_is_that_of_a_direct_computation() {
    // python3 with numpy: the last of both lists.
    assert_near([wealth(12)[11], wealth(3)[11]], [1.9509990636512085, 1.0097855937282905], 1e-13, "");
    for (more, window) in [("", 12), ("window = 3, ", 3)] {
        let got = detect(&format!("{{ {more}below = 0.5, alpha = 0.2 }}"), &Y);
        assert_near(&got.score, wealth(window), 1e-13, more);
        let shifted = detect(
            &format!("{{ {more}below = 1.5, alpha = 0.2, low = 1.0, high = 2.0 }}"),
            &Y.map(|y| y + 1.0),
        );
        assert_near(&shifted.score, wealth(window), 1e-13, more);
        // ln 5 = 1.609...
        assert_eq!(got.alarm, wealth(window).map(|x| x >= 1.61), "{more}");
    }
    let restart = detect("{ below = 0.5, alpha = 0.4, after = \"restart\" }", &Y);
    // ln 2.5 = 0.916...: frame 6 ends the first test.
    let whole = wealth(12);
    assert_near(&restart.score[7..], whole[7..].iter().map(|x| x - whole[6]), 1e-13, "restart");
    assert_eq!(restart.alarm, std::array::from_fn::<bool, 12, _>(|t| t == 6));
}

/// Draws the next value, in [0, 1], of a process whose mean given the past is at least `eps`.
type Null = fn(&mut rand_chacha::ChaCha8Rng, f64, f64) -> f64;

fn share(rng: &mut impl Rng) -> f64 {
    rng.random_range(0.0..1.0)
}

/// Processes. The last argument of each is the previous value.
const NULLS: [(&str, Null); 6] = [
    ("bernoulli", |rng, eps, _| f64::from(u8::from(share(rng) < eps))),
    ("uniform of the same mean", |rng, eps, _| {
        let reach = eps.min(1.0 - eps);
        eps + reach * (2.0 * share(rng) - 1.0)
    }),
    ("power of a uniform", |rng, eps, _| share(rng).powf(1.0 / eps - 1.0)),
    ("seldom very low", |rng, eps, _| if share(rng) < 0.02 { 0.0 } else { eps / 0.98 }),
    ("seldom high", |rng, eps, _| if share(rng) < 0.05 { 1.0 } else { (eps - 0.05) / 0.95 }),
    // Not independent: a low value is followed by a bold draw, a high one by a constant.
    (
        "after the last value",
        |rng, eps, last| {
            if last < eps { f64::from(u8::from(share(rng) < eps)) } else { eps }
        },
    ),
];

// Ville: the share of tracks with an alarm has an expectation of at most alpha; three standard deviations of a
// binomial share are allowed. The tracks are of 400 frames, 2000 for each process.
#[test]
fn a_good_track_seldom_has_any_alarm() {
    let mut most = 0.0_f64;
    for (name, null) in NULLS {
        for (eps, more) in
            [(0.5, ""), (0.2, ""), (0.5, ", largest_bet = 0.99, window = 10"), (0.9, ", window = 50")]
        {
            let detector = ENTRY.build_from_text(&format!("{{ below = {eps}, alpha = 0.1{more} }}")).unwrap();
            let mut rng = seed::rng(seed::seed(2602, &[name, more]));
            let runs = 2000;
            let alarmed = (0..runs).filter(|_| {
                let mut last = 0.0;
                let track = |_| {
                    last = null(&mut rng, eps, last);
                    last
                };
                let signal: Vec<f64> = (0..400).map(track).collect();
                detector.detect(&testing::alone(&signal)).alarm.contains(&true)
            });
            let found = alarmed.count() as f64 / f64::from(runs);
            assert!(found <= 0.1 + 3.0 * (0.1 * 0.9 / f64::from(runs)).sqrt(), "{name} {eps}{more}: {found}");
            most = most.max(found);
        }
    }
    // The bound is not met by never alarming.
    assert!(most > 0.03, "{most}");
}

proptest! {
    // Parts of powers of two, so that nothing is rounded.
    #[test]
    fn the_mirrored_signal_has_the_same_wealth_on_the_other_side(
        signal in prop::collection::vec(0..=64_u8, 0..80),
        eps in 1..64_u8,
    ) {
        let mirrored: Vec<f64> = signal.iter().map(|y| f64::from(64 - y) / 8.0).collect();
        let signal: Vec<f64> = signal.iter().map(|y| f64::from(*y) / 64.0).collect();
        let low = detect(&format!("{{ below = {:?} }}", f64::from(eps) / 64.0), &signal);
        let high = detect(&format!("{{ above = {:?}, high = 8.0 }}", f64::from(64 - eps) / 8.0), &mirrored);
        prop_assert_eq!(low, high);
    }

    // Each factor is at least 1 - largest_bet, and betting only wins where the quality is below eps.
    #[test]
    fn the_wealth_moves_within_what_is_bet(
        signal in prop::collection::vec(-1.0_f64..2.0, 1..80),
        eps in 0.05_f64..0.95,
        largest in 0.01_f64..0.99,
    ) {
        let output = detect(&format!("{{ below = {eps:?}, largest_bet = {largest:?} }}"), &signal);
        for (wealth, y) in output.score.windows(2).zip(&signal[1..]) {
            let step = wealth[1] - wealth[0];
            prop_assert!(step >= (1.0 - largest).ln() - 1e-12);
            prop_assert!(step == 0.0 || (*y < eps) == (step > 0.0));
        }
    }
}
