//! The content of MCAP chunks: decompressed and checked.

use std::borrow::Cow;
use std::io::Read as _;

use mcap::records::ChunkHeader;

/// Largest content of a chunk, bytes. Recorders write chunks of at most about 4 MB, or of one message.
const LARGEST_CHUNK: u64 = 1 << 26;
/// Checksum of chunks in MCAP: the CRC-32 of zip files.
const CRC: crc::Crc<u32, crc::Table<16>> =
    crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);

/// Content of a chunk with `header` and the bytes `data`: decompressed from lz4 or zstd, and checked.
///
/// # Errors
/// The defect of the chunk, in words.
pub fn unpacked<'a>(header: &ChunkHeader, data: Cow<'a, [u8]>) -> Result<Cow<'a, [u8]>, String> {
    let ChunkHeader { uncompressed_size: size, uncompressed_crc: expected, .. } = *header;
    if size > LARGEST_CHUNK {
        return Err(format!(
            "found a chunk of {size} bytes uncompressed, expected at most {LARGEST_CHUNK}"
        ));
    }
    let content = match header.compression.as_str() {
        "" => data,
        compression => {
            let damaged = || format!("found damage in a chunk compressed by {compression}");
            // Reading one byte more than stated detects a wrong size.
            let limit = size + 1;
            let mut content = Vec::new();
            let read = match compression {
                "lz4" => {
                    lz4_flex::frame::FrameDecoder::new(&*data).take(limit).read_to_end(&mut content)
                }
                "zstd" => ruzstd::decoding::StreamingDecoder::new(&*data)
                    .map_err(|_| damaged())?
                    .take(limit)
                    .read_to_end(&mut content),
                _ => {
                    return Err(format!(
                        "found a chunk compressed with {compression}, expected lz4 or zstd"
                    ));
                }
            };
            read.map_err(|_| damaged())?;
            Cow::Owned(content)
        }
    };
    let length = content.len() as u64;
    if length != size {
        return Err(format!("found {length} bytes in a chunk, expected {size}"));
    }
    // Zero: the writer computed no checksum.
    if expected != 0 && CRC.checksum(&content) != expected {
        return Err("found a chunk with a wrong checksum".into());
    }
    Ok(content)
}
