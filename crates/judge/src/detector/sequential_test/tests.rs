use super::*;
use crate::num::seed;
use proptest::prelude::*;
use rand::{Rng, RngExt};

fn detect(text: &str, signal: &[f64]) -> DetectorOutput {
    let detector = ENTRY.build_from_text(text).unwrap();
    detector.detect(&Input { signal, error: &[], seed: 0, reverse: None, more: &[] })
}

// By hand: no bet on the first frame, as mu = eps. Then mu = 1/4, g = 1/4, v = 5/32 and l = 8/7, cut to 1: X is 1.5.
// Then mu = 1/6 and l is cut to 1 again: X is 0.75 after a good frame.
#[test]
fn bets_by_hand() {
    let output = detect("{ below = 0.5, alpha = 0.5 }", &[0.0, 0.0, 1.0]);
    let want = [1.0_f64, 1.5, 0.75].map(f64::ln);
    assert!(
        output.score.iter().zip(want).all(|(got, want)| (got - want).abs() < 1e-15),
        "{:?}",
        output.score
    );
    assert_eq!(output.alarm, [false; 3]);
}

// By hand: X is 1.2, 1.2 * 4/3 and that times 10/7, which is an alarm and ends the test; then mu = 1/2, g = 1/4, v = 1/16,
// l = 2, and X is 1 + 2 (3/4 - 1/4) = 1 / alpha.
#[test]
fn a_wealth_at_the_limit_is_an_alarm() {
    let output = detect("{ below = 0.75, alpha = 0.5, after = \"restart\" }", &[0.5, 0.5, 0.5, 0.25]);
    assert_eq!((output.score[3], output.alarm), (2.0_f64.ln(), vec![false, false, true, true]));
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

// python3, with eps = c = .5 and w = 0 (all frames) or 3; a and b are the last w of the lists m and d, or all:
// for q in y: mu = (.5 + sum(a)) / (len(a) + 1); v = (.25 + sum(b)) / (len(b) + 1)
//     l = min(max((eps - mu) / (v + (eps - mu) ** 2), 0), c / (1 - eps)); x += math.log1p(l * (eps - q))
//     m.append(q); d.append((q - (.5 + sum(a)) / (len(a) + 1)) ** 2)    # a with the new q
const Y: [f64; 12] = [0.125, 0.25, 0.0, 0.75, 0.5, 0.0, 0.0, 1.0, 0.125, 0.0625, 0.0, 0.0];
const ALL: [f64; 12] = [
    0.0,
    0.22314355131420976,
    0.6286086594223741,
    0.3409265869705932,
    0.3409265869705932,
    0.7463916950787576,
    1.1518568031869219,
    0.45870962262697657,
    0.7771633537455112,
    1.1400688474348797,
    1.545533955543044,
    1.9509990636512085,
];
const LAST_THREE: [f64; 12] = [
    0.0,
    0.22314355131420976,
    0.6286086594223741,
    0.3409265869705932,
    0.3409265869705932,
    0.582240931916916,
    0.7710350032164881,
    0.07788782265654282,
    0.2568022211288832,
    0.439720971132584,
    0.6043204856201261,
    1.0097855937282905,
];

#[test]
fn the_wealth_is_that_of_a_direct_computation() {
    for (more, want) in [("", ALL), ("window = 3, ", LAST_THREE)] {
        let got = detect(&format!("{{ {more}below = 0.5, alpha = 0.2 }}"), &Y);
        assert!(got.score.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-13), "{more}: {:?}", got.score);
        // ln 5 = 1.609...
        assert_eq!(got.alarm, want.map(|x| x >= 1.61), "{more}");
    }
    let restart = detect("{ below = 0.5, alpha = 0.4, after = \"restart\" }", &Y);
    // ln 2.5 = 0.916...: frame 6 ends the first test.
    let after: Vec<f64> = ALL[7..].iter().map(|x| x - ALL[6]).collect();
    assert!(restart.score[7..].iter().zip(after).all(|(a, b)| (a - b).abs() < 1e-13));
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
                let input = Input { signal: &signal, error: &[], seed: 0, reverse: None, more: &[] };
                detector.detect(&input).alarm.contains(&true)
            });
            let found = alarmed.count() as f64 / f64::from(runs);
            assert!(found <= 0.1 + 3.0 * (0.1 * 0.9 / f64::from(runs)).sqrt(), "{name} {eps}{more}: {found}");
            most = most.max(found);
        }
    }
    // The bound is not met by never alarming.
    assert!(most > 0.03, "{most}");
}

#[test]
fn a_bad_track_has_an_alarm_soon() {
    let mut rng = seed::rng(13);
    for _ in 0..500 {
        let signal: Vec<f64> = (0..150).map(|_| 0.6 * share(&mut rng)).collect();
        assert!(detect("{ below = 0.5 }", &signal).alarm[149]);
        let distance: Vec<f64> = signal.iter().map(|y| 10.0 - 10.0 * y).collect();
        assert!(detect("{ above = 5.0, high = 10.0 }", &distance).alarm[149]);
    }
}

// By hand: the mean of 1000 frames of 3/4 falls below 1/2 after 500 frames of 0, that of the last 20 after 7;
// from there on bets grow from 0.
#[test]
fn a_window_finds_a_late_loss_sooner() {
    let signal: Vec<f64> = (0..2500).map(|t| if t < 1000 { 0.75 } else { 0.0 }).collect();
    let first = |more: &str| {
        let text = format!("{{ below = 0.5{more} }}");
        detect(&text, &signal).alarm.iter().position(|a| *a).unwrap()
    };
    assert!((1500..1600).contains(&first("")), "{}", first(""));
    assert!((1006..1025).contains(&first(", window = 20")), "{}", first(", window = 20"));
}

#[test]
fn parameters_out_of_range_are_refused() {
    let key = |text: &str| ENTRY.build_from_text(text).err().map(|e| e.key);
    for (text, want) in [
        ("{}", None),
        ("{ below = 0.5, above = 0.5 }", None),
        ("{ above = 7.0, high = 5.0 }", Some("above")),
        ("{ below = 0.5, low = 1.0 }", Some("high")),
    ] {
        assert_eq!(key(text), Some(want), "{text}");
    }
}

proptest! {
    // Sixty-fourths, so that 1 - y is exact.
    #[test]
    fn the_mirrored_signal_has_the_same_wealth_on_the_other_side(
        signal in prop::collection::vec(0..=64_u8, 0..80),
        eps in 1..64_u8,
    ) {
        let [signal, mirrored] = [0.0, 64.0].map(|from: f64| -> Vec<f64> {
            signal.iter().map(|y| (from - f64::from(*y)).abs() / 64.0).collect()
        });
        let eps = f64::from(eps) / 64.0;
        let low = detect(&format!("{{ below = {eps:?} }}"), &signal);
        prop_assert_eq!(low, detect(&format!("{{ above = {:?} }}", 1.0 - eps), &mirrored));
    }

    #[test]
    fn a_smaller_alpha_alarms_in_fewer_frames(
        signal in prop::collection::vec(0.0_f64..1.0, 0..80),
        one in 0.001_f64..0.5,
        two in 0.001_f64..0.5,
    ) {
        let [few, many] = [one.min(two), one.max(two)]
            .map(|alpha| detect(&format!("{{ below = 0.7, alpha = {alpha:?} }}"), &signal));
        prop_assert_eq!(&few.score, &many.score);
        prop_assert!(few.alarm.iter().zip(&many.alarm).all(|(few, many)| *many || !*few));
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
