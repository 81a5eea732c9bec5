//! Archives byte by byte, also those that no library would write.

use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::Write;

/// A member of a zip file, and what its headers say.
#[derive(Clone, Default)]
pub struct Zipped {
    pub name: Vec<u8>,
    pub data: Vec<u8>,
    pub deflated: bool,
    /// Unix mode, its kind included.
    pub mode: u32,
    pub flags: u16,
    /// Compression method, where not the one used.
    pub method: Option<u16>,
    /// Unpacked size, where not the true one.
    pub size: Option<u64>,
    pub checksum: Option<u32>,
    /// Number of the member whose bytes this one shares.
    pub same_as: Option<usize>,
}

pub fn zipped(name: impl AsRef<[u8]>, data: &[u8]) -> Zipped {
    let (name, data) = (name.as_ref().to_vec(), data.to_vec());
    Zipped { name, data, mode: 0o100_644, ..Zipped::default() }
}

/// A zip file (PKWARE's APPNOTE 6.3, sections 4.3.7, 4.3.12, 4.3.16, 4.5.3).
pub fn zip(members: &[Zipped]) -> Vec<u8> {
    let (mut out, mut list, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    for member in members {
        let mut crc = flate2::Crc::new();
        crc.update(&member.data);
        let packed = if member.deflated { deflate(&member.data) } else { member.data.clone() };
        let start = member.same_as.map_or(out.len(), |k| starts[k]);
        starts.push(start);
        let method = member.method.unwrap_or(if member.deflated { 8 } else { 0 });
        let size = member.size.unwrap_or(member.data.len() as u64);
        let wide = size >= u64::from(u32::MAX);
        let mut extra = Vec::new();
        if wide {
            extra.extend([1, 0, 8, 0]);
            extra.extend(size.to_le_bytes());
        }
        let mut shared = Vec::new();
        shared.extend(if wide { 45_u16 } else { 20 }.to_le_bytes());
        [member.flags, method, 0, 33].iter().for_each(|v| shared.extend(v.to_le_bytes()));
        shared.extend(member.checksum.unwrap_or(crc.sum()).to_le_bytes());
        shared.extend((packed.len() as u32).to_le_bytes());
        shared.extend((if wide { u32::MAX } else { size as u32 }).to_le_bytes());
        shared.extend((member.name.len() as u16).to_le_bytes());
        shared.extend((extra.len() as u16).to_le_bytes());
        if member.same_as.is_none() {
            out.extend(b"PK\x03\x04");
            [&shared, &member.name, &extra, &packed].iter().for_each(|bytes| out.extend(bytes.iter()));
        }
        list.extend(b"PK\x01\x02\x14\x03");
        list.extend(&shared);
        list.extend([0; 6]);
        list.extend((member.mode << 16).to_le_bytes());
        list.extend((start as u32).to_le_bytes());
        list.extend(&member.name);
        list.extend(&extra);
    }
    let start = out.len() as u32;
    let count = (members.len() as u16).to_le_bytes();
    out.extend(&list);
    out.extend(b"PK\x05\x06\0\0\0\0");
    [count, count].iter().for_each(|c| out.extend(c));
    out.extend((list.len() as u32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0; 2]);
    out
}

fn deflate(data: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(data).expect("memory");
    encoder.finish().expect("memory")
}
