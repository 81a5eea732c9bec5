//! Columns of a file of boxes, the words for them in a header or an option, and the numbers in them.

use super::BoxFormat;
use super::rows::{self, Line, cells};
use std::path::Path;
use trackfail_core::plugin;
use trackfail_dataset::{DatasetError, text};

/// Meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Number of the frame.
    Frame,
    /// Number of the target.
    Target,
    /// Left edge.
    Left,
    /// Top edge.
    Top,
    /// Width.
    Width,
    /// Height.
    Height,
    /// Right edge.
    Right,
    /// Bottom edge.
    Bottom,
    /// Horizontal coordinate of the center.
    CenterX,
    /// Vertical coordinate of the center.
    CenterY,
    /// Confidence; it is not read.
    Confidence,
    /// Class of the target; it is not read.
    Class,
    /// Anything else; it is not read.
    Other,
}

use Role::{
    Bottom, CenterX, CenterY, Class, Confidence, Frame, Height, Left, Other, Right, Target, Top, Width,
};

/// Words for each role, first the word that we write; see [`plain`].
const WORDS: [(Role, &[&str]); 13] = [
    (Frame, &["frame", "frameid", "frameindex", "frameidx", "framenumber", "frameno", "imageid", "t"]),
    (Target, &["id", "trackid", "targetid", "trackerid", "objectid"]),
    (Left, &["x", "x1", "left", "xmin", "minx", "xleft", "topleftx", "tlx"]),
    (Top, &["y", "y1", "top", "ymin", "miny", "ytop", "toplefty", "tly"]),
    (Width, &["w", "width"]),
    (Height, &["h", "height"]),
    (Right, &["x2", "right", "xmax", "maxx", "xright", "bottomrightx", "brx"]),
    (Bottom, &["y2", "bottom", "ymax", "maxy", "ybottom", "bottomrighty", "bry"]),
    (CenterX, &["cx", "xcenter", "centerx", "xcentre", "centrex", "xc"]),
    (CenterY, &["cy", "ycenter", "centery", "ycentre", "centrey", "yc"]),
    (Confidence, &["confidence", "conf", "score", "probability", "prob"]),
    (Class, &["class", "cls", "classid", "label", "category", "categoryid"]),
    (Other, &["other"]),
];

/// Columns that include all parts of a box.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    roles: Vec<Role>,
    /// Number of further columns that a row may have.
    spare: usize,
    /// True if the box is in fractions of the frame, false if it is in pixels; `None`: its numbers tell.
    pub(super) shares: Option<bool>,
}

impl Columns {
    /// Columns of a box with the given unit, see [`Columns::shares`], and up to `spare` further columns, which are not
    /// read.
    pub(super) fn new(roles: Vec<Role>, spare: usize, shares: Option<bool>) -> Self {
        Self { roles, spare, shares }
    }

    /// The columns that the words name; unknown words are columns that are not read. `text` is the whole
    /// text, for messages. `None` for the corners of a polygon.
    ///
    /// # Errors
    /// Columns that do not make a box, two columns of one role, and corners of a polygon beside other columns.
    fn of_words(words: &[&str], text: &str) -> Result<Option<Self>, String> {
        let words: Vec<String> = words.iter().map(|word| plain(word)).collect();
        let corner = |k: usize| format!("{}{}", if k.is_multiple_of(2) { 'x' } else { 'y' }, k / 2 + 1);
        let is_polygon = words.len() >= 6 && words.len().is_multiple_of(2);
        if is_polygon && words.iter().enumerate().all(|(k, word)| *word == corner(k)) {
            return Ok(None);
        }
        let refused = |why: &str| Err(format!("`{}` {why}", text::shorten(text)));
        if words.iter().any(|word| is_third_corner(word)) {
            return refused(
                "has more than two corners; a polygon is x1,y1,x2,y2,x3,y3,... with no column beside it",
            );
        }
        let roles: Vec<Role> = words.iter().map(|word| role(word).unwrap_or(Other)).collect();
        let has_two = |role: &Role| roles.iter().filter(|other| *other == role).count() > 1;
        if roles.iter().any(|role| is_read(*role) && has_two(role)) {
            return refused("names two columns for one thing; call the one that does not count `other`");
        }
        let columns = Self::new(roles, 0, None);
        let is_whole = columns.side(Left, Right, CenterX, Width).is_some()
            && columns.side(Top, Bottom, CenterY, Height).is_some();
        if is_whole {
            return Ok(Some(columns));
        }
        refused(
            "names no whole box, which is x,y,w,h or x1,y1,x2,y2 or cx,cy,w,h in any order; the columns beside it may be \
             frame, id, confidence, class and other",
        )
    }

    /// Index of the column of a role.
    pub(super) fn position(&self, role: Role) -> Option<usize> {
        self.roles.iter().position(|other| *other == role)
    }

    /// The two columns that define the box in one direction: two of start, end, center and size.
    fn side(&self, start: Role, end: Role, center: Role, size: Role) -> Option<[(usize, Role); 2]> {
        let pair = |a: Role, b: Role| Some([(self.position(a)?, a), (self.position(b)?, b)]);
        // Beside both edges, a size may be that of the image.
        pair(start, end).or_else(|| pair(start, size)).or_else(|| pair(center, size))
    }

    /// Left, top, width and height of the box in a row; NaN if the row has none.
    pub(super) fn rect(&self, row: &[f64]) -> [f64; 4] {
        let of = |k: usize| row.get(k).copied().unwrap_or(f64::NAN);
        let along = |side: Option<[(usize, Role); 2]>| match side {
            Some([(a, CenterX | CenterY), (b, _)]) => (of(a) - of(b) / 2.0, of(b)),
            Some([(a, _), (b, Right | Bottom)]) => (of(a), of(b) - of(a)),
            Some([(a, _), (b, _)]) => (of(a), of(b)),
            None => (f64::NAN, f64::NAN),
        };
        let (left, width) = along(self.side(Left, Right, CenterX, Width));
        let (top, height) = along(self.side(Top, Bottom, CenterY, Height));
        [left, top, width, height]
    }

    /// The numbers of the box in a row, unchanged; none where -1 in all of them marks an absent target.
    pub(super) fn of_box(&self, row: &[f64]) -> Vec<f64> {
        let sides = [self.side(Left, Right, CenterX, Width), self.side(Top, Bottom, CenterY, Height)];
        let columns = sides.into_iter().flatten().flatten();
        let numbers: Vec<f64> = columns.filter_map(|(k, _)| row.get(k).copied()).collect();
        if numbers.iter().all(|number| *number == -1.0) { Vec::new() } else { numbers }
    }

    /// True if a row may have this number of columns.
    pub(super) fn fits(&self, count: usize) -> bool {
        (self.roles.len()..=self.roles.len() + self.spare).contains(&count)
    }

    /// True if this column is read.
    pub(super) fn reads(&self, column: usize) -> bool {
        self.roles.get(column).is_some_and(|role| is_read(*role))
    }

    /// The same columns with the center in place of the top left corner.
    pub(super) fn centered(&self) -> Self {
        let centered = |role: &Role| match role {
            Left => CenterX,
            Top => CenterY,
            other => *other,
        };
        Self { roles: self.roles.iter().map(centered).collect(), ..self.clone() }
    }

    /// Words for the columns, between commas.
    pub(super) fn words(&self) -> String {
        let words: Vec<&str> = self.roles.iter().map(|role| self.word(*role)).collect();
        words.join(",")
    }

    /// The words for the columns that are not read.
    pub(super) fn unread(&self) -> Vec<&'static str> {
        self.roles.iter().filter(|role| !is_read(**role)).map(|role| self.word(*role)).collect()
    }

    fn word(&self, role: Role) -> &'static str {
        match role {
            Left if self.position(Width).is_none() => "x1",
            Top if self.position(Height).is_none() => "y1",
            role => WORDS.iter().find(|(other, _)| *other == role).map_or("other", |(_, words)| words[0]),
        }
    }
}

fn is_read(role: Role) -> bool {
    !matches!(role, Confidence | Class | Other)
}

/// A word reduced to lower case letters and digits, without a leading `bbox`, `box`, `bb` or `rect`.
fn plain(word: &str) -> String {
    let word: String =
        word.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect();
    let short = ["bbox", "box", "bb", "rect"].iter().find_map(|start| word.strip_prefix(start));
    short.filter(|short| !short.is_empty()).map(str::to_string).unwrap_or(word)
}

/// The role of a [`plain`] word.
fn role(word: &str) -> Option<Role> {
    WORDS.iter().find(|(_, words)| words.contains(&word)).map(|(role, _)| *role)
}

/// True if a header has bare words `x` and `y`, which may mean a corner or the center.
fn is_bare(words: &[&str]) -> bool {
    ["x", "y"].iter().all(|bare| words.iter().any(|word| plain(word) == *bare))
}

/// True for a coordinate of a third corner, which only polygons have.
fn is_third_corner(word: &str) -> bool {
    word == "x3" || word == "y3"
}

/// The columns that a user's words name; see [`Columns::of_words`].
///
/// # Errors
/// The same, and when a word is not a column.
pub(super) fn of_user(text: &str) -> Result<Option<Columns>, String> {
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let is_unknown = |word: &&&str| role(&plain(word)).is_none();
    // Corners are no columns, and have their own errors.
    let has_corners = words.iter().any(|word| is_third_corner(&plain(word)));
    match words.iter().find(is_unknown).filter(|_| !has_corners) {
        Some(word) => {
            let formats = super::NAMED.into_iter().filter(|_| words.len() == 1);
            let known = formats.chain(WORDS.iter().map(|(_, words)| words[0]));
            Err(plugin::unknown("format or column", &text::shorten(word), known))
        }
        None => Columns::of_words(&words, text),
    }
}

/// A header line after reading.
pub(super) struct Header {
    /// Format that the header names.
    pub format: BoxFormat,
    /// True if the header calls the place of the box `x` and `y`.
    pub is_bare: bool,
}

impl Header {
    /// Reads a line as a header.
    pub fn read(path: &Path, (number, line): Line<'_>) -> Result<Self, DatasetError> {
        let words = cells(rows::without_sign(line));
        let columns = Columns::of_words(&words, line);
        let columns = columns.map_err(|e| DatasetError::line(path, number, e))?;
        let format = columns.map_or(BoxFormat::Vot, BoxFormat::Columns);
        Ok(Self { format, is_bare: is_bare(&words) })
    }
}

/// The numbers of a line. If the columns are known, columns that are not read may hold words, and those of
/// the box may all be empty.
pub(super) fn values(line: &str, columns: Option<&Columns>) -> Result<Vec<f64>, String> {
    let (fault, columns) = match (text::numbers(line), columns) {
        (Err(fault), Some(columns)) if columns.fits(cells(line).len()) => (fault, columns),
        (found, _) => return found,
    };
    let value = |(k, cell): (usize, &str)| match text::number(cell) {
        Err(_) if cell.is_empty() || !columns.reads(k) => Ok(f64::NAN),
        value => value,
    };
    let values: Vec<f64> = cells(line).into_iter().enumerate().map(value).collect::<Result<_, _>>()?;
    let of_box = columns.of_box(&values);
    let empty = of_box.iter().filter(|v| v.is_nan()).count();
    if empty > 0 && empty < of_box.len() { Err(fault) } else { Ok(values) }
}

/// A table with names of columns between tabs, with commas in their place: two tabs have an empty column between
/// them, as two commas have. `None` for another text.
pub(super) fn with_commas(bytes: &[u8]) -> Option<Vec<u8>> {
    let text = std::str::from_utf8(bytes).ok()?;
    let header = text.trim_start_matches('\u{feff}').lines().next()?.trim_end();
    let is_name = |word: &str| word.is_empty() || word.parse::<f64>().is_err();
    let tabs = header.matches('\t').count();
    let has_names = header.contains(char::is_alphabetic) && header.split('\t').map(str::trim).all(is_name);
    if tabs == 0 || !has_names || text.contains([',', ';']) {
        return None;
    }
    let line = |line: &str| {
        // More tabs than the header has are no columns.
        let line = line.trim_end_matches([' ', '\r']);
        let more = line.matches('\t').count().saturating_sub(tabs);
        let at_end = line.len() - line.trim_end_matches('\t').len();
        line[..line.len() - more.min(at_end)].replace('\t', ",")
    };
    Some(text.lines().map(line).collect::<Vec<_>>().join("\n").into_bytes())
}
