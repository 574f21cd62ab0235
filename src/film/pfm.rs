//! Portable float map (Debevec): a text header, then linear RGB as 32-bit floats, rows from the bottom up.
//!
//! The format knows no regions: a film of a region is a picture of the region's size.

use super::Film;

/// One number for each of some pixels, as grey (`Pf`).
pub fn encode_gray(width: u32, height: u32, values: &[f32]) -> Vec<u8> {
    let mut file = format!("Pf\n{width} {height}\n-1.0\n").into_bytes();
    file.reserve(values.len() * 4);
    for row in values.chunks_exact(width as usize).rev() {
        file.extend(row.iter().flat_map(|value| value.to_le_bytes()));
    }
    file
}

/// Little-endian, which the negative scale says.
pub(super) fn encode(film: &Film) -> Vec<u8> {
    let (width, height) = (film.region.width, film.region.height);
    let mut file = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    file.reserve(film.pixels.len() * 12);
    for row in film.pixels.chunks_exact(width as usize).rev() {
        file.extend(row.as_flattened().iter().flat_map(|channel| channel.to_le_bytes()));
    }
    file
}

#[cfg(test)]
mod tests {
    use super::super::{FileFormat, Region, encode, encode::test_film};
    use super::encode_gray;

    #[test]
    fn grey_rows_go_upwards() {
        let file = encode_gray(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let expected: Vec<u8> = [3.0_f32, 4.0, 1.0, 2.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        assert_eq!(file.strip_prefix(b"Pf\n2 2\n-1.0\n"), Some(&expected[..]));
    }

    #[test]
    fn rows_go_upwards() {
        let film = test_film(Region { x: 1, y: 2, width: 3, height: 2 }, 8, 8);
        let file = encode(&film, FileFormat::Pfm);
        let samples = file.strip_prefix(b"PF\n3 2\n-1.0\n").unwrap();
        let read: Vec<[f32; 3]> = samples
            .chunks_exact(12)
            .map(|p| [0, 4, 8].map(|i| f32::from_le_bytes([p[i], p[i + 1], p[i + 2], p[i + 3]])))
            .collect();
        assert_eq!(samples.len(), 6 * 12);
        assert_eq!(read[..3], film.pixels[3..]);
        assert_eq!(read[3..], film.pixels[..3]);
    }
}
