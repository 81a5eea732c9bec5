use super::*;
use crate::signal::testing;
use crate::tracker::nanotrack::look::Cell;
use crate::tracker::{self, TrackerState};

const OF_V3: &str = "v3 = [\"overlap\", \"score\"]";
const HERE: &str = "here = [\"score\", \"overlap\", \"disagreement\", \"apart\", \"distance\", \"middle\", \
                    \"inside\", \"outside\", \"elsewhere\"]";

/// All values beside a tracker that follows a face for ten frames and is then off by `shift` pixels.
fn beside(shift: f64) -> Vec<Vec<f64>> {
    let both = "[\"product\", \"least\", \"most\", \"overlap\", \"against\", \"apart\"]";
    beside_with(&format!("{{ v2 = [\"overlap\", \"score\"], {OF_V3}, both = {both}, {HERE} }}"), shift)
}

/// Values of a signal with these parameters beside the same tracker.
fn beside_with(params: &str, shift: f64) -> Vec<Vec<f64>> {
    let (_, start, frames) = tracker::testing::excerpt(20);
    let mut states = tracker::testing::run("nanotrack", "{}", 1, &start, &frames);
    for state in &mut states[10..] {
        state.region = Region::Rect(state.region.bounds().shifted(shift, 0.0));
    }
    testing::rows(&*testing::build("deep-verification", params), &frames, &states)
}

/// On target, the second look agrees with the watchdog, whose box is that of the tracker. Off target, it
/// finds a better place elsewhere if the target is in its search region; beyond the frame, in one color, all
/// places are equal.
#[test]
fn a_second_look_tells_the_target_from_its_surroundings() {
    let here = |values: &[f64]| <[f64; 9]>::try_from(&values[10..]).unwrap();
    for values in beside(0.0) {
        let [score, overlap, disagreement, apart, distance, middle, inside, outside, elsewhere] =
            here(&values);
        assert!(score > 0.9 && overlap > 0.7 && apart == 0.0 && distance < 0.2 && middle > 0.8, "{values:?}");
        assert!((disagreement - (1.0 - overlap) * score).abs() < 1e-15);
        assert!(inside > 2.0 && outside < 1.0 && elsewhere < -2.0, "{values:?}");
    }
    let (near, far) = (beside(60.0), beside(500.0));
    let [score, overlap, .., inside, outside, elsewhere] = here(&near[15]);
    assert!(score < 0.5 && overlap < 0.6 && inside < 0.0 && outside > 1.0 && elsewhere > 1.0, "{near:?}");
    let [.., inside, _, elsewhere] = here(&far[15]);
    assert!(inside < 2.0 && elsewhere.abs() < 0.5, "{far:?}");
}

// By a signal of v3 alone: its watchdog's values are those beside v2, and its second look is another network's.
#[test]
fn a_second_look_of_v3_needs_no_v2() {
    let of_v3 = beside_with(&format!("{{ {OF_V3}, {HERE}, look = \"v3\" }}"), 60.0);
    let of_both = beside(60.0);
    assert!(of_v3.iter().zip(&of_both).all(|(mine, all)| mine[..2] == all[2..4] && mine.len() == 11));
    let [score, .., elsewhere] = of_v3[15][2..] else { panic!() };
    assert!(score < 0.7 && elsewhere > 0.0 && of_v3[15][2..] != of_both[15][10..], "{of_v3:?}");
    assert!(of_v3[5][2] > 0.9 && of_v3[5][10] < -2.0, "{of_v3:?}");
    let of_v2 = beside_with("{ v2 = [\"overlap\", \"score\"], here = [] }", 60.0);
    let product = beside_with("{ both = [\"product\"], here = [] }", 60.0);
    for (all, (v2, product)) in of_both.iter().zip(of_v2.iter().zip(product)) {
        assert!(all[..2] == *v2 && all[4..5] == product);
    }
}

#[test]
fn a_box_without_numbers_has_no_cells_and_is_apart_from_the_watchdogs() {
    let (_, start, frames) = tracker::testing::excerpt(2);
    let states = [start, Region::nowhere()].map(TrackerState::tracked);
    let signal =
        testing::build("deep-verification", "{ v2 = [\"overlap\"], here = [\"score\", \"inside\"] }");
    assert_eq!(testing::rows(&*signal, &frames, &states)[1], [0.0, 0.0, -6.0]);
}

// By hand: 5 x 5 cells of 20 x 20 pixels, 16 apart around (50, 50), with scores .01 to .25; the tracker's box is centered on
// (67, 20), one column right of the middle and two rows up. The cells near are those of columns 2 to 4 in rows 0 and 1; of
// these, only 3, 4 and 8 overlap the box by more than .1: by 342/458, 90/710 and 114/686.
#[test]
fn cells_near_inside_and_outside_of_the_box() {
    let cell = |k: u32| Cell {
        score: f64::from(k + 1) / 100.0,
        shift: [16.0 * (f64::from(k % 5) - 2.0), 16.0 * (f64::from(k / 5) - 2.0)],
        sides: [20.0; 2],
        penalty: 1.0,
        rank: 0.0,
    };
    let place = Place { center: [50.0; 2], sides: [20.0; 2] };
    let look = Look { place, cells: (0..25).map(cell).collect(), side: 5, best: 4, cell: 16.0, rate: 0.0 };
    let second = Second::of(&look, &Rect::new(57.5, 10.5, 20.0, 20.0));
    assert_eq!([second.middle, second.inside, second.outside], [0.10, 0.09, 0.25]);
    assert_eq!(second.chosen.score, 0.05);
    assert!((second.chosen.overlap - 90.0 / 710.0).abs() < 1e-12);
}

// By hand, with watchdogs at overlaps .25 and 0 of the tracker, and .5 of each other.
#[test]
fn every_value_has_its_own_number_direction_and_bounds() {
    use Direction::{HigherIsBetter as High, LowerIsBetter as Low};
    let seen =
        |score, overlap, distance, x| Seen { score, overlap, distance, rect: Rect::new(x, 0.0, 10.0, 10.0) };
    let (v2, v3) = (seen(0.5, 0.25, 2.0, 0.0), seen(0.75, 0.0, 3.0, 10.0 / 3.0));
    let (unit, log, far) = ((0.0, 1.0), log_odds(1.0), (0.0, 3.0));
    let of_watchdog = [
        (WatchdogValue::Overlap, [0.25, 0.0], High, unit),
        (WatchdogValue::Score, [0.5, 0.75], High, unit),
        (WatchdogValue::Disagreement, [0.375, 0.75], Low, unit),
        (WatchdogValue::Apart, [0.0, 0.75], Low, unit),
        (WatchdogValue::Distance, [2.0, 3.0], Low, far),
    ];
    let of_both = [
        (Both::Product, 0.28125, Low),
        (Both::Least, 0.375, Low),
        (Both::Most, 0.75, Low),
        (Both::Overlap, 0.5, High),
        (Both::Against, 0.1875, Low),
        (Both::Apart, 0.25, Low),
    ];
    let second = Second { chosen: seen(0.5, 0.25, 2.0, 0.0), middle: 0.625, inside: 0.8, outside: 0.6 };
    let (inside, outside) = (4.0_f64.ln(), 1.5_f64.ln());
    let of_here = [
        (Here::Score, 0.5, High, unit),
        (Here::Overlap, 0.25, High, unit),
        (Here::Disagreement, 0.375, Low, unit),
        (Here::Apart, 0.0, Low, unit),
        (Here::Distance, 2.0, Low, far),
        (Here::Middle, 0.625, High, unit),
        (Here::Inside, inside, High, (-6.0, log)),
        (Here::Outside, outside, Low, (-6.0, log)),
        (Here::Elsewhere, outside - inside, Low, (-8.0, 8.0)),
    ];
    assert!((log - 999_999.0_f64.ln()).abs() < 1e-9);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    for (value, [of_v2, of_v3], direction, bounds) in of_watchdog {
        assert!(near(v2.value(value), of_v2) && near(v3.value(value), of_v3), "{value:?}");
        assert_eq!((value.direction(), value.bounds()), (direction, bounds), "{value:?}");
    }
    let kinds = |both: &[Both], here: &[Here]| {
        let (v2, v3, look) = (Vec::new(), Vec::new(), Version::default());
        Params { v2, v3, both: both.to_vec(), here: here.to_vec(), look }.kinds()
    };
    for (value, number, direction) in of_both {
        assert!(near(both(&v2, &v3, value), number), "{value:?}");
        assert_eq!(kinds(&[value], &[]), [(direction, unit)], "{value:?}");
    }
    for (value, number, direction, bounds) in of_here {
        assert!(near(second.value(value), number), "{value:?}");
        assert_eq!(kinds(&[], &[value]), [(direction, bounds)], "{value:?}");
    }
}
