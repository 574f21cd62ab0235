//! A sequence and its scene as one text: a line of JSON, and the scene as it was sent. So a job has one file for both, by the
//! hash of both.

use strahl::sequence::Sequence;

/// The text of both.
pub(crate) fn join(sequence: &Sequence, scene: &[u8]) -> serde_json::Result<Vec<u8>> {
    let mut text = serde_json::to_vec(sequence)?;
    // Patches are as they were sent, and may have lines. Between the values of JSON all white space is alike.
    text.iter_mut().filter(|byte| **byte == b'\n').for_each(|byte| *byte = b' ');
    text.push(b'\n');
    text.extend_from_slice(scene);
    Ok(text)
}

/// The sequence, and the text of the scene; none if they are not there.
pub(crate) fn split(text: &[u8]) -> Option<(Sequence, &[u8])> {
    let end = text.iter().position(|byte| *byte == b'\n')?;
    Some((serde_json::from_slice(&text[..end]).ok()?, &text[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_come_back() {
        let sequence: Sequence = serde_json::from_str("{\"patches\": [{\n\"name\": \"a\\nb\"},\n{}]}").unwrap();
        for scene in [&b"{\n}\n"[..], b"", b"\x1f\x8b\n"] {
            let text = join(&sequence, scene).unwrap();
            let (again, rest) = split(&text).unwrap();
            assert_eq!((again.count(), rest), (2, scene));
            let patch: serde_json::Value = serde_json::from_slice(again.frame(0).patch()).unwrap();
            assert_eq!(patch, serde_json::json!({ "name": "a\nb" }));
        }
        assert!(split(b"{}").is_none() && split(b"\n{}").is_none());
    }
}
