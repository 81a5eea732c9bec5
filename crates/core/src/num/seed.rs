//! Seeds from names.
//!
//! Random numbers depend on the names of a computation (experiment, sequence, tracker, run), never on time or
//! machine. [`seed`] turns the names into 64 bits; [`rng`] is the portable ChaCha8 stream of this seed.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// Seed of 64 bits from a base seed and names. The order of the names matters, as do the borders between
/// them.
pub fn seed(base: u64, names: &[&str]) -> u64 {
    let mut hash = Sha256::new();
    hash.update(base.to_le_bytes());
    for name in names {
        hash.update((name.len() as u64).to_le_bytes());
        hash.update(name.as_bytes());
    }
    let digest = hash.finalize();
    digest.iter().take(8).rev().fold(0, |bits, &byte| (bits << 8) | u64::from(byte))
}

/// Random stream of a seed.
pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Copy of a random stream or, with a seed, the stream of that seed.
pub fn fork(stream: &ChaCha8Rng, seed: Option<u64>) -> ChaCha8Rng {
    seed.map_or_else(|| stream.clone(), rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn names_are_not_confused() {
        assert_ne!(seed(1, &["ab", "c"]), seed(1, &["a", "bc"]));
        assert_ne!(seed(1, &["a"]), seed(2, &["a"]));
    }

    // python3: import hashlib,struct; h=hashlib.sha256(struct.pack('<Q',2016));
    // [h.update(struct.pack('<Q',len(n))+n.encode()) for n in ['Girl','ncc','0']];
    // int.from_bytes(h.digest()[:8],'little')
    #[test]
    fn agrees_with_hashlib() {
        assert_eq!(seed(2016, &["Girl", "ncc", "0"]), 6_242_846_036_857_900_464);
    }

    #[test]
    fn the_stream_is_frozen() {
        let mut r = rng(2016);
        assert_eq!([r.random::<u32>(), r.random()], [164_153_657, 2_204_812_722]);
    }
}
