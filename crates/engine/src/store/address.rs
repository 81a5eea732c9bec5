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
//! Clock, host, thread count, order and file times are in no recipe. Whatever changes a stage's output must change an
//! ingredient: plugins have a version, and tests with golden digests of their outputs fail until it is raised; [`DECODER`](crate::image::DECODER) and [`OVERLAP`](crate::score::overlap::OVERLAP) are the versions of the shared parts.

use crate::num::hexadecimal;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt;

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

/// Stage of the computation that a result belongs to.
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
    /// Its word in addresses and messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Track => "track",
            Self::Signal => "signal",
            Self::Model => "model",
            Self::Labels => "labels",
        }
    }
}

/// Everything that a result is made from, by name and in order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recipe {
    /// The stage.
    pub stage: Stage,
    /// Names and values of the ingredients.
    pub ingredients: Vec<(String, String)>,
}

impl Recipe {
    /// A recipe without ingredients.
    pub fn new(stage: Stage) -> Self {
        Self { stage, ingredients: Vec::new() }
    }

    /// The recipe with one more ingredient.
    pub fn with(mut self, name: impl Into<String>, value: impl fmt::Display) -> Self {
        self.ingredients.push((name.into(), value.to_string()));
        self
    }

    /// The recipe with a plugin: its kind, version and checked parameters.
    pub fn with_plugin(self, what: &str, kind: &str, version: u32, params: &serde_json::Value) -> Self {
        self.with(what, kind).with("version", version).with("parameters", canonical(params))
    }

    /// The value of an ingredient.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.ingredients.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// Address of the result.
    pub fn address(&self) -> Address {
        AddressDigest::of(self).finish()
    }
}

/// The address of a recipe that is not complete yet. Recipes that begin alike share the digest of their beginning.
#[derive(Clone)]
pub struct AddressDigest(Sha256);

impl AddressDigest {
    /// The digest of all there is of a recipe.
    pub fn of(begun: &Recipe) -> Self {
        let mut digest = Self(Sha256::new());
        digest.text(begun.stage.word());
        begun.ingredients.iter().for_each(|(name, value)| digest.add(name, value));
        digest
    }

    /// Adds an ingredient.
    pub fn add(&mut self, name: &str, value: &str) {
        self.text(name);
        self.text(value);
    }

    /// Address of the recipe that has been added up.
    pub fn finish(self) -> Address {
        Address(self.0.finalize().into())
    }

    fn text(&mut self, text: &str) {
        self.0.update((text.len() as u64).to_le_bytes());
        self.0.update(text.as_bytes());
    }
}

/// JSON with the keys of every object in order, so that equal parameters are equal text.
pub fn canonical(value: &serde_json::Value) -> String {
    use serde_json::Value;
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by_key(|(key, _)| *key);
            let entries =
                entries.iter().map(|(k, v)| format!("{}:{}", Value::from(k.as_str()), canonical(v)));
            format!("{{{}}}", entries.collect::<Vec<_>>().join(","))
        }
        Value::Array(items) => format!("[{}]", items.iter().map(canonical).collect::<Vec<_>>().join(",")),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plugin::Entry;
    use serde_json::json;

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
        let with =
            |params: serde_json::Value| Recipe::new(Stage::Signal).with_plugin("signal", "s", 1, &params);
        let all = [
            with(json!({"a": 1})),
            with(json!({"a": -1})),
            with(json!({"a": 0.1})),
            with(json!({"a": "0.1"})),
            with(json!({"a": ["a,b"]})),
            with(json!({"a": ["a", "b"]})),
            with(json!({"a": "\u{e9}"})),
            with(json!({"a": "e\u{301}"})),
            with(json!({"A": 1})),
            with(json!({"a": 1})).with("seed", 1),
            Recipe::new(Stage::Track).with_plugin("signal", "s", 1, &json!({"a": 1})),
            Recipe::new(Stage::Signal).with("ab", "c"),
            Recipe::new(Stage::Signal).with("a", "bc"),
        ];
        let distinct: std::collections::BTreeSet<_> = all.iter().map(Recipe::address).collect();
        assert_eq!(distinct.len(), all.len());
        assert_eq!(with(json!({"a": 1, "b": 2})).address(), with(json!({"b": 2, "a": 1})).address());
    }

    /// Kind and the first 16 digits of the address of the plugin alone, with its example's parameters.
    const GOLDEN: &[(&str, &str)] = &[
        ("tracker ncc", "95e1548bdb900e8d"),
        ("tracker still", "30ef6023d627be3e"),
        ("tracker scripted", "192871707a9006e2"),
        ("tracker color-particle-filter", "053206f1de91a1fd"),
        ("tracker fragments-particle-filter", "759380adf8427e48"),
        ("tracker pixel-lut", "5786871efedf68ff"),
        ("tracker kcf", "884bedba81e59c9b"),
        ("tracker dsst", "1c2a0408a62422de"),
        ("tracker samf", "30de1ec9c8896d95"),
        ("tracker sparse-prototypes", "7109bf1aff3b1560"),
        ("tracker ivt", "4b483e366b078a60"),
        ("tracker adaptive-local-sparse", "e9500dd5a32960fd"),
        ("tracker replay", "738b529fec975c8e"),
        ("tracker process", "057baa391b19be9a"),
        ("signal box-motion", "4d86d38076323bce"),
        ("signal companion-overlap", "c60301aa69ba7fdb"),
        ("signal confidence", "2a1c5d5462b9fe7e"),
        ("signal distribution-field", "2553ef39cf637fd4"),
        ("signal effective-particles", "fbab196c969edbd2"),
        ("signal forward-backward", "76dc8ed55e403ab1"),
        ("signal object-color", "18a75d39030288a1"),
        ("signal particle-entropy", "31702f807ef185ff"),
        ("signal region-covariance", "9c83c5e1667d5796"),
        ("signal response-apce", "0097f0505b8ae390"),
        ("signal response-peak", "a69f1c8c3c5540ae"),
        ("signal response-psr", "beca056b927cd99a"),
        ("signal rgb-histogram", "db78cb52538464f4"),
        ("signal rgb-lbp-histogram", "5fbe48a44a14219e"),
        ("signal template-correlation", "d00e22b5e8540318"),
        ("signal uncertainty", "4552a164cbb321cf"),
        ("signal uncertainty-change", "bec43e4b153d00b2"),
        ("signal process", "dfd9096d7243598d"),
        ("detector arma-forecast", "d6f6b61c0e578b7c"),
        ("detector naive-forecast", "2b4be781e0646eab"),
        ("detector level", "a763eef451a2b735"),
        ("detector standard-score", "558a76915b14783e"),
        ("detector hysteresis", "2086dbb08a9958ac"),
        ("detector relative-drop", "da8c18243b893cba"),
        ("detector joint-drop", "973e9455617f401d"),
        ("detector fused", "0a88757ef0f27bd3"),
        ("detector cusum", "c9a0cfbe477a4d9f"),
        ("detector page-hinkley", "1fe1b569841bd2f9"),
        ("detector sequential-test", "a7fdc1503f6d8e76"),
        ("detector conformal-forecast", "faca2c978762c0c7"),
        ("detector accumulated-validation", "3bda99986c490d2c"),
        ("detector two-model-chi-square", "b662c67db9e5a71f"),
        ("detector matched-kalman-bank", "82f63de4f6655a23"),
        ("detector arte", "4e1c481ff4983163"),
        ("detector arte-star", "39ae89b13692cd9d"),
        ("detector never", "62538cd3b24119c0"),
        ("detector always", "73845e90d884c60d"),
        ("detector periodic", "ac72459775f67436"),
        ("detector random", "bfdb4920211cd397"),
        ("detector oracle", "749c71303801df6e"),
        ("detector process", "53ede32164df4c6b"),
        ("analysis uncertainty-model", "934aff386c64f2e2"),
        ("analysis cut-values", "0c486de33a3f6668"),
        ("analysis window-lengths", "9befcd641164ca8d"),
        ("analysis success", "3bb083cb2d637d54"),
        ("analysis average-overlap", "a0d7d5316f2ec533"),
        ("analysis resets", "d1f1e9e19bba66cc"),
        ("analysis collapsed-boxes", "063ffcd07d0d4ed8"),
        ("analysis longterm", "91d43538fc1d1edf"),
        ("analysis oxuva", "e3ffe5373b029e3d"),
        ("analysis processing-time", "293d26ffa82b8225"),
    ];

    fn keys<T: ?Sized>(
        what: &str,
        list: &[Entry<T>],
        params: fn(&T) -> serde_json::Value,
    ) -> Vec<(String, String)> {
        let key = |e: &Entry<T>| {
            let built = e.build_from_text(e.example).unwrap();
            let recipe = Recipe::new(Stage::Track).with_plugin(what, e.kind, e.version, &params(&built));
            (format!("{what} {}", e.kind), recipe.address().to_string()[..16].to_string())
        };
        list.iter().map(key).collect()
    }

    #[test]
    fn plugins_have_their_golden_keys() {
        let mut all = keys("tracker", crate::tracker::TRACKERS, |t| t.params());
        all.extend(keys("signal", crate::signal::SIGNALS, |s| s.params()));
        all.extend(keys("detector", crate::detector::DETECTORS, |d| d.params()));
        all.extend(keys("analysis", crate::analysis::ANALYSES, |a| a.params()));
        let known: Vec<_> = GOLDEN.iter().map(|(kind, key)| (kind.to_string(), key.to_string())).collect();
        let lines: Vec<_> = all.iter().map(|(kind, key)| format!("(\"{kind}\", \"{key}\"),")).collect();
        assert_eq!(
            all,
            known,
            "a name, version, parameter or default has changed, and with it every address; if that is meant, put this into GOLDEN:\n{}",
            lines.join("\n")
        );
    }
}
