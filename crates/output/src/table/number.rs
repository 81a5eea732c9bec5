//! Numbers as a paper prints them: same decimals, with or without the leading zero.

use trackfail_methods::score::Metric;

/// Print style of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Digits after the point.
    pub decimals: usize,
    /// True if `0.5` is printed as `.5`.
    pub bare: bool,
}

impl Style {
    /// Three decimals, as in most tables.
    pub const DEFAULT: Self = Self { decimals: 3, bare: false };
    /// Whole numbers.
    pub const COUNT: Self = Self { decimals: 0, bare: false };

    /// Style of a metric without published numbers.
    pub fn of_metric(metric: Metric) -> Self {
        if metric.is_count() { Self::COUNT } else { Self::DEFAULT }
    }

    /// Style of a printed number such as `.110`, `0.40` or `.17±.18`.
    pub fn of(printed: &str) -> Self {
        let first = printed.split('±').next().unwrap_or_default().trim();
        let digits = first.trim_start_matches(['-', '+']);
        let decimals = digits.split_once('.').map_or(0, |(_, d)| d.len());
        Self { decimals, bare: digits.starts_with('.') }
    }

    /// Prints `v` in this style. A value that rounds to zero has no sign.
    pub fn format(self, v: f64) -> String {
        let text = format!("{v:.*}", self.decimals);
        let text = if is_zero(&text) { text.trim_start_matches('-') } else { &text };
        if self.bare { bare(text) } else { text.to_string() }
    }

    /// Prints `v` with its sign, for differences.
    pub fn format_signed(self, v: f64) -> String {
        let text = self.format(v);
        if text.starts_with('-') || is_zero(&text) { text } else { format!("+{text}") }
    }

    /// Rounds `v` to the digits that this style shows.
    pub fn round(self, v: f64) -> f64 {
        format!("{v:.*}", self.decimals).parse().unwrap_or(v)
    }
}

/// True if a printed number is zero.
fn is_zero(text: &str) -> bool {
    text.trim_start_matches('-').bytes().all(|b| b == b'0' || b == b'.')
}

/// Removes a zero before the point of a printed number.
pub fn bare(text: &str) -> String {
    let is_small = text.trim_start_matches('-').starts_with("0.");
    text.replacen("0.", ".", usize::from(is_small))
}

/// First number of a printed cell: 0.17 of `.17±.18`; `None` if there is none.
pub fn printed_value(printed: &str) -> Option<f64> {
    printed.split('±').next()?.trim().parse().ok()
}

/// Prints the p-value of a test, which is never 0.
pub fn p_value(p: f64) -> String {
    if p < 0.0001 { "<0.0001".to_string() } else { format!("{p:.4}") }
}

/// Style for all numbers of a column, with three or four digits of the largest. `None` if the column is
/// empty, or its numbers are of too different sizes.
pub fn style_of_column(values: impl Iterator<Item = f64> + Clone) -> Option<Style> {
    let sizes = values.clone().map(f64::abs).filter(|v| *v > 0.0 && v.is_finite());
    let most = sizes.clone().fold(0.0, f64::max);
    if values.clone().all(|v| v == v.trunc() && v.abs() < 1e6) {
        return values.clone().next().map(|_| Style::COUNT);
    }
    if !(1e-4..1e6).contains(&most) || sizes.fold(f64::INFINITY, f64::min) < 1e-4 * most {
        return None;
    }
    let size = most.log10().floor() as i32;
    let decimals = if size < 0 { 2 - size } else { 3 - size };
    Some(Style { decimals: usize::try_from(decimals).unwrap_or(0), bare: false })
}

/// Prints a number with four significant digits, or an integer below a million in full.
pub fn four_digits(v: f64) -> String {
    if v == v.trunc() && v.abs() < 1e6 {
        return format!("{v}");
    }
    let rounded: f64 = format!("{v:.3e}").parse().unwrap_or(v);
    if (1e-4..1e6).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{v:.3e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_one_rounding() {
        let shown = |values: &[f64]| {
            let style = style_of_column(values.iter().copied())?;
            Some(values.iter().map(|v| style.format(*v)).collect::<Vec<_>>().join(" "))
        };
        assert_eq!(shown(&[0.5, 0.1234, 0.0]).as_deref(), Some("0.500 0.123 0.000"));
        assert_eq!(shown(&[1.0, 0.97654]).as_deref(), Some("1.000 0.977"));
        assert_eq!(shown(&[123.456, 7.0]).as_deref(), Some("123.5 7.0"));
        assert_eq!(shown(&[3.0, -12.0]).as_deref(), Some("3 -12"));
        assert_eq!(shown(&[3000.5, 2.0]).as_deref(), Some("3000 2"));
        assert_eq!(shown(&[0.001, 900.5]), None);
        assert_eq!(shown(&[]), None);
    }

    #[test]
    fn follows_the_papers_style() {
        assert_eq!(Style::of(".110").format(0.1103), ".110");
        assert_eq!(Style::of(".110").format(1.0), "1.000");
        assert_eq!(Style::of(".110").format(0.9996), "1.000");
        assert_eq!(Style::of("0.40").format(10.0), "10.00");
        assert_eq!(Style::of(".17±.18").decimals, 2);
        assert_eq!(Style::of("43").format(42.0), "42");
        assert_eq!(Style::of(".110").format_signed(-0.02), "-.020");
        assert_eq!(Style::of(".110").format_signed(0.02), "+.020");
        assert_eq!(Style::of(".110").format_signed(-0.0001), ".000");
        assert_eq!(printed_value(".17±.18"), Some(0.17));
        assert_eq!(["0.5", "-0.5", "10.5", "0"].map(bare), [".5", "-.5", "10.5", "0"]);
    }
}
