//! Helpers of these tests.

#[cfg(unix)]
#[path = "../tools/page.rs"]
pub mod page;
#[path = "../tools/program.rs"]
mod program;

#[cfg(target_os = "linux")]
pub use program::memory;
#[cfg(unix)]
pub use program::trackfail;
pub use program::{Place, Ran, Row, experiment, number, words};
pub use trackfail_testing::{assert_same_files, assert_says, files, needs, rows};

/// A file that describes a suite of the user's own, by the names and folders of its sequences.
pub fn suite(name: &str, format: &str, sequences: &[(&str, &str)]) -> String {
    let row = |(name, folder): &(&str, &str)| format!("{{ name = \"{name}\", folder = \"{folder}\" }},\n");
    let sequences: String = sequences.iter().map(row).collect();
    format!(
        "schema = 2\n\n[[suite]]\nname = \"{name}\"\ntitle = \"Mine\"\nformat = \"{format}\"\nsource = \"mine\"\n\
         licence = \"mine\"\nhow_to_get = \"ask me\"\nsequence = [\n{sequences}]\n"
    )
}

/// Renders the first frames of a sequence into the folder [`IMAGES`], and gives the lines of its ground truth.
pub fn clip(place: &Place, frames: usize) -> Vec<String> {
    let mut truth = place.render("synthetic-otb", "Girl");
    place.list(IMAGES)[frames..].iter().for_each(|file| std::fs::remove_file(file).unwrap());
    truth.truncate(frames);
    truth
}

pub const IMAGES: &str = "suite/Girl/img";

/// The left top corner of the target of [`sequence`] in a frame; both count from 0.
pub fn corner(t: u32) -> (u32, u32) {
    (8 + t / 5, 10 + t % 7)
}

/// Writes a sequence in the layout of OTB into the data root `data`: a textured target of 16 x 12 pixels that moves.
pub fn sequence(place: &Place, name: &str, frames: u32) {
    place.frames(&format!("data/otb/{name}/img/0000.png"), frames as usize, (64, 48), |t, column, row| {
        let (x, y) = corner(t);
        if (x..x + 16).contains(&column) && (y..y + 12).contains(&row) {
            [200, 3 * (((column - x) * 31 + (row - y) * 17) % 64) as u8, 60]
        } else {
            [((column * 13 + row * 7) % 64) as u8, 90, 120]
        }
    });
    let line = |(x, y): (u32, u32)| format!("{},{},16,12\n", x + 1, y + 1);
    let truth: String = (0..frames).map(corner).map(line).collect();
    place.write(&format!("data/otb/{name}/groundtruth_rect.txt"), truth);
}
