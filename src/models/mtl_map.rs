//! Statements of MTL that name a picture: options, then a name that may have spaces.
//! (Alias|Wavefront, Object Files, version 4.2, appendix B1, "Options for texture map statements".)

use super::material::{UvTransform, Wrap};

/// What such a statement says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Map<'a> {
    /// The name of the picture.
    pub(super) name: &'a str,
    /// Texture coordinates are multiplied by it: the picture is there so many times.
    scale: [f64; 2],
    /// Then they are moved by it.
    offset: [f64; 2],
    /// Beyond the edges.
    pub(super) wrap: Wrap,
    /// Whether options change the values of the picture, or name one of its channels.
    pub(super) is_changed: bool,
}

impl<'a> Map<'a> {
    /// Reads what stands behind the key.
    pub(super) fn of(line: &'a str) -> Self {
        let mut map =
            Self { name: line.trim(), scale: [1.0; 2], offset: [0.0; 2], wrap: Wrap::Repeat, is_changed: false };
        while map.name.starts_with('-') {
            let (option, rest) = word(map.name);
            let rest = match option.to_ascii_lowercase().as_str() {
                "-s" => pair(rest, &mut map.scale),
                "-o" => pair(rest, &mut map.offset),
                // Turbulence is left out.
                "-t" => pair(rest, &mut [0.0; 2]),
                "-clamp" => {
                    let (is_on, rest) = word(rest);
                    map.wrap = if is_on.eq_ignore_ascii_case("on") { Wrap::Clamp } else { Wrap::Repeat };
                    rest
                }
                "-mm" => {
                    map.is_changed = true;
                    word(word(rest).1).1
                }
                "-imfchan" => {
                    map.is_changed = true;
                    word(rest).1
                }
                "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-colorspace" | "-texres" | "-type" => word(rest).1,
                // How many words an unknown option has is unknown.
                _ => rest.rsplit(char::is_whitespace).next().unwrap_or_default(),
            };
            // Without a name behind it, it is the name.
            if rest.is_empty() {
                break;
            }
            map.name = rest;
        }
        map
    }

    /// What is done to texture coordinates first. In MTL v is 0 at the bottom of the picture, in models at its top.
    pub(super) fn transform(&self) -> Option<UvTransform> {
        let ([x, y], [scale_x, scale_y]) = (self.offset, self.scale);
        let is_plain = self.offset == [0.0; 2] && self.scale == [1.0; 2];
        (!is_plain).then_some(UvTransform { offset: [x, 1.0 - scale_y - y], rotation: 0.0, scale: [scale_x, scale_y] })
    }
}

/// The first word, and what is behind it.
fn word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// Takes one to three numbers: across, up, and into the depth, which pictures do not have.
fn pair<'a>(mut text: &'a str, into: &mut [f64; 2]) -> &'a str {
    for i in 0..3 {
        let (first, rest) = word(text);
        let Some(number) = fast_float2::parse(first).ok().filter(|number: &f64| number.is_finite()) else { break };
        if let Some(place) = into.get_mut(i) {
            *place = number;
        }
        text = rest;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_go_before_a_name_with_spaces() {
        for (line, name) in [
            ("wood.png", "wood.png"),
            ("my wood.png", "my wood.png"),
            ("-s 2 2 2 -o 0 0 0 file name with spaces.png", "file name with spaces.png"),
            ("-BM 0.5 my bump.png", "my bump.png"),
            ("-bm 0.5\tbump.png", "bump.png"),
            ("-s 2 wood.png", "wood.png"),
            ("-s 2 2 2 2.png", "2.png"),
            (
                "-blendu on -blendv off -mm 0 1 -texres 512 -imfchan l -type sphere -cc on -t 1 1 1 -boost 2 a b.png",
                "a b.png",
            ),
            ("-new 1 2 wood.png", "wood.png"),
            ("-wood.png", "-wood.png"),
            ("-s 1 1 1", "-s 1 1 1"),
            ("", ""),
        ] {
            assert_eq!(Map::of(line).name, name, "{line}");
        }
    }

    #[test]
    fn scale_and_offset_are_from_the_bottom_of_the_picture() {
        assert_eq!(Map::of("-s 1 1 1 -o 0 0 0 a.png").transform(), None);
        let map = Map::of("-o 0.25 0.5 -s 2 4 1 -clamp on a.png");
        let UvTransform { offset, scale, .. } = map.transform().unwrap();
        assert_eq!((scale, map.wrap), ([2.0, 4.0], Wrap::Clamp));
        // (u, v) with v up becomes (2 u + 0.25, 4 v + 0.5); with v down that is 1 less of both.
        let (u, v) = (0.5, 0.125);
        let moved = [scale[0] * u + offset[0], scale[1] * (1.0 - v) + offset[1]];
        assert_eq!(moved, [1.25, 1.0 - (4.0 * v + 0.5)]);
    }
}
