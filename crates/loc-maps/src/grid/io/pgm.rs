//! PGM, the plain grey image: a header of four words, then the pixels (netpbm's definition).

use super::raster::{Raster, Samples, check_size, too_short};
use super::wrong;
use crate::Result;
use std::path::Path;

struct Header {
    binary: bool,
    width: u64,
    height: u64,
    white: u16,
    /// Where the pixels begin.
    length: usize,
}

/// Decodes a P2 (text) or P5 (binary) file with 8 or 16 bits a pixel.
pub(super) fn decode(file: &Path, mut bytes: Vec<u8>) -> Result<Raster> {
    let header = header(file, &bytes)?;
    let (width, height) = (header.width, header.height);
    check_size(file, width, height, bytes.len())?;
    let pixels = (width * height) as usize;
    let expected = format!("{width} x {height} values of 0 to {}", header.white);
    let found = bytes.len();
    let samples = if header.binary {
        let bytes_each = if header.white > 255 { 2 } else { 1 };
        bytes.drain(..header.length.min(found));
        if bytes.len() < pixels * bytes_each {
            return Err(too_short(file, &expected, found));
        }
        bytes.truncate(pixels * bytes_each);
        binary(bytes, bytes_each)
    } else {
        let text = bytes.get(header.length..).unwrap_or_default();
        Samples::Words(text_samples(text, pixels).ok_or_else(|| too_short(file, &expected, found))?)
    };
    if brightest(&samples) > header.white {
        return Err(wrong(file, "pixels", &expected, &brightest(&samples)));
    }
    let (width, height) = (width as usize, height as usize);
    Ok(Raster { width, height, samples, white: header.white, opaque: None })
}

/// The bytes of a P5 file, from grey values with the top row first.
pub(super) fn encode(width: usize, height: usize, grey: &[u8]) -> Vec<u8> {
    let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
    bytes.extend_from_slice(grey);
    bytes
}

fn header(file: &Path, bytes: &[u8]) -> Result<Header> {
    let mut at = 2;
    let mut number = |field: &'static str| {
        let word = next_word(bytes, &mut at);
        let text = String::from_utf8_lossy(word.get(..word.len().min(20)).unwrap_or_default());
        text.parse::<u64>().map_err(|_| wrong(file, field, "a whole number", &format!("`{text}`")))
    };
    let (width, height, white) = (number("width")?, number("height")?, number("maxval")?);
    let white = u16::try_from(white).ok().filter(|&white| white > 0);
    let white = white.ok_or_else(|| {
        let mut at = 2;
        let words = [(); 3].map(|()| next_word(bytes, &mut at));
        let found = String::from_utf8_lossy(words[2]).into_owned();
        wrong(file, "maxval", "1 to 65535", &found)
    })?;
    // One white space ends the header; what follows are pixels, whatever they look like.
    Ok(Header { binary: bytes.get(1) == Some(&b'5'), width, height, white, length: at + 1 })
}

/// The next word after white space and comments, which run from `#` to the end of the line.
fn next_word<'a>(bytes: &'a [u8], at: &mut usize) -> &'a [u8] {
    let mut comment = false;
    while let Some(&byte) = bytes.get(*at) {
        comment = (comment && byte != b'\n') || byte == b'#';
        if !comment && !byte.is_ascii_whitespace() {
            break;
        }
        *at += 1;
    }
    let start = *at;
    while bytes.get(*at).is_some_and(|byte| !byte.is_ascii_whitespace() && *byte != b'#') {
        *at += 1;
    }
    bytes.get(start..*at).unwrap_or_default()
}

fn binary(bytes: Vec<u8>, bytes_each: usize) -> Samples {
    if bytes_each == 1 {
        return Samples::Bytes(bytes);
    }
    let words = bytes.as_chunks::<2>().0.iter();
    Samples::Words(words.map(|&pair| u16::from_be_bytes(pair)).collect())
}

fn text_samples(text: &[u8], pixels: usize) -> Option<Vec<u16>> {
    // A number and its separator take two bytes at least.
    if text.len() / 2 + 1 < pixels {
        return None;
    }
    let mut at = 0;
    let mut word = || std::str::from_utf8(next_word(text, &mut at)).ok()?.parse().ok();
    (0..pixels).map(|_| word()).collect()
}

fn brightest(samples: &Samples) -> u16 {
    match samples {
        Samples::Bytes(bytes) => bytes.iter().copied().max().map_or(0, u16::from),
        Samples::Words(words) => words.iter().copied().max().unwrap_or(0),
    }
}
