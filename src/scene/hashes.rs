//! Names of assets: `sha256:` and the 64 hexadecimal digits of the SHA-256 of their bytes.

/// What the name of an asset begins with.
pub const SCHEME: &str = "sha256:";
/// Hexadecimal digits of a SHA-256.
const DIGITS: usize = 64;

/// Whether a text is a SHA-256 in hexadecimal digits, small letters.
pub fn is_hash(text: &str) -> bool {
    text.len() == DIGITS && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// The hash in the name of an asset.
pub fn hash_of(name: &str) -> Option<&str> {
    name.strip_prefix(SCHEME).filter(|hash| is_hash(hash))
}

/// The hashes in a text that may name assets, each once.
pub fn named_in(text: &[u8]) -> Vec<String> {
    let mut named = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.windows(SCHEME.len()).position(|window| window == SCHEME.as_bytes()) {
        rest = &rest[at + SCHEME.len()..];
        if let Some(hash) =
            rest.get(..DIGITS).and_then(|hash| std::str::from_utf8(hash).ok()).filter(|hash| is_hash(hash))
            && !named.iter().any(|known| known == hash)
        {
            named.push(hash.to_owned());
        }
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assets_are_found_in_texts() {
        let [one, two] = ["a", "0"].map(|digit| digit.repeat(DIGITS));
        let text = format!(r#"{{"a": "sha256:{one}", "b": ["sha256:{two}", "sha256:{one}", "sha256:{}"]}}"#, &one[1..]);
        assert_eq!(named_in(text.as_bytes()), [one.clone(), two]);
        assert_eq!(hash_of(&format!("sha256:{one}")), Some(one.as_str()));
        assert!(hash_of(&one).is_none() && hash_of(&format!("sha256:{}", one.to_uppercase())).is_none());
    }
}
