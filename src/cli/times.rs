//! Times and rates for people: as exact as they are sure.

/// A length of time in one or two units: `12 s`, `3 min`, `1 h 20 min`, `2 d 4 h`.
pub fn span(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return "an unknown time".to_string();
    }
    let two = |large: u64, unit: &str, small: u64, part: &str| match small {
        0 => format!("{large} {unit}"),
        _ => format!("{large} {unit} {small} {part}"),
    };
    let whole = seconds.round() as u64;
    match whole {
        0 => "less than 1 s".to_string(),
        1..90 => format!("{whole} s"),
        90..5400 => format!("{} min", (seconds / 60.0).round() as u64),
        5400..129_600 => {
            let minutes = (seconds / 600.0).round() as u64 * 10;
            two(minutes / 60, "h", minutes % 60, "min")
        }
        _ => {
            let hours = (seconds / 3600.0).round() as u64;
            two(hours / 24, "d", hours % 24, "h")
        }
    }
}

/// A rate with at most two digits that matter: `0.4/s`, `12/s`, `1200/s`; empty where there is none yet.
pub fn rate(per_second: f64) -> String {
    if !per_second.is_finite() || per_second <= 0.0 {
        return String::new();
    }
    if per_second < 0.095 {
        return format!("{}/min", span_digits(per_second * 60.0));
    }
    format!("{}/s", span_digits(per_second))
}

/// A positive number with two digits that matter.
fn span_digits(number: f64) -> String {
    match number {
        n if n < 0.095 => "less than 0.1".to_string(),
        n if n < 9.5 => {
            let text = format!("{n:.1}");
            text.strip_suffix(".0").map_or(text.clone(), str::to_string)
        }
        n => {
            let step = 10_f64.powf(n.log10().floor() - 1.0).max(1.0);
            format!("{}", ((n / step).round() * step) as u64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_one_or_two_units() {
        let rows = [
            (0.2, "less than 1 s"),
            (12.4, "12 s"),
            (89.0, "89 s"),
            (179.0, "3 min"),
            (5300.0, "88 min"),
            (5400.0, "1 h 30 min"),
            (7200.0, "2 h"),
            (200_000.0, "2 d 8 h"),
            (f64::NAN, "an unknown time"),
        ];
        rows.iter().for_each(|(seconds, text)| assert_eq!(span(*seconds), *text));
    }

    #[test]
    fn rates_have_two_digits() {
        let rows = [
            (0.0, ""),
            (f64::INFINITY, ""),
            (0.001, "less than 0.1/min"),
            (0.05, "3/min"),
            (0.42, "0.4/s"),
            (3.0, "3/s"),
            (12.345_678, "12/s"),
            (1234.5, "1200/s"),
            (98_765.0, "99000/s"),
        ];
        rows.iter().for_each(|(per_second, text)| assert_eq!(rate(*per_second), *text));
    }
}
