//! What a model's file calls its pictures. In the scene they are texts without a name, so problems with them would have places
//! that their author has never seen.

use crate::models::Picture;

/// Bytes at the end of a picture's text that tell it from others of the same length.
const END: usize = 96;

/// The pictures of models: length and end of the text of each, and its name.
#[derive(Debug, Clone, Default)]
pub(in crate::scene) struct PictureNames(Vec<(usize, String, String)>);

/// The length of a text, and its end.
fn mark(source: &str) -> (usize, &str) {
    (source.len(), source.get(source.len().saturating_sub(END)..).unwrap_or_default())
}

impl PictureNames {
    /// The names of pictures, by the texts that they are in the scene.
    pub(in crate::scene) fn of(pictures: &[Picture], sources: &[String]) -> Self {
        let one = |(picture, source): (&Picture, &String)| {
            let (length, end) = mark(source);
            (length, end.to_owned(), picture.pointer.clone())
        };
        Self(pictures.iter().zip(sources).filter(|(picture, _)| !picture.bytes.is_empty()).map(one).collect())
    }

    pub(in crate::scene) fn append(&mut self, mut other: Self) {
        self.0.append(&mut other.0);
    }

    /// Whether there are none.
    pub(in crate::scene) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The name of a picture: a JSON pointer into glTF, or the name of a file.
    pub(in crate::scene) fn get(&self, source: &str) -> Option<&str> {
        let (length, end) = mark(source);
        self.0.iter().find(|(l, e, _)| *l == length && e == end).map(|(.., name)| name.as_str())
    }
}
