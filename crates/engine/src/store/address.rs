//! Content addresses: the store keeps a result under the digest of everything it was made from.
//!
//! A [`Recipe`] lists the ingredients of one stage's result by name, in data-flow order; its [`Address`] is the SHA-256
//! of stage, names and values, each preceded by its length as a 64-bit little-endian integer. Addresses link the
//! stages: the recipe of a signal holds the address of its track.
//!
//! | stage | ingredients |
//! |---|---|
//! | track | sequence, digest of frames and truth, version of the frame decoder, digest of what a video was decoded into; tracker, its version and parameters; the seed, for trackers that draw random numbers; run and digests, for trackers that read files |
//! | signal | address of the track; signal, its version and parameters |
//! | model | a chosen parameter: version of training, protocol, the parameter and the measure to maximize, the candidates; a learned model: detector, its version and what of its parameters the model depends on; an analysis: its kind, version and parameters; addresses of all signals that it is learned from |
//! | labels | address of the signal (of the track, for methods without one); version of the form in which labels are stored; detector, its version and parameters, or the address of the chosen parameter, or both for a learned model; the version of reverse runs, for detectors that use them; the seed, for detectors that draw random numbers |
//!
//! Clock, host, thread count, order and file times are not part of any recipe. A change of a stage's output
//! must change an ingredient: plugins have a version, and tests with golden digests of their outputs fail
//! until it is raised; [`DECODER`](trackfail_core::image::DECODER) and
//! [`OVERLAP`](trackfail_methods::score::overlap::OVERLAP) are the versions of the shared parts.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt;
use trackfail_core::num::hexadecimal;

/// SHA-256 of a recipe.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Address(pub [u8; 32]);

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&hexadecimal(&self.0))
    }
}

impl fmt::Debug for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Stage of the computation to which a result belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Stage {
    /// A tracker's states on a sequence.
    Track,
    /// A signal on a track.
    Signal,
    /// A trained parameter, a learned model, or an analysis.
    Model,
    /// A detector's output on a signal.
    Labels,
}

impl Stage {
    /// Name of the stage in addresses and messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Track => "track",
            Self::Signal => "signal",
            Self::Model => "model",
            Self::Labels => "labels",
        }
    }
}

/// All ingredients of a result, by name and in order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recipe {
    /// Stage of the result.
    pub stage: Stage,
    /// Names and values of the ingredients.
    pub ingredients: Vec<(String, String)>,
}

impl Recipe {
    /// Recipe without ingredients.
    pub fn new(stage: Stage) -> Self {
        Self { stage, ingredients: Vec::new() }
    }

    /// The recipe with one more ingredient.
    pub fn with(mut self, name: impl Into<String>, value: impl fmt::Display) -> Self {
        self.ingredients.push((name.into(), value.to_string()));
        self
    }

    /// The recipe with a plugin: its kind, version and checked parameters. Equal parameters give equal text,
    /// because the keys of objects are sorted.
    pub fn with_plugin(self, what: &str, kind: &str, version: u32, params: &serde_json::Value) -> Self {
        self.with(what, kind).with("version", version).with("parameters", params)
    }

    /// Value of an ingredient; `None` if the recipe lacks it.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.ingredients.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// Address of the result: the digest of stage and ingredients.
    pub fn address(&self) -> Address {
        self.address_with(None)
    }

    /// Address of the recipe with the ingredients `more` appended, without building that recipe.
    pub fn address_with<'i>(&'i self, more: impl IntoIterator<Item = &'i (String, String)>) -> Address {
        let mut digest = Sha256::new();
        let mut add = |text: &str| {
            digest.update((text.len() as u64).to_le_bytes());
            digest.update(text.as_bytes());
        };
        add(self.stage.word());
        for (name, value) in self.ingredients.iter().chain(more) {
            add(name);
            add(value);
        }
        Address(digest.finalize().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};
    use trackfail_core::plugin::Entry;

    // python3: import hashlib,struct; h=hashlib.sha256()
    // for s in ['labels','detector','level','version','1']: b=s.encode(); h.update(struct.pack('<Q',len(b))+b)
    // h.hexdigest()
    #[test]
    fn an_address_is_the_documented_digest() {
        let recipe = Recipe::new(Stage::Labels).with("detector", "level").with("version", 1);
        assert_eq!(recipe.address().to_string(), ADDRESS);
        assert_eq!(recipe.value("version"), Some("1"));
    }
    const ADDRESS: &str = "e20eca670e3f3bc802cb9824b9772079606b5b6f42d6934e21322d664531b69e";

    #[test]
    fn different_ingredients_are_different_addresses() {
        let with = |params: &Value| Recipe::new(Stage::Signal).with_plugin("signal", "s", 1, params);
        let params = json!([
            {"a": 1}, {"a": -1}, {"a": 0.1}, {"a": "0.1"}, {"a": ["a,b"]}, {"a": ["a", "b"]},
            {"a": "\u{e9}"}, {"a": "e\u{301}"}, {"A": 1}
        ]);
        let mut all: Vec<Recipe> = params.as_array().unwrap().iter().map(with).collect();
        all.extend([
            with(&params[0]).with("seed", 1),
            Recipe::new(Stage::Track).with_plugin("signal", "s", 1, &params[0]),
            Recipe::new(Stage::Signal).with("ab", "c"),
            Recipe::new(Stage::Signal).with("a", "bc"),
        ]);
        let distinct: std::collections::BTreeSet<_> = all.iter().map(Recipe::address).collect();
        assert_eq!(distinct.len(), all.len());
        assert_eq!(with(&json!({"a": 1, "b": 2})).address(), with(&json!({"b": 2, "a": 1})).address());
    }

    /// Kind of each plugin and the first 16 digits of its address, with the parameters of its example.
    fn keys<T: ?Sized>(what: &str, list: &[Entry<T>]) -> Vec<String> {
        let key = |e: &Entry<T>| {
            let built = e.build_from_text(e.example).unwrap();
            let recipe = Recipe::new(Stage::Track).with_plugin(what, e.kind, e.version, &built.params());
            format!("{what} {} {}", e.kind, &recipe.address().to_string()[..16])
        };
        list.iter().map(key).collect()
    }

    // A name, version, parameter or default that changes, changes every address.
    #[test]
    fn plugins_have_their_pinned_addresses() {
        let mut all = keys("tracker", trackfail_methods::tracker::TRACKERS);
        all.extend(keys("signal", trackfail_methods::signal::SIGNALS));
        all.extend(keys("detector", trackfail_methods::detector::DETECTORS));
        all.extend(keys("analysis", trackfail_methods::analysis::ANALYSES));
        trackfail_testing::check_pins("address", all);
    }
}
