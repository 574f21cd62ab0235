//! A scene's warnings beside its picture, as the header `Render-Warnings`: a list of texts (RFC 9651). All of them, with
//! line and column, are what `POST /v1/scenes/validate` answers.

use axum::http::{HeaderName, HeaderValue};
use strahl::scene::Problem;

/// How many are written out.
const SHOWN: usize = 5;
/// Characters of each.
const LONGEST: usize = 200;

/// The header, if there are any.
pub(super) fn header(warnings: &[Problem]) -> Option<(HeaderName, HeaderValue)> {
    let texts: Vec<String> = warnings.iter().take(SHOWN).map(text).collect();
    let value = HeaderValue::from_str(&texts.join(", ")).ok().filter(|value| !value.is_empty())?;
    Some((HeaderName::from_static("render-warnings"), value))
}

/// A warning with its place, in the characters that such texts may have.
fn text(warning: &Problem) -> String {
    let sentence = format!("{}: {}", warning.pointer, warning.detail);
    let plain = |c: char| if (' '..='~').contains(&c) { c } else { '?' };
    let sentence: String = sentence.chars().take(LONGEST).map(plain).collect();
    format!("\"{}\"", sentence.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::problem::Code;

    #[test]
    fn warnings_become_one_line_of_ascii() {
        let warning = |detail: &str| Problem::new("/materials/gl\u{e4}s", Code::OutOfRange, detail);
        let (_, value) = header(&[warning("say \"so\""), warning("twice\n")]).unwrap();
        assert_eq!(value, r#""/materials/gl?s: say \"so\"", "/materials/gl?s: twice?""#);
        assert!(header(&[]).is_none());
        assert_eq!(header(&vec![warning("again"); 9]).unwrap().1.to_str().unwrap().matches("again").count(), SHOWN);
    }
}
