use super::*;
use crate::testing::{cases, count, number, numbers};
use proptest::prelude::*;
use trackfail_testing::assert_near;

const STARTS: [Presample; 2] = [Presample::Backcast, Presample::DropFirst];

/// Model with given parameters, and the innovations that it infers from a window.
fn given(y: &[f64], constant: f64, ar: &[f64], ma: &[f64], start: Presample) -> Fit {
    let innovations = recursion::innovations(y, constant, ar, ma, start);
    let (sse, recent) = (innovations.iter().map(|e| e * e).sum(), newest(y, ar.len()));
    Fit { constant, ar: ar.to_vec(), ma: ma.to_vec(), sse, innovations, recent }
}

fn spread(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    (y.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / y.len() as f64).sqrt()
}

// scipy.optimize.differential_evolution over (c, phi, theta), polished; see `global_fit` in arma.py.
#[test]
fn finds_the_global_minimum_of_scipy() {
    for case in cases("arma", "fits") {
        let y = numbers(&case["y"]);
        let order = [0, 1].map(|k| count(&case["order"][k]));
        let start: Presample = serde_json::from_value(case["start"].clone()).unwrap();
        let got = fit(&y, order, start).unwrap();
        let label = format!("{} {order:?} {start:?}", case["name"]);
        let sse = number(&case["sse"]);
        assert!(got.sse <= sse * (1.0 + 1e-6), "{label}: {} above {sse}", got.sse);
        // Above first order the search may do better than the oracle; it only must not do worse.
        if order.iter().all(|&k| k <= 1) {
            assert_near([got.sse], [sse], 1e-6 * sse, &label);
            assert_near(got.forecast(5), numbers(&case["forecast"]), 2e-4 * spread(&y), &label);
        }
    }
}

// Section 13 of the method notes, worked with an independent implementation, six digits printed.
#[test]
fn agrees_with_the_method_notes() {
    let y = [
        0.52, 0.47, 0.55, 0.61, 0.58, 0.66, 0.60, 0.49, 0.44, 0.40, 0.43, 0.38, 0.45, 0.51, 0.47, 0.54, 0.57,
        0.50, 0.46, 0.49,
    ];
    let back = fit(&y, [1, 1], Presample::Backcast).unwrap();
    assert_near([back.constant, back.ar[0], back.ma[0]], [0.403618, 0.228428, 0.942768], 2e-5, "");
    assert_near([back.sse], [0.0457849], 1e-7, "");
    assert_near(back.forecast(5), [0.512378, 0.520660, 0.522551, 0.522983, 0.523082], 2e-6, "");
    let dropped = fit(&y, [1, 1], Presample::DropFirst).unwrap();
    assert!(dropped.ma[0] > 0.99999);
    assert_near([dropped.sse], [0.0420339], 1e-7, "");
    assert_near(dropped.forecast(5), [0.497237, 0.491613, 0.490836, 0.490728, 0.490713], 2e-6, "");
}

// statsmodels.tsa.ar_model.AutoReg(y, lags=p, trend="c").fit(): conditional least squares.
#[test]
fn a_pure_autoregression_is_least_squares() {
    for case in cases("arma", "autoreg") {
        let (y, ar, sse) = (numbers(&case["y"]), numbers(&case["ar"]), number(&case["sse"]));
        let got = fit(&y, [ar.len(), 0], Presample::DropFirst).unwrap();
        assert_near([got.sse], [sse], 1e-9 * sse, "");
        assert_near(&got.ar, &ar, 1e-5, "");
        assert_near(got.forecast(5), numbers(&case["forecast"]), 1e-5 * spread(&y), "");
    }
}

// statsmodels.tsa.arima.model.ARIMA(y, order=(p, 0, q), trend="c").filter(parameters).forecast(6).
#[test]
fn forecasts_are_those_of_the_kalman_filter() {
    for case in cases("arma", "predictions") {
        let [y, ar, ma] = ["y", "ar", "ma"].map(|key| numbers(&case[key]));
        for start in STARTS {
            let model = given(&y, number(&case["constant"]), &ar, &ma, start);
            assert_near(model.forecast(6), numbers(&case["forecast"]), 1e-9, "");
        }
    }
}

// scipy.signal.lfilter([1, -phi], [1, theta], y - c / (1 - sum(phi)), zi=lfiltic(...)).
#[test]
fn innovations_are_those_of_a_linear_filter() {
    for case in cases("arma", "filters") {
        let [y, ar, ma] = ["y", "ar", "ma"].map(|key| numbers(&case[key]));
        let model = given(&y, number(&case["constant"]), &ar, &ma, Presample::DropFirst);
        assert_near(&model.innovations, numbers(&case["innovations"]), 1e-14, "");
    }
}

// By hand, y = 1 2 4 with c = 1, phi = 0.5, theta = 0.5 (zeros pad the window to its least length).
// Reversed: a[n] = 0; the back-forecast and the first innovation follow the doc's formulas term by term.
#[test]
fn backcast_by_hand() {
    let y = [1.0, 2.0, 4.0, 0.0, 0.0, 0.0];
    // a5 = 0 - 1 - 0 - 0 = -1; a4 = 0 - 1 - 0 + 0.5 = -0.5; a3 = 4 - 1 - 0 + 0.25 = 3.25;
    // a2 = 2 - 1 - 2 - 1.625 = -2.625; a1 = 1 - 1 - 1 + 1.3125 = 0.3125;
    // y0 = 1 + 0.5 + 0.15625 = 1.65625; e1 = 1 - 1 - 0.828125 = -0.828125;
    // e2 = 2 - 1 - 0.5 + 0.4140625 = 0.9140625.
    let model = given(&y, 1.0, &[0.5], &[0.5], Presample::Backcast);
    assert_eq!(model.innovations[..2], [-0.828125, 0.9140625]);
}

// The mean is the best constant; its residuals are deviations.
#[test]
fn order_zero_is_the_mean() {
    let model = fit(&[1.0, 2.0, 3.0, 6.0], [0, 0], Presample::Backcast).unwrap();
    assert_near([model.constant], [3.0], 1e-15, "");
    assert_near([model.sse], [14.0], 1e-13, "");
    assert_eq!(model.forecast(2), [model.constant; 2]);
}

#[test]
fn a_constant_window_repeats_its_value() {
    for start in STARTS {
        for value in [0.0, 0.1, -3e300, 1e-310] {
            let model = fit(&[value; 20], [1, 1], start).unwrap();
            assert_eq!(model.forecast(5), [value; 5]);
            assert_eq!((model.sse, model.ar[0], model.ma[0]), (0.0, 0.0, 0.0));
        }
    }
}

#[test]
fn wrong_input_is_refused() {
    assert_eq!(fit(&[0.0; 20], [6, 0], Presample::Backcast), None);
    assert_eq!(fit(&[0.0; 5], [1, 1], Presample::Backcast), None);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut y = [0.5; 20];
        y[7] = bad;
        assert_eq!(fit(&y, [1, 1], Presample::Backcast), None);
    }
    let huge: Vec<f64> = (0..20).map(|t| if t % 3 == 0 { 1.7e308 } else { -1.7e308 }).collect();
    assert_eq!(fit(&huge, [1, 1], Presample::Backcast), None);
}

#[test]
fn high_orders_are_no_worse_than_low_ones() {
    let y: Vec<f64> = (0..24).map(|t| f64::from((t * t * 7 + 3 * t) % 11) + 0.2 * f64::from(t)).collect();
    for start in STARTS {
        let low = fit(&y, [0, 1], start).unwrap().sse;
        let high = fit(&y, [0, 5], start).unwrap().sse;
        assert!(high <= low * (1.0 + 1e-9), "{high} above {low}");
    }
    let model = fit(&y, [5, 5], Presample::Backcast).unwrap();
    assert!(model.sse.is_finite() && model.forecast(50).iter().all(|v| v.is_finite()));
}

/// Windows of 16 multiples of 1/1024, whose mean and deviations are exact.
fn window() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-1024_i32..1024).prop_map(|v| f64::from(v) / 1024.0), 16)
}

fn start() -> impl Strategy<Value = Presample> {
    prop::sample::select(STARTS.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn shifting_shifts(y in window(), by in -64_i32..64, start in start()) {
        let moved: Vec<f64> = y.iter().map(|v| v + f64::from(by)).collect();
        let (a, b) = (fit(&y, [1, 1], start).unwrap(), fit(&moved, [1, 1], start).unwrap());
        prop_assert_eq!(a.sse.to_bits(), b.sse.to_bits());
        assert_near(a.forecast(5).iter().map(|v| v + f64::from(by)), b.forecast(5), 1e-11, "");
    }

    #[test]
    fn scaling_and_negating_scale_and_negate(y in window(), power in -30_i32..30, negative: bool, start in start()) {
        let by = 2.0_f64.powi(power) * if negative { -1.0 } else { 1.0 };
        let scaled: Vec<f64> = y.iter().map(|v| v * by).collect();
        let (a, b) = (fit(&y, [1, 1], start).unwrap(), fit(&scaled, [1, 1], start).unwrap());
        prop_assert_eq!(a.forecast(5).iter().map(|v| v * by).collect::<Vec<_>>(), b.forecast(5));
    }

    // The fit is a minimum: no model near it has a smaller sum of squares.
    #[test]
    fn no_neighbor_is_better(y in window(), d in prop::array::uniform3(-1e-3_f64..1e-3), start in start()) {
        let model = fit(&y, [1, 1], start).unwrap();
        let ar = (model.ar[0] + d[0]).clamp(-LIMIT, LIMIT);
        let ma = (model.ma[0] + d[1]).clamp(-LIMIT, LIMIT);
        let other = given(&y, model.constant + d[2], &[ar], &[ma], start);
        prop_assert!(model.sse <= other.sse * (1.0 + 1e-8) + 1e-14, "{} above {}", model.sse, other.sse);
    }
}
