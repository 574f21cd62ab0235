//! A scene's warnings as the header `Render-Warnings`: a list of strings (RFC 9651). `POST /v1/scenes/validate` gives all of
//! them with line and column.

use strahl::scene::Problem;

/// Most warnings in the header.
const SHOWN: usize = 5;
/// Most characters of a warning.
const LONGEST: usize = 200;

/// The line, if there are any.
pub(crate) fn line(warnings: &[Problem]) -> Option<String> {
    let texts: Vec<String> = warnings.iter().take(SHOWN).map(text).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

/// A warning with its pointer, in characters that a header may have.
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
        let value = line(&[warning("say \"so\""), warning("twice\n")]).unwrap();
        assert_eq!(value, r#""/materials/gl?s: say \"so\"", "/materials/gl?s: twice?""#);
        assert!(line(&[]).is_none());
        assert_eq!(line(&vec![warning("again"); 9]).unwrap().matches("again").count(), SHOWN);
    }
}
