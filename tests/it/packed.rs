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
    let (mut out, mut list, mut starts) = (Vec::<u8>::new(), Vec::<u8>::new(), Vec::new());
    for member in members {
        let mut crc = flate2::Crc::new();
        crc.update(&member.data);
        let packed = if member.deflated { deflate(&member.data) } else { member.data.clone() };
        let start = member.same_as.map_or(out.len(), |k| starts[k]);
        starts.push(start);
        let method = member.method.unwrap_or(if member.deflated { 8 } else { 0 });
        let size = member.size.unwrap_or(member.data.len() as u64);
        let wide = size >= u64::from(u32::MAX);
        let extra = if wide { [&[1_u8, 0, 8, 0][..], &size.to_le_bytes()].concat() } else { Vec::new() };
        let version = u16s(&[if wide { 45 } else { 20 }, member.flags, method, 0, 33]);
        let size = if wide { u32::MAX } else { size as u32 };
        let sizes = u32s(&[member.checksum.unwrap_or(crc.sum()), packed.len() as u32, size]);
        let shared = [version, sizes, u16s(&[member.name.len() as u16, extra.len() as u16])].concat();
        if member.same_as.is_none() {
            out.extend([&b"PK\x03\x04"[..], &shared, &member.name, &extra, &packed].concat());
        }
        let place = u32s(&[member.mode << 16, start as u32]);
        list.extend([&b"PK\x01\x02\x14\x03"[..], &shared, &[0; 6], &place, &member.name, &extra].concat());
    }
    let count = members.len() as u16;
    let end = [u16s(&[count, count]), u32s(&[list.len() as u32, out.len() as u32]), u16s(&[0])].concat();
    [&out[..], &list, b"PK\x05\x06\0\0\0\0", &end].concat()
}

fn u16s(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn u32s(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn deflate(data: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(data).expect("memory");
    encoder.finish().expect("memory")
}
