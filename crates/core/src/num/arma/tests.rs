use super::*;
use proptest::prelude::*;
use serde_json::Value;

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// `tests/oracles/arma.json`, written by `python3 tests/oracles/arma.py`.
fn oracle(part: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../../../../../tests/oracles/arma.json")).unwrap();
    all[part].as_array().unwrap().clone()
}

/// The model with given parameters, and the innovations it infers from a window.
fn given(y: &[f64], constant: f64, ar: &[f64], ma: &[f64], start: Presample) -> Result<Fit, ArmaError> {
    check(y, [ar.len(), ma.len()])?;
    let innovations = recursion::innovations(y, constant, ar, ma, start);
    Ok(Fit {
        constant,
        ar: ar.to_vec(),
        ma: ma.to_vec(),
        sse: innovations.iter().map(|e| e * e).sum(),
        innovations,
        recent: newest(y, ar.len()),
    })
}

fn close(got: f64, want: f64, within: f64) -> bool {
    (got - want).abs() <= within
}

fn spread(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    (y.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / y.len() as f64).sqrt()
}

// scipy.optimize.differential_evolution over (c, phi, theta), polished; see `global_fit` in arma.py.
#[test]
fn finds_the_global_minimum_of_scipy() {
    for case in oracle("fits") {
        let y = numbers(&case["y"]);
        let order =
            [case["order"][0].as_u64().unwrap() as usize, case["order"][1].as_u64().unwrap() as usize];
        let start: Presample = serde_json::from_value(case["start"].clone()).unwrap();
        let got = fit(&y, order, start).unwrap();
        let label = format!("{} {order:?} {start:?}", case["name"]);
        let sse = case["sse"].as_f64().unwrap();
        let s = spread(&y);
        assert!(got.sse <= sse * (1.0 + 1e-6), "{label}: {} above {sse}", got.sse);
        // Above first order the search may do better than the oracle; it only must not do worse.
        if order.iter().all(|&k| k <= 1) {
            assert!(close(got.sse, sse, 1e-6 * sse), "{label}: {} is not {sse}", got.sse);
            for (got, want) in got.forecast(5).iter().zip(numbers(&case["forecast"])) {
                assert!(close(*got, want, 2e-4 * s), "{label}: {got} is not {want}");
            }
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
    assert!(close(back.constant, 0.403618, 2e-5), "{}", back.constant);
    assert!(close(back.ar[0], 0.228428, 2e-5), "{}", back.ar[0]);
    assert!(close(back.ma[0], 0.942768, 2e-5), "{}", back.ma[0]);
    assert!(close(back.sse, 0.0457849, 1e-7), "{}", back.sse);
    for (got, want) in back.forecast(5).iter().zip([0.512378, 0.520660, 0.522551, 0.522983, 0.523082]) {
        assert!(close(*got, want, 2e-6), "{got} is not {want}");
    }
    let dropped = fit(&y, [1, 1], Presample::DropFirst).unwrap();
    assert!(dropped.ma[0] > 0.99999);
    assert!(close(dropped.sse, 0.0420339, 1e-7), "{}", dropped.sse);
    for (got, want) in dropped.forecast(5).iter().zip([0.497237, 0.491613, 0.490836, 0.490728, 0.490713]) {
        assert!(close(*got, want, 2e-6), "{got} is not {want}");
    }
}

// statsmodels.tsa.ar_model.AutoReg(y, lags=p, trend="c").fit(): conditional least squares.
#[test]
fn a_pure_autoregression_is_least_squares() {
    for case in oracle("autoreg") {
        let y = numbers(&case["y"]);
        let ar = numbers(&case["ar"]);
        let got = fit(&y, [ar.len(), 0], Presample::DropFirst).unwrap();
        let sse = case["sse"].as_f64().unwrap();
        assert!(close(got.sse, sse, 1e-9 * sse), "{} is not {sse}", got.sse);
        for (got, want) in got.ar.iter().zip(&ar) {
            assert!(close(*got, *want, 1e-5), "{got} is not {want}");
        }
        for (got, want) in got.forecast(5).iter().zip(numbers(&case["forecast"])) {
            assert!(close(*got, want, 1e-5 * spread(&y)), "{got} is not {want}");
        }
    }
}

// statsmodels.tsa.arima.model.ARIMA(y, order=(p, 0, q), trend="c").filter(parameters).forecast(6).
#[test]
fn forecasts_are_those_of_the_kalman_filter() {
    for case in oracle("predictions") {
        let y = numbers(&case["y"]);
        let (ar, ma) = (numbers(&case["ar"]), numbers(&case["ma"]));
        for start in [Presample::Backcast, Presample::DropFirst] {
            let model = given(&y, case["constant"].as_f64().unwrap(), &ar, &ma, start).unwrap();
            for (got, want) in model.forecast(6).iter().zip(numbers(&case["forecast"])) {
                assert!(close(*got, want, 1e-9), "{got} is not {want}");
            }
        }
    }
}

// scipy.signal.lfilter([1, -phi], [1, theta], y - c / (1 - sum(phi)), zi=lfiltic(...)).
#[test]
fn innovations_are_those_of_a_linear_filter() {
    for case in oracle("filters") {
        let y = numbers(&case["y"]);
        let (ar, ma) = (numbers(&case["ar"]), numbers(&case["ma"]));
        let model = given(&y, case["constant"].as_f64().unwrap(), &ar, &ma, Presample::DropFirst).unwrap();
        let want = numbers(&case["innovations"]);
        assert_eq!(model.innovations.len(), want.len());
        for (got, want) in model.innovations.iter().zip(want) {
            assert!(close(*got, want, 1e-14), "{got} is not {want}");
        }
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
    let model = given(&y, 1.0, &[0.5], &[0.5], Presample::Backcast).unwrap();
    assert_eq!(model.innovations[..2], [-0.828125, 0.9140625]);
}

// The mean is the best constant; its residuals are deviations.
#[test]
fn order_zero_is_the_mean() {
    let model = fit(&[1.0, 2.0, 3.0, 6.0], [0, 0], Presample::Backcast).unwrap();
    assert!(close(model.constant, 3.0, 1e-15) && close(model.sse, 14.0, 1e-13));
    assert_eq!(model.forecast(2), [model.constant; 2]);
}

#[test]
fn a_constant_window_repeats_its_value() {
    for start in [Presample::Backcast, Presample::DropFirst] {
        for value in [0.0, 0.1, -3e300, 1e-310] {
            let model = fit(&[value; 20], [1, 1], start).unwrap();
            assert_eq!(model.forecast(5), [value; 5]);
            assert_eq!((model.sse, model.ar[0], model.ma[0]), (0.0, 0.0, 0.0));
        }
    }
}

#[test]
fn wrong_input_is_refused() {
    assert_eq!(fit(&[0.0; 20], [6, 0], Presample::Backcast), Err(ArmaError::Order { p: 6, q: 0 }));
    assert_eq!(fit(&[0.0; 5], [1, 1], Presample::Backcast), Err(ArmaError::TooShort { needed: 6, got: 5 }));
    for bad in [f64::NAN, f64::INFINITY] {
        let mut y = [0.5; 20];
        y[7] = bad;
        assert_eq!(fit(&y, [1, 1], Presample::Backcast), Err(ArmaError::NotFinite));
    }
    let huge: Vec<f64> = (0..20).map(|t| if t % 3 == 0 { 1.7e308 } else { -1.7e308 }).collect();
    assert_eq!(fit(&huge, [1, 1], Presample::Backcast), Err(ArmaError::NotFinite));
}

#[test]
fn high_orders_are_no_worse_than_low_ones() {
    let y: Vec<f64> = (0..24).map(|t| f64::from((t * t * 7 + 3 * t) % 11) + 0.2 * f64::from(t)).collect();
    for start in [Presample::Backcast, Presample::DropFirst] {
        let low = fit(&y, [0, 1], start).unwrap().sse;
        let high = fit(&y, [0, 5], start).unwrap().sse;
        assert!(high <= low * (1.0 + 1e-9), "{high} above {low}");
    }
    let model = fit(&y, [5, 5], Presample::Backcast).unwrap();
    assert!(model.sse.is_finite() && model.forecast(50).iter().all(|v| v.is_finite()));
}

/// Windows of 16 multiples of 1/1024: their mean and deviations are exact.
fn window() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-1024_i32..1024).prop_map(|v| f64::from(v) / 1024.0), 16)
}

fn start() -> impl Strategy<Value = Presample> {
    prop_oneof![Just(Presample::Backcast), Just(Presample::DropFirst)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn shifting_shifts(y in window(), by in -64_i32..64, start in start()) {
        let moved: Vec<f64> = y.iter().map(|v| v + f64::from(by)).collect();
        let (a, b) = (fit(&y, [1, 1], start).unwrap(), fit(&moved, [1, 1], start).unwrap());
        prop_assert_eq!(a.sse.to_bits(), b.sse.to_bits());
        for (a, b) in a.forecast(5).iter().zip(b.forecast(5)) {
            prop_assert!(close(a + f64::from(by), b, 1e-11), "{} and {}", a, b);
        }
    }

    #[test]
    fn scaling_scales(y in window(), power in -30_i32..30, start in start()) {
        let by = 2.0_f64.powi(power);
        let scaled: Vec<f64> = y.iter().map(|v| v * by).collect();
        let (a, b) = (fit(&y, [1, 1], start).unwrap(), fit(&scaled, [1, 1], start).unwrap());
        let want: Vec<f64> = a.forecast(5).iter().map(|v| v * by).collect();
        prop_assert_eq!(want, b.forecast(5));
    }

    #[test]
    fn negating_negates(y in window(), start in start()) {
        let negative: Vec<f64> = y.iter().map(|v| -v).collect();
        let (a, b) = (fit(&y, [1, 1], start).unwrap(), fit(&negative, [1, 1], start).unwrap());
        for (a, b) in a.forecast(5).iter().zip(b.forecast(5)) {
            prop_assert_eq!(*a, -b);
        }
    }

    // The fit is a minimum: no model near it has a smaller sum of squares.
    #[test]
    fn no_neighbor_is_better(y in window(), d in prop::array::uniform3(-1e-3_f64..1e-3), start in start()) {
        let model = fit(&y, [1, 1], start).unwrap();
        let ar = (model.ar[0] + d[0]).clamp(-LIMIT, LIMIT);
        let ma = (model.ma[0] + d[1]).clamp(-LIMIT, LIMIT);
        let other = given(&y, model.constant + d[2], &[ar], &[ma], start).unwrap();
        prop_assert!(model.sse <= other.sse * (1.0 + 1e-8) + 1e-14, "{} above {}", model.sse, other.sse);
    }

    // Forecasts of a first order model are a geometric approach to the mean after the first step.
    #[test]
    fn first_order_forecasts_are_geometric(y in window(), start in start()) {
        let model = fit(&y, [1, 1], start).unwrap();
        let path = model.forecast(8);
        for k in 1..8 {
            prop_assert!(close(path[k], model.constant + model.ar[0] * path[k - 1], 1e-12));
        }
    }
}
