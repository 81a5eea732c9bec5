use super::*;

#[test]
fn best_and_second_by_hand() {
    let marks = |values: &[f64], goodness| {
        let mut cells: Vec<Cell> =
            values.iter().map(|v| Cell { value: Some(*v), ..Cell::default() }).collect();
        // The last one is an anchor.
        mark_best(&mut cells, goodness, |k| k + 1 == values.len());
        let mark = |c: &Cell| {
            if c.best {
                'b'
            } else if c.second {
                's'
            } else {
                '.'
            }
        };
        cells.iter().map(mark).collect::<String>()
    };
    assert_eq!(marks(&[0.1, 0.3, 0.2, 1.0], Goodness::Up), ".bs.");
    assert_eq!(marks(&[0.1, 0.3, 0.2, 0.0], Goodness::Down), "b.s.");
    assert_eq!(marks(&[0.3, 0.3, 0.2, 1.0], Goodness::Up), "bb..");
    assert_eq!(marks(&[0.3, 0.2, 0.2, 1.0], Goodness::Up), "bss.");
    assert_eq!(marks(&[0.3, 1.0], Goodness::Up), "..");
    assert_eq!(marks(&[0.3, 0.2, 1.0], Goodness::Neither), "...");
}
