//! A picture's warnings as the header `Render-Warnings`: a list of strings (RFC 9651). `POST /v1/scenes/validate` gives all of
//! them with line and column.

use strahl::scene::Problem;

/// The header's name.
pub(crate) const NAME: &str = "render-warnings";
/// Most warnings in the header.
const SHOWN: usize = 12;
/// What stands after them if there are more.
const MORE: &str = "and more: see POST /v1/scenes/validate";
/// Most characters of a warning.
const LONGEST: usize = 200;
/// The end of one that had more.
const ELLIPSIS: &str = "...";

/// The line, if there are any.
pub(crate) fn line(warnings: &[Problem], shortfall: Option<&str>) -> Option<String> {
    let sentences = shortfall.map(str::to_owned).into_iter().chain(warnings.iter().map(sentence));
    let mut texts: Vec<String> = sentences.take(SHOWN + 1).map(quoted).collect();
    if texts.len() > SHOWN {
        texts[SHOWN] = quoted(MORE.to_owned());
    }
    (!texts.is_empty()).then(|| texts.join(", "))
}

/// The lines of several pictures as one, with each warning once.
pub(crate) fn together<'a>(lines: impl Iterator<Item = &'a str>) -> Option<String> {
    let (mut texts, mut has_more): (Vec<&str>, _) = (Vec::new(), false);
    for line in lines {
        // Quotes inside of a text have a backslash before them, so none begins after a blank.
        let inside = line.strip_prefix('"').and_then(|line| line.strip_suffix('"')).unwrap_or(line);
        for text in inside.split("\", \"") {
            if text == MORE || texts.len() == SHOWN && !texts.contains(&text) {
                has_more = true;
            } else if !texts.contains(&text) {
                texts.push(text);
            }
        }
    }
    texts.extend(has_more.then_some(MORE));
    (!texts.is_empty()).then(|| format!("\"{}\"", texts.join("\", \"")))
}

/// A warning with its pointer, if it has one.
fn sentence(warning: &Problem) -> String {
    // What models have approximated is in no place of the scene.
    if warning.pointer.is_empty() { warning.detail.clone() } else { format!("{}: {}", warning.pointer, warning.detail) }
}

/// A sentence in characters that a header may have.
fn quoted(sentence: String) -> String {
    let plain = |c: char| if (' '..='~').contains(&c) { c } else { '?' };
    let mut short: String = sentence.chars().take(LONGEST).map(plain).collect();
    if sentence.chars().nth(LONGEST).is_some() {
        short.replace_range(LONGEST - ELLIPSIS.len().., ELLIPSIS);
    }
    format!("\"{}\"", short.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::problem::Code;

    #[test]
    fn warnings_become_one_line_of_ascii() {
        let warning = |detail: &str| Problem::new("/materials/gl\u{e4}s", Code::OutOfRange, detail);
        let value = line(&[warning("say \"so\""), warning("twice\n")], None).unwrap();
        assert_eq!(value, r#""/materials/gl?s: say \"so\"", "/materials/gl?s: twice?""#);
        assert_eq!(line(&[], Some("cut off")).unwrap(), "\"cut off\"");
        assert!(line(&[], None).is_none());
        let cut = line(&[], Some(&"\u{e4}".repeat(LONGEST + 1))).unwrap();
        assert_eq!(cut, format!("\"{}...\"", "?".repeat(LONGEST - 3)));
        let more = line(&[warning("say \"so\""), warning("else")], None).unwrap();
        let all = together([value.as_str(), more.as_str()].into_iter()).unwrap();
        assert_eq!(all, format!("{value}, \"/materials/gl?s: else\""));
        assert!(together(std::iter::empty()).is_none());
        let long = line(&vec![warning("again"); 19], None).unwrap();
        assert_eq!(long.matches("again").count(), SHOWN);
        assert!(
            long.ends_with(&format!(", \"{MORE}\""))
                && !line(&vec![warning("again"); SHOWN], None).unwrap().contains(MORE)
        );
        let [odd, even] = [1, 2].map(|first| {
            let all: Vec<_> = (0..20).map(|i| warning(&(2 * i + first).to_string())).collect();
            line(&all, None).unwrap()
        });
        let both = together([odd.as_str(), even.as_str()].into_iter()).unwrap();
        assert_eq!((both.matches("gl?s").count(), both.matches(MORE).count()), (SHOWN, 1));
    }
}
