//! Excerpt of a file for an error: the wrong line with a mark below.

use std::ops::Range;

/// Most characters of a line that are shown.
const WIDTH: usize = 100;
/// Characters shown before the wrong place in a longer line.
const BEFORE: usize = 40;

/// A line of a text (`line` counts from 1), with `^^^` below the part of `span` that is on it:
///
/// ```text
/// 14 | detector = { kind = "level", bellow = 0.9 }
///    |                              ^^^^^^
/// ```
///
/// Empty for a line without text.
pub fn excerpt(text: &str, line: usize, span: &Range<usize>) -> String {
    let (Some(before), Some(after)) = (text.get(..span.start), text.get(span.start..)) else {
        return String::new();
    };
    // Of a very long line only what can be shown is looked at. A tab would take the mark to another column.
    let plain = |c: char| if c.is_whitespace() { ' ' } else { c };
    let mut left: Vec<char> =
        before.chars().rev().take_while(|c| *c != '\n').take(WIDTH + 1).map(plain).collect();
    let right: String = after.chars().take_while(|c| *c != '\n').take(WIDTH).map(plain).collect();
    if left.len() + right.chars().count() > WIDTH {
        left.truncate(BEFORE);
    }
    let part: String = left.iter().rev().copied().chain(right.chars().take(WIDTH - left.len())).collect();
    if part.trim().is_empty() {
        return String::new();
    }
    let marked =
        after.char_indices().take(WIDTH).take_while(|(k, c)| span.start + k < span.end && *c != '\n');
    let room = part.chars().count().saturating_sub(left.len());
    let marked = marked.count().min(room).max(1);
    let number = line.to_string();
    let gap = " ".repeat(number.len());
    let below = " ".repeat(left.len()) + &"^".repeat(marked);
    format!("{number} | {}\n{gap} | {below}", part.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, word: &str) -> String {
        let start = text.find(word).unwrap();
        let line = 1 + text[..start].matches('\n').count();
        excerpt(text, line, &(start..start + word.len()))
    }

    #[test]
    fn the_mark_is_below_the_word() {
        assert_eq!(of("a = 1\nb = \"é\", wrong\n", "wrong"), "2 | b = \"é\", wrong\n  |          ^^^^^");
        assert_eq!(of("a\t= [\n1,\n]", "[\n1,\n]"), "1 | a = [\n  |     ^");
        assert_eq!(excerpt("", 1, &(0..0)), "");
        assert_eq!(excerpt("a = ", 1, &(4..4)), "1 | a =\n  |     ^");
        assert_eq!(excerpt("a\n\n", 2, &(2..2)), "");
    }

    #[test]
    fn of_a_long_line_the_part_around_the_word_is_shown() {
        let text = format!("a = [{}wrong, {}]", "1, ".repeat(1000), "2, ".repeat(1000));
        let shown = of(&text, "wrong");
        let lines: Vec<&str> = shown.lines().collect();
        assert!(lines[0].len() < 120 && lines[1].len() < 120, "{shown}");
        let column = lines[1].find('^').unwrap();
        assert_eq!(&lines[0][column..column + 5], "wrong");
    }

    proptest::proptest! {
        #[test]
        fn any_place_of_any_text_is_shown(text in "[ab \n\té=]{0,40}", a in 0_usize..50, b in 0_usize..50) {
            let _ = excerpt(&text, 1, &(a.min(b)..a.max(b)));
        }
    }
}
