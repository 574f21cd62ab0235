//! The plot of the choices: how far a picture is off and how that is seen, against the time of a request. Dots have numbers, and
//! their names stand beside the plane, or below it where that is narrow.

use super::answer::{SEEN_UP_TO, duration};
use super::chips::{Chip, Chips};
use super::choices::{Choice, Choices};
use super::labels::{Area, width};
use super::plot::{ends, ticks};
use std::fmt::Write;

/// Size of letters.
const FONT: f64 = 13.0;
/// The bands from the top: lower and upper end in codes, share of the height, name and class.
const BANDS: [(f64, f64, f64, &str, &str); 4] = [
    (SEEN_UP_TO[2], 256.0, 0.29, "obvious", "off obvious"),
    (SEEN_UP_TO[1], SEEN_UP_TO[2], 0.22, "seen side by side", "off beside"),
    (SEEN_UP_TO[0], SEEN_UP_TO[1], 0.26, "seen only if pictures take turns", "off flicker"),
    (0.0, SEEN_UP_TO[0], 0.23, "invisible", "off unseen"),
];
/// What the name of a band takes at its top, and what dots need at either end.
const NAME: f64 = 16.0;
const REACH: f64 = 7.5;

/// Colors, in light and in dark.
pub const STYLE: &str = "\
.choices{font:13px system-ui,sans-serif;fill:#222}.choices .paper{fill:#fff}.choices .off{fill:#b3261e}.choices .off.obvious{opacity:.16}\
.choices .off.beside{opacity:.10}.choices .off.flicker{opacity:.05}.choices .off.unseen{fill:#1a7f37;opacity:.10}\
.choices .soft{fill:#666}.choices .tick{stroke:#ccc}.choices .lead{stroke:#888;fill:none}.choices .dot{fill:#0b62c4}\
.choices .shown{fill:#0b62c4;stroke:#fff;stroke-width:1.5}.choices .take{fill:#1a7f37;stroke:#fff;stroke-width:1.5}.choices .bold{font-weight:700}.choices .chip{fill:#fff;stroke:#888}.choices .chip.shown{fill:#0b62c4;stroke:none}.choices .chip.take{fill:#1a7f37;stroke:none}\
.choices .number{font-size:12px;font-weight:700}.choices .light{fill:#fff}\
@media(prefers-color-scheme:dark){.choices{fill:#ddd}.choices .paper{fill:#1b1d21}.choices .soft{fill:#aaa}.choices .tick{stroke:#3a3d44}\
.choices .off{fill:#ff8078}.choices .off.unseen{fill:#63d387}.choices .dot,.choices .shown{fill:#6db3ff}.choices .take{fill:#63d387}.choices .chip{fill:#1b1d21}.choices .chip.shown{fill:#6db3ff}.choices .chip.take{fill:#63d387}.choices .light{fill:#111}}";

/// Where the parts of a drawing are.
struct Frame {
    width: f64,
    height: f64,
    plane: Area,
    costs: [f64; 2],
    /// Names stand in as many columns, below the plane if there are two.
    columns: usize,
    rows: usize,
}

impl Frame {
    const EDGE: f64 = 6.0;
    /// The axis below the plane.
    const AXIS: f64 = 38.0;

    /// Of a width, for some dots.
    fn new(width: f64, dots: usize, costs: [f64; 2]) -> Self {
        let is_slim = width < 700.0;
        let columns = if is_slim { 2 } else { 1 };
        let (high, aside) = if is_slim { (186.0, 0.0) } else { (246.0, 230.0) };
        let plane =
            Area { left: Self::EDGE, top: Self::EDGE, right: width - Self::EDGE - aside, bottom: Self::EDGE + high };
        let rows = dots.div_ceil(columns);
        let below = if is_slim { 4.0 + Self::row(columns) * rows as f64 } else { 0.0 };
        Self { width, height: plane.bottom + Self::AXIS + below, plane, costs, columns, rows }
    }

    fn row(columns: usize) -> f64 {
        if columns == 2 { 18.0 } else { 23.0 }
    }

    fn x(&self, ms: f64) -> f64 {
        let part = (libm::log10(ms) - self.costs[0]) / (self.costs[1] - self.costs[0]);
        self.plane.left + (self.plane.right - self.plane.left) * part
    }

    /// Top and bottom of each band.
    fn bands(&self) -> [(f64, f64); 4] {
        let mut top = self.plane.top;
        BANDS.map(|(_, _, share, ..)| {
            let bottom = top + share * (self.plane.bottom - self.plane.top);
            let band = (top, bottom);
            top = bottom;
            band
        })
    }

    /// Below the name of its band.
    fn y(&self, codes: f64) -> f64 {
        let index = band(codes);
        let ((least, most, ..), (top, bottom)) = (BANDS[index], self.bands()[index]);
        let part = if least > 0.0 { libm::log(codes / least) / libm::log(most / least) } else { codes / most };
        let (top, bottom) = (top + NAME + REACH, bottom - REACH);
        bottom - (bottom - top) * part.clamp(0.0, 1.0)
    }

    /// Left end and base line of a name.
    fn name(&self, place: usize) -> (f64, f64) {
        let row = Self::row(self.columns);
        if self.columns == 1 {
            return (self.plane.right + 14.0, self.plane.top + 15.0 + row * place as f64);
        }
        let (column, down) = (place / self.rows, place % self.rows);
        let half = 0.5 * (self.width - 2.0 * Self::EDGE);
        (Self::EDGE + half * column as f64, self.plane.bottom + Self::AXIS + 13.0 + row * down as f64)
    }
}

/// The band that a difference lies in.
fn band(codes: f64) -> usize {
    BANDS.iter().position(|(least, ..)| codes > *least).unwrap_or(BANDS.len() - 1)
}

struct Dot<'a> {
    index: usize,
    choice: &'a Choice,
    ms: f64,
    at: (f64, f64),
    /// Whether it is the one to take, and whether its picture is shown.
    class: &'static str,
}

/// Draws the choices whose difference was measured, `width` across. None if there are none.
pub fn plot(choices: &Choices, width: f64) -> Option<String> {
    let known: Vec<(usize, &Choice, f64, f64)> = (choices.all.iter().enumerate())
        .filter_map(|(i, choice)| Some((i, choice, choice.request_ms.filter(|ms| *ms > 0.0)?, choice.codes()?)))
        .collect();
    if known.is_empty() {
        return None;
    }
    let frame = Frame::new(width, known.len(), ends(known.iter().map(|known| known.2), 0.12));
    let shown = choices.shown();
    let dots: Vec<Dot<'_>> = (known.iter())
        .map(|&(index, choice, ms, codes)| Dot {
            index,
            choice,
            ms,
            at: (frame.x(ms), frame.y(codes)),
            class: match index {
                _ if choices.recommended == Some(index) => " take",
                _ if shown.contains(&index) => " shown",
                _ => "",
            },
        })
        .collect();
    let (width, height) = (frame.width, frame.height);
    let mut svg = format!(
        "<svg class=\"choices\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"Difference against the time of a request\"><rect class=\"paper\" width=\"{width}\" height=\"{height}\"/>"
    );
    // Writing to a String cannot fail.
    let names = bands(&mut svg, &frame);
    axis(&mut svg, &frame);
    let mut chips = Chips::new(frame.plane, dots.iter().map(|dot| dot.at).collect(), names);
    // Those that the page speaks of get the nearest places.
    let mut order: Vec<&Dot<'_>> = dots.iter().collect();
    order.sort_by_key(|dot| dot.class.is_empty());
    let (mut lines, mut numbers) = (String::new(), String::new());
    for dot in order {
        if let Some(Chip { area, end: (x, y) }) = chips.place(dot.at, digits(dot.index)) {
            let _ = write!(lines, "<path class=\"lead\" d=\"M{:.1} {:.1}L{x:.1} {y:.1}\"/>", dot.at.0, dot.at.1);
            number(&mut numbers, dot, area);
        }
    }
    svg += &lines;
    for dot in &dots {
        let (radius, name) = (if dot.class.is_empty() { 4.0 } else { 5.5 }, &dot.choice.name);
        let codes = dot.choice.codes().unwrap_or_default();
        let _ = write!(
            svg,
            "<circle class=\"dot{}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\"><title>{name}: {}, {codes} codes off</title></circle>",
            dot.class,
            dot.at.0,
            dot.at.1,
            duration(dot.ms)
        );
    }
    svg += &numbers;
    for (place, dot) in dots.iter().enumerate() {
        name(&mut svg, &frame, place, dot);
    }
    Some(svg + "</svg>")
}

fn digits(index: usize) -> usize {
    if index < 9 { 1 } else { 2 }
}

/// Bands of what is seen, from the top; what their names take.
fn bands(svg: &mut String, frame: &Frame) -> Vec<Area> {
    let (left, right) = (frame.plane.left, frame.plane.right);
    let all = BANDS.iter().zip(frame.bands()).map(|((.., name, class), (top, bottom))| {
        let (wide, high) = (right - left, bottom - top);
        let _ = write!(
            svg,
            "<rect class=\"{class}\" x=\"{left}\" y=\"{top:.1}\" width=\"{wide:.1}\" height=\"{high:.1}\"/>"
        );
        let area = Area::of_text(right - width(name, FONT) - 4.0, top + FONT, name, FONT);
        let _ = write!(
            svg,
            "<text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\" textLength=\"{:.1}\" lengthAdjust=\"spacingAndGlyphs\">{name}</text>",
            area.left,
            top + FONT,
            width(name, FONT)
        );
        area
    });
    all.collect()
}

fn axis(svg: &mut String, frame: &Frame) {
    let plane = &frame.plane;
    for tick in ticks(frame.costs) {
        let (x, name) = (frame.x(tick), duration(tick));
        let half = 0.5 * width(&name, FONT);
        let middle = x.clamp(half + 4.0, frame.width - half - 4.0);
        let _ = write!(
            svg,
            "<path class=\"tick\" d=\"M{x:.1} {}V{:.1}\"/><text class=\"soft\" x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name}</text>",
            plane.top,
            plane.bottom + 4.0,
            plane.bottom + 17.0
        );
    }
    let _ = write!(
        svg,
        "<text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">time of a request, logarithmic \u{2192}</text>",
        0.5 * (plane.left + plane.right),
        plane.bottom + 33.0
    );
}

/// The number of a dot.
fn number(svg: &mut String, dot: &Dot<'_>, area: Area) {
    let light = if dot.class.is_empty() { "" } else { " light" };
    let _ = write!(
        svg,
        "<rect class=\"chip{}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"5\"/>\
         <text class=\"number{light}\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        dot.class,
        area.left,
        area.top,
        area.right - area.left,
        area.bottom - area.top,
        0.5 * (area.left + area.right),
        area.bottom - 3.6,
        dot.index + 1
    );
}

/// The number and the name of a dot.
fn name(svg: &mut String, frame: &Frame, place: usize, dot: &Dot<'_>) {
    let (x, y) = frame.name(place);
    let wide = 9.0 + 8.0 * digits(dot.index) as f64;
    number(svg, dot, Area { left: x, top: y - 11.5, right: x + wide, bottom: y + 3.5 });
    let (name, bold) = (&dot.choice.name, if dot.class.is_empty() { "" } else { " class=\"bold\"" });
    let _ = write!(
        svg,
        "<text{bold} x=\"{:.1}\" y=\"{y:.1}\" textLength=\"{:.1}\" lengthAdjust=\"spacingAndGlyphs\">{name}</text>",
        x + 30.0,
        width(name, FONT)
    );
    if frame.columns == 1 {
        let (right, time) = (frame.width - Frame::EDGE, duration(dot.ms));
        let _ = write!(svg, "<text class=\"soft\" x=\"{right:.1}\" y=\"{y:.1}\" text-anchor=\"end\">{time}</text>");
    }
}

#[cfg(test)]
mod tests {
    use super::super::answer::Seen;
    use super::super::choices::tests::choices;
    use super::*;

    /// Attributes of all elements of a class.
    fn numbers<const N: usize>(svg: &str, element: &str, names: [&str; N]) -> Vec<[f64; N]> {
        let number = |text: &str, name: &str| -> f64 {
            let after = text.split_once(&format!(" {name}=\"")).unwrap().1;
            after.split_once('"').unwrap().0.parse().unwrap()
        };
        svg.split(element).skip(1).map(|text| names.map(|name| number(text, name))).collect()
    }

    /// The plane's numbers as the browser draws them, without those of the list of names.
    fn chips(svg: &str, count: usize) -> Vec<Area> {
        let all = numbers(svg, "<rect class=\"chip", ["x", "y", "width", "height"]);
        let area = |[x, y, wide, high]: &[f64; 4]| Area {
            // Written with one decimal.
            left: x + 0.2,
            top: y + 0.2,
            right: x + wide - 0.2,
            bottom: y + high - 0.2,
        };
        all.iter().take(count).map(area).collect()
    }

    #[test]
    fn every_dot_has_a_number_that_covers_no_other_and_no_dot_covers_a_name() {
        let mut state = 7_u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1_u32 << 24)
        };
        for case in 0..300 {
            // Now spread, now all in one place, as on a scene without mirrors.
            let spread = [0.0, 0.01, 0.3, 3.0][case % 4];
            let all: Vec<(f64, f64)> = (0..10)
                .map(|_| {
                    (
                        14.0 * crate::math::pow(10.0, spread * random()),
                        (255.0 * crate::math::pow(random(), 6.0)).floor(),
                    )
                })
                .map(|(ms, codes)| if case % 8 < 4 { (ms, codes) } else { (ms, 0.0) })
                .collect();
            let choices = choices(&all);
            for width in [1240.0, 366.0] {
                let svg = plot(&choices, width).unwrap();
                let chips = chips(&svg, all.len());
                let [[height]] = numbers(&svg, "<rect class=\"paper\"", ["height"])[..] else { panic!("{svg}") };
                let dots = numbers(&svg, "<circle", ["cx", "cy"]);
                // A number in the plane and one in the list for each.
                assert_eq!(
                    (svg.matches("class=\"chip").count(), dots.len()),
                    (2 * all.len(), all.len()),
                    "case {case}"
                );
                for (i, chip) in chips.iter().enumerate() {
                    assert!(chip.left >= 0.0 && chip.right <= width && chip.top >= 0.0 && chip.bottom <= height);
                    assert!(chips[..i].iter().all(|other| !other.overlaps(chip)), "case {case}, {width}: {svg}");
                    assert!(!dots.iter().any(|&[x, y]| Area::around(x, y, 4.0).overlaps(chip)), "case {case}: {svg}");
                }
                let frame = Frame::new(width, all.len(), [0.0, 1.0]);
                let mut unused = String::new();
                for name in bands(&mut unused, &frame) {
                    assert!(!dots.iter().any(|&[x, y]| Area::around(x, y, 5.5).overlaps(&name)), "case {case}: {svg}");
                    assert!(!chips.iter().any(|chip| chip.overlaps(&name)), "case {case}: {svg}");
                }
            }
        }
    }

    #[test]
    fn names_stand_apart_from_each_other_and_inside() {
        for width in [1240.0, 366.0] {
            let frame = Frame::new(width, 11, [0.0, 1.0]);
            for place in 0..11 {
                let (x, y) = frame.name(place);
                let right = if frame.columns == 1 { width } else { x + 0.5 * width - 6.0 };
                assert!(
                    x + 30.0 + super::width("as the scene says", FONT) < right && y + 4.0 <= frame.height,
                    "{place}"
                );
            }
        }
    }

    #[test]
    fn there_are_two_times_on_the_axis_at_least_and_none_covers_another() {
        for (least, most) in [(2300.0, 4300.0), (46.0, 75.0), (50.0, 50.0), (0.4, 0.5), (59.0, 64e3), (190.0, 6e5)] {
            for width in [1240.0, 366.0] {
                let svg = plot(&choices(&[(least, 3.0), (most, 0.0)]), width).unwrap();
                let ticks = numbers(&svg, "<path class=\"tick\"", ["x"]);
                assert!(ticks.len() >= 2, "{least} to {most}: {svg}");
                let apart = ticks.windows(2).all(|pair| pair[1][0] - pair[0][0] > super::width("500 ms", FONT));
                assert!(apart, "{least} to {most} on {width}: {ticks:?}");
            }
        }
    }

    #[test]
    fn bands_are_those_of_the_answer() {
        let names = [Seen::Invisible, Seen::Flicker, Seen::SideBySide, Seen::Obvious];
        for (codes, seen) in [0.0, 1.0, 2.0, 10.0, 11.0, 30.0, 31.0, 255.0].iter().zip([0, 0, 1, 1, 2, 2, 3, 3]) {
            assert_eq!((Seen::of(*codes), band(*codes)), (names[seen], 3 - seen));
        }
    }

    #[test]
    fn without_differences_there_is_no_plot() {
        assert_eq!(plot(&choices(&[]), 366.0), None);
        let mut all = choices(&[(10.0, 1.0), (20.0, 0.0)]);
        all.all.iter_mut().for_each(|choice| choice.difference = None);
        assert_eq!(plot(&all, 366.0), None);
    }
}
