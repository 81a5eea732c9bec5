use super::*;

#[test]
fn best_and_second_by_hand() {
    let marks = |values: &[f64], direction| {
        let mut cells: Vec<Cell> =
            values.iter().map(|v| Cell { value: Some(*v), ..Cell::default() }).collect();
        // The last one is an anchor.
        mark_best(&mut cells, direction, Style { decimals: 1, bare: false }, |k| k + 1 == values.len());
        let mark = |c: &Cell| {
            if c.tied {
                't'
            } else if c.best {
                'b'
            } else if c.second {
                's'
            } else {
                '.'
            }
        };
        cells.iter().map(mark).collect::<String>()
    };
    assert_eq!(marks(&[0.1, 0.3, 0.2, 1.0], Direction::HigherIsBetter), ".bs.");
    assert_eq!(marks(&[0.1, 0.3, 0.2, 0.0], Direction::LowerIsBetter), "b.s.");
    assert_eq!(marks(&[0.3, 0.3, 0.2, 1.0], Direction::HigherIsBetter), "tt..");
    // They are printed alike.
    assert_eq!(marks(&[0.301, 0.299, 0.2, 1.0], Direction::HigherIsBetter), "tt..");
    assert_eq!(marks(&[0.3, 0.2, 0.2, 1.0], Direction::HigherIsBetter), "bss.");
    assert_eq!(marks(&[0.3, 1.0], Direction::HigherIsBetter), "..");
    assert_eq!(marks(&[0.3, 0.2, 1.0], Direction::Neither), "...");
}
