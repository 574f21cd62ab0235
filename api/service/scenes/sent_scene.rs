//! A scene as it was sent, and the key under which its built form is kept.

use crate::service::clock::milliseconds;
use crate::service::scheduler::pool::Workers;
use sha2::{Digest, Sha256};
use std::time::Instant;
use strahl::scene::{Format, Overrides};

/// A hash of a scene as it was sent, its format and settings.
pub(crate) type Key = [u8; 32];

/// What a text is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Form {
    /// A scene in a file format.
    Whole(Format),
    /// A merge patch on the scene of an id, which the tenant may read.
    Variation(String),
}

impl Form {
    /// Scene JSON.
    pub(crate) const JSON: Self = Self::Whole(Format::Json);
}

/// A scene as it was sent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SentScene<'a> {
    /// Its text.
    pub(crate) text: &'a [u8],
    /// What the text is.
    pub(crate) form: &'a Form,
    /// Settings that replace the scene's.
    pub(crate) overrides: Overrides,
    /// Hash of the text alone.
    pub(crate) digest: Key,
    /// Hash of all of this.
    pub(crate) key: Key,
    /// Milliseconds that hashing took.
    pub(crate) hash_ms: f64,
    /// Whether it is known by its id, so that whoever may name it may see what it names.
    pub(super) is_known: bool,
}

impl<'a> SentScene<'a> {
    /// Hashes the text, which takes a while if it is long.
    pub(crate) fn new(text: &'a [u8], form: &'a Form, overrides: &Overrides) -> Self {
        let start = Instant::now();
        let digest: Key = Sha256::digest(text).into();
        // The debug format of overrides cannot miss a field.
        let settings = format!("{form:?} {overrides:?}\n");
        let key = Sha256::new().chain_update(settings).chain_update(digest).finalize().into();
        Self { text, form, overrides: *overrides, digest, key, hash_ms: milliseconds(start), is_known: false }
    }

    /// The text of a scene that is known by its id.
    pub(crate) fn known(text: &'a [u8], form: &'a Form, overrides: &Overrides) -> Self {
        Self { is_known: true, ..Self::new(text, form, overrides) }
    }

    /// The same as whoever has sent it knows it, with its hash.
    pub(crate) fn hashed(
        text: &'a [u8],
        form: &'a Form,
        overrides: Overrides,
        (digest, key, hash_ms): (Key, Key, f64),
    ) -> Self {
        Self { text, form, overrides, digest, key, hash_ms, is_known: false }
    }

    /// The tenant whose assets it may name.
    pub(super) fn owner(&self, workers: &'a Workers) -> Option<&'a str> {
        (!self.is_known).then(|| workers.tenant())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::nff::NffOptions;

    #[test]
    fn everything_that_changes_a_scene_changes_its_key() {
        let plain = Overrides::default();
        let of =
            |bytes: &[u8], format, overrides: &Overrides| SentScene::new(bytes, &Form::Whole(format), overrides).key;
        let varied = |id: &str| SentScene::new(b"{}", &Form::Variation(id.into()), &plain).key;
        let first = of(b"{}", Format::Json, &plain);
        assert_eq!(first, of(b"{}", Format::Json, &plain));
        assert_ne!(first, of(b"{ }", Format::Json, &plain));
        assert_ne!(first, of(b"{}", Format::Nff, &plain));
        assert!(first != varied("s_a") && varied("s_a") != varied("s_b"));
        assert_ne!(first, of(b"{}", Format::Json, &Overrides { min_weight: Some(0.5), ..plain }));
        assert_ne!(
            first,
            of(b"{}", Format::Json, &Overrides { nff: NffOptions { two_sided: true, ..plain.nff }, ..plain })
        );
    }
}
