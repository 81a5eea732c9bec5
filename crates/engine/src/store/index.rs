//! Index of an open store: which pack holds which record.

use super::address::Address;
use super::pack::Place;
use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

/// The packs, and the place of every record in them.
#[derive(Default)]
pub(super) struct Index {
    pub packs: Vec<PathBuf>,
    /// Address -> pack and place in it.
    pub places: HashMap<Address, (u32, Place)>,
    /// Records that several packs hold: the other packs and places.
    pub twins: HashMap<Address, Vec<(u32, Place)>>,
    /// Key of a cell's name -> addresses of its records.
    pub names: HashMap<u64, Vec<Address>>,
    /// Packs that this run has read from or written.
    pub used: BTreeSet<u32>,
}

impl Index {
    pub fn add(&mut self, path: PathBuf, places: Vec<Place>) -> u32 {
        let pack = self.packs.len() as u32;
        self.packs.push(path);
        for place in places {
            let known = self.names.entry(place.name).or_default();
            if !known.contains(&place.address) {
                known.push(place.address);
            }
            match self.places.entry(place.address) {
                Entry::Vacant(vacant) => {
                    vacant.insert((pack, place));
                }
                Entry::Occupied(_) => self.twins.entry(place.address).or_default().push((pack, place)),
            }
        }
        pack
    }

    pub fn drop_pack(&mut self, pack: u32) {
        self.places.retain(|_, (p, _)| *p != pack);
        self.twins.values_mut().for_each(|twins| twins.retain(|(p, _)| *p != pack));
        for (address, twins) in &mut self.twins {
            if !self.places.contains_key(address)
                && let Some(twin) = twins.pop()
            {
                self.places.insert(*address, twin);
            }
        }
        self.twins.retain(|_, twins| !twins.is_empty());
        let places = &self.places;
        self.names.values_mut().for_each(|addresses| addresses.retain(|a| places.contains_key(a)));
    }
}
