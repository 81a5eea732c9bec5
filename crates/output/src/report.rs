//! Reports: everything an experiment has to say, as one offline HTML page and as Markdown.
//!
//! A [`Page`] is plain data; [`render`] makes `index.html` of it, a single file that loads nothing from the network,
//! and [`markdown`] makes `report.md`. All texts may come from outside (names of sequences, messages of errors): both
//! outputs show them as text.
//!
//! A report is made from [results](crate::results) alone. The modules:
//!
//! | module | does |
//! |---|---|
//! | [`finished`] | finds the experiments that have results |
//! | [`trace`] | follows a method frame by frame |
//! | [`stills`] | finds the video frames that figures show |
//! | `operating` | finds the published point of a method's grid |
//! | `colors` | gives each method a color |
//! | [`figures`] | draws the figures of an experiment, one file a kind |
//! | [`claims`] | tests its claims |
//! | [`pairs`] | measures sequence by sequence, for comparisons |
//! | `readings` | says which reading of a paper's text fits the published numbers best |
//! | `standings` | says which method or tracker is the best, and how sure that is |
//! | `sources` | says where the numbers come from |
//! | `sentences` | puts the results of all of these into sentences |
//! | [`sequences`] | collects the series and counts of each sequence, and packs them for the page |
//! | [`explain`](mod@explain) | traces numbers of tables to sequences |
//! | [`verdict`] | says in sentences when a user's tracker has lost its target |
//! | [`page`] | the data of the page, as HTML and as Markdown |
//! | `glance` | chooses the figure and the table at the head of the page |
//! | [`write`](mod@write) | fills the page and writes the report |
//! | [`paper`] | puts chosen tables and figures into one folder, for LaTeX |
//! | [`site`] | the page over all reports |
//! | [`user_track`] | shows a user's own track: page, figure, frames |

pub mod claims;
mod colors;
pub mod explain;
pub mod figures;
pub mod finished;
mod glance;
mod operating;
pub mod page;
pub mod pairs;
pub mod paper;
mod readings;
mod sentences;
pub mod sequences;
pub mod site;
mod sources;
mod standings;
pub mod stills;
pub mod trace;
pub mod user_track;
pub mod verdict;
pub mod write;

pub use claims::{ClaimOutcome, Finding};
pub use page::{FigureView, Page, ReportError, markdown, render};
pub use write::{INDEX, OWNED, StagedReport, WrittenReport, write};

#[cfg(test)]
mod tests;
