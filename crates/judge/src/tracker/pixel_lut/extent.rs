//! Extent of the target, from the classifier's weights projected back to the pixels.

use super::codes::Codes;
use super::model::Model;

/// Standard deviations in x and y, in cells, of the pixels that the classifier takes for the target.
///
/// On a lattice of the cells' pitch that goes a quarter of the box beyond it, a pixel's evidence is the
/// mean share it has in the windows that are shifted by whole cells, up to a quarter of the box; evidence
/// above Otsu's threshold is the target. `columns` and `rows` are the lattice's pixels in the block of
/// codes, `(columns, rows)` of `cells` in the middle being the box's own. `None` without contrast.
pub fn extent(
    model: &Model,
    codes: &Codes,
    (columns, rows): (&[usize], &[usize]),
    cells: (usize, usize),
) -> Option<(f64, f64)> {
    let margin = ((columns.len() - cells.0) / 2, (rows.len() - cells.1) / 2);
    let mut evidence = Vec::with_capacity(columns.len() * rows.len());
    for (j, &y) in rows.iter().enumerate() {
        for (i, &x) in columns.iter().enumerate() {
            let at = y * codes.width + x;
            let (color, tone) = (codes.colors[at], codes.tones[at]);
            // Cells that come to lie on this pixel in one of the windows.
            let reach = |k: usize, m: usize, n: usize| k.saturating_sub(2 * m)..(k + 1).min(n);
            let (mut sum, mut count) = (0.0, 0);
            for v in reach(j, margin.1, cells.1) {
                for u in reach(i, margin.0, cells.0) {
                    sum += model.share(v * cells.0 + u, color, tone);
                    count += 1;
                }
            }
            evidence.push(if count > 0 { f64::from(sum) / f64::from(count) } else { 0.0 });
        }
    }
    let threshold = otsu(&evidence)?;
    let mut sums = [0.0; 5];
    for (k, _) in evidence.iter().enumerate().filter(|(_, e)| **e > threshold) {
        let (i, j) = ((k % columns.len()) as f64, (k / columns.len()) as f64);
        for (sum, v) in sums.iter_mut().zip([1.0, i, j, i * i, j * j]) {
            *sum += v;
        }
    }
    let [n, x, y, xx, yy] = sums;
    let deviation = |one: f64, two: f64| (two / n - (one / n).powi(2)).max(0.0).sqrt();
    Some((deviation(x, xx), deviation(y, yy))).filter(|(x, y)| *x > 0.0 && *y > 0.0)
}

/// The threshold that splits values into two classes with the largest variance between them (Otsu 1979, eq.
/// 18); the upper class is above it. `None` when all values are equal.
pub fn otsu(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let all: f64 = sorted.iter().sum();
    let (n, mut below, mut best) = (sorted.len() as f64, 0.0, None);
    for (k, pair) in (1..).zip(sorted.windows(2)) {
        below += pair[0];
        if pair[1] > pair[0] {
            let k = f64::from(k);
            let between = (all * k / n - below).powi(2) / (k * (n - k));
            if best.is_none_or(|(b, _)| between > b) {
                best = Some((between, pair[0]));
            }
        }
    }
    best.map(|(_, threshold)| threshold)
}
