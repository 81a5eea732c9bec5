//! Shards: parts of a run for several processes or machines.

/// One of several equal parts of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number of this shard, from 1.
    pub number: u32,
    /// Number of all shards.
    pub of: u32,
}

impl std::str::FromStr for Shard {
    type Err = String;

    /// Reads a shard like `2/5`.
    fn from_str(text: &str) -> Result<Self, String> {
        let shard = text
            .split_once('/')
            .and_then(|(n, of)| Some(Self { number: n.parse().ok()?, of: of.parse().ok()? }));
        let good = |s: &Self| (1..=s.of).contains(&s.number) && s.of <= 100_000;
        shard.filter(good).ok_or_else(|| format!("`{text}` is not a shard; write 1/4 to 4/4 for a quarter"))
    }
}

impl Shard {
    /// For each piece of work, true if it belongs to this shard, given the costs of all pieces. Neighboring
    /// pieces stay together; each piece belongs to exactly one shard.
    pub fn of(self, costs: &[u64]) -> Vec<bool> {
        let total: u64 = costs.iter().sum::<u64>().max(1);
        let mut before = 0;
        let mine = |cost: &u64| {
            let middle = before + cost / 2;
            before += cost;
            let share = u128::from(middle) * u128::from(self.of) / u128::from(total);
            share.min(u128::from(self.of) - 1) == u128::from(self.number) - 1
        };
        costs.iter().map(mine).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_read_and_refused() {
        assert_eq!("2/3".parse(), Ok(Shard { number: 2, of: 3 }));
        for bad in ["", "3", "0/3", "4/3", "1/0", "a/b", "-1/2", "1/2/3", "1/200000"] {
            assert!(bad.parse::<Shard>().unwrap_err().contains("is not a shard"), "{bad}");
        }
    }

    proptest::proptest! {
        #[test]
        fn every_piece_is_in_one_shard(costs in proptest::collection::vec(0_u64..1000, 0..60), of in 1_u32..9) {
            let shares: Vec<_> = (1..=of).map(|number| Shard { number, of }.of(&costs)).collect();
            for piece in 0..costs.len() {
                proptest::prop_assert_eq!(shares.iter().filter(|s| s[piece]).count(), 1);
            }
            let sum = |s: &Vec<bool>| costs.iter().zip(s).filter(|(_, m)| **m).map(|(c, _)| c).sum::<u64>();
            let largest = costs.iter().max().copied().unwrap_or(0);
            let fair = costs.iter().sum::<u64>() / u64::from(of);
            proptest::prop_assert!(shares.iter().all(|s| sum(s) <= fair + largest + 1));
        }
    }
}
