//! Plots of error against cost: SVG with logarithmic axes. The same trade-off gives the same text.

use super::advice::figure;
use super::findings::{Cost, Front, Source};
use super::labels::{Area, Labels, width};
use super::sweep::{Point, Sweep};
use crate::scene::description::Precision;
use std::fmt::Write;

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 600.0;
const TOP: f64 = 52.0;
/// Lowest place of a positive error; the row of errors of 0 lies below.
const LOWEST: f64 = 322.0;
const ZERO: f64 = 342.0;
const BOTTOM: f64 = 354.0;
/// Size of letters.
const FONT: f64 = 11.0;

/// Colors, in light and in dark; for a page that holds plots, and inside of a plot that stands alone.
pub const STYLE: &str = "\
.plot{font:11px system-ui,sans-serif;fill:#222}.plot .paper{fill:#fff}.plot .frame,.plot .grid{fill:none;stroke:#999}\
.plot .grid{stroke:#e4e4e4}.plot .front{fill:none;stroke:#888;stroke-dasharray:5 3}.plot .reach{stroke:#888;opacity:.55}\
.plot .proved{fill:#7a3fb5;opacity:.25;stroke:#7a3fb5}.plot .knee{fill:none;stroke:#c00;stroke-width:1.5}\
.plot .depth{fill:#0b62c4;stroke:#0b62c4}.plot .weight{fill:#c05a00;stroke:#c05a00}.plot .samples{fill:#1a7f37;stroke:#1a7f37}.plot .certain{fill:#7a3fb5;stroke:#7a3fb5}\
.plot .asked{fill:#111;stroke:#111}.plot .double{fill-opacity:0;stroke-width:1.5}.plot .soft{fill:#666}\
@media(prefers-color-scheme:dark){.plot{fill:#ddd}.plot .paper{fill:#1b1d21}.plot .frame{stroke:#777}.plot .grid{stroke:#33363c}\
.plot .front,.plot .reach{stroke:#999}.plot .depth{fill:#6db3ff;stroke:#6db3ff}.plot .certain{fill:#c79bff;stroke:#c79bff}.plot .weight{fill:#ffab5e;stroke:#ffab5e}\
.plot .samples{fill:#63d387;stroke:#63d387}.plot .asked{fill:#fff;stroke:#fff}.plot .double{fill-opacity:0}.plot .soft{fill:#aaa}\
.plot .knee{stroke:#ff7070}.plot .proved{fill:#c79bff;stroke:#c79bff}}";

/// Draws one plane. Dots are root mean square errors as measured, lines above them reach to the largest error, open dots are
/// in double precision; bands are proved bounds of the largest error. Errors of 0 lie in a row of their own.
pub fn plot(points: &[Point], front: &Front, standalone: bool) -> String {
    let dots: Vec<Dot> = points.iter().enumerate().filter_map(|(i, point)| Dot::of(i, point, front)).collect();
    let scales = Scales::of(&dots);
    let mut svg = format!(
        "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
        title(front)
    );
    if standalone {
        let _ = write!(svg, "<style>{STYLE}</style>");
    }
    let _ = write!(svg, "<rect class=\"paper\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>");
    axes(&mut svg, front, &scales);
    staircase(&mut svg, &dots, front, &scales);
    for dot in &dots {
        dot.draw(&mut svg, &scales, front.knee == Some(dot.index));
    }
    labels(&mut svg, &dots, front, &scales);
    legend(&mut svg, dots.iter().any(|dot| dot.proved.is_some()));
    svg.push_str("</svg>");
    svg
}

/// What a plane shows.
pub fn title(front: &Front) -> &'static str {
    match (front.error, front.cost) {
        (Source::Truncation, Cost::Time) => "Error of recursion against time",
        (Source::Truncation, Cost::Rays) => "Error of recursion against rays",
        (Source::Total, Cost::Time) => "Error against time",
        (Source::Total, Cost::Rays) => "Error against rays",
    }
}

struct Dot<'a> {
    index: usize,
    point: &'a Point,
    cost: f64,
    rms: f64,
    largest: f64,
    proved: Option<f64>,
}

impl<'a> Dot<'a> {
    fn of(index: usize, point: &'a Point, front: &Front) -> Option<Self> {
        let error = point.error(front.error)?;
        let cost = point.cost(front.cost).filter(|cost| *cost > 0.0)?;
        // The proof is about truncation, not about too few samples.
        let proved = point.proved_codes.filter(|_| front.error == Source::Truncation).map(f64::from);
        Some(Self { index, point, cost, rms: error.rms_codes, largest: error.codes.error.max, proved })
    }

    fn draw(&self, svg: &mut String, scales: &Scales, knee: bool) {
        let (x, y, top) = (scales.x(self.cost), scales.y(self.rms), scales.y(self.largest));
        if let Some(proved) = self.proved {
            let (up, height) = (scales.y(proved), BOTTOM - scales.y(proved));
            let _ = write!(
                svg,
                "<rect class=\"proved\" x=\"{:.1}\" y=\"{up:.1}\" width=\"6\" height=\"{height:.1}\"/>",
                x - 3.0
            );
        }
        let _ = write!(svg, "<path class=\"reach\" d=\"M{x:.1} {y:.1}V{top:.1}m-3 0h6\"/>");
        let double = if self.point.settings.precision == Precision::Double { " double" } else { "" };
        let _ = write!(
            svg,
            "<circle class=\"{}{double}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"><title>{}: {} codes root mean square, at most {}</title></circle>",
            series(self.point),
            self.point.settings,
            figure(self.rms),
            self.largest
        );
        if knee {
            let _ = write!(svg, "<circle class=\"knee\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"8\"/>");
        }
    }
}

fn series(point: &Point) -> &'static str {
    match point.sweeps.first() {
        Some(Sweep::Depth) => "depth",
        Some(Sweep::Weight) => "weight",
        Some(Sweep::Proved) => "certain",
        Some(Sweep::Samples | Sweep::Antialias) => "samples",
        Some(Sweep::AsAsked) | None => "asked",
    }
}

/// Logarithmic axes that hold all dots.
struct Scales {
    /// Logarithms to base 10 of the ends.
    cost: [f64; 2],
    error: [f64; 2],
}

impl Scales {
    fn of(dots: &[Dot<'_>]) -> Self {
        let costs = dots.iter().map(|dot| dot.cost);
        let errors = dots.iter().flat_map(|dot| [dot.rms, dot.largest, dot.proved.unwrap_or(0.0)]).filter(|e| *e > 0.0);
        Self { cost: ends(costs, 0.06), error: ends(errors, 0.04) }
    }

    fn x(&self, cost: f64) -> f64 {
        LEFT + (RIGHT - LEFT) * (libm::log10(cost) - self.cost[0]) / (self.cost[1] - self.cost[0])
    }

    fn y(&self, error: f64) -> f64 {
        if error <= 0.0 {
            return ZERO;
        }
        TOP + (LOWEST - TOP) * (self.error[1] - libm::log10(error)) / (self.error[1] - self.error[0])
    }
}

/// Ends of an axis with a margin; at least a factor of 2 apart.
pub(super) fn ends(values: impl Iterator<Item = f64>, margin: f64) -> [f64; 2] {
    let (low, high) =
        values.map(libm::log10).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    if low > high {
        return [0.0, 1.0];
    }
    let more = margin * (high - low) + (0.15 - 0.5 * (high - low)).max(0.0);
    [low - more, high + more]
}

/// Steps of each decade, few first.
const STEPS: [&[f64]; 4] = [
    &[1.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
    &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
];

/// Round numbers between two ends: decades, and as few between as make three.
pub(super) fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let of = |steps: &[f64]| -> Vec<f64> {
        let decades = libm::floor(low) as i32..=libm::floor(high) as i32;
        let all =
            decades.flat_map(|decade| steps.iter().map(move |step| step * crate::math::pow(10.0, f64::from(decade))));
        all.filter(|x| (low..=high).contains(&libm::log10(*x))).collect()
    };
    STEPS.iter().map(|steps| of(steps)).find(|ticks| ticks.len() > 2).unwrap_or_else(|| of(STEPS[3]))
}

fn axes(svg: &mut String, front: &Front, scales: &Scales) {
    for tick in ticks(scales.cost) {
        let x = scales.x(tick);
        let _ = write!(svg, "<path class=\"grid\" d=\"M{x:.1} {TOP}V{BOTTOM}\"/>");
        let _ = write!(svg, "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>", BOTTOM + 15.0, round(tick));
    }
    let zero = (ZERO, "0".to_owned());
    for (y, name) in ticks(scales.error).into_iter().map(|tick| (scales.y(tick), round(tick))).chain([zero]) {
        let _ = write!(svg, "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{RIGHT}\"/>");
        let _ = write!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>", LEFT - 6.0, y + 4.0);
    }
    let _ = write!(
        svg,
        "<rect class=\"frame\" x=\"{LEFT}\" y=\"{TOP}\" width=\"{}\" height=\"{}\"/>",
        RIGHT - LEFT,
        BOTTOM - TOP
    );
    let across = match front.cost {
        Cost::Time => "milliseconds, logarithmic",
        Cost::Rays => "rays, logarithmic",
    };
    let middle = 0.5 * (TOP + BOTTOM);
    let _ = write!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{across}</text>",
        0.5 * (LEFT + RIGHT),
        BOTTOM + 34.0
    );
    let _ = write!(
        svg,
        "<text transform=\"translate(14 {middle})rotate(-90)\" text-anchor=\"middle\">error in 8-bit codes</text>"
    );
}

/// A power of ten times a few round numbers.
fn round(tick: f64) -> String {
    let decade = libm::floor(libm::log10(tick) + 1e-9);
    if (-3.0..4.0).contains(&decade) { figure(tick) } else { format!("{tick:e}") }
}

/// The front: of all settings that cost no more, the least error.
fn staircase(svg: &mut String, dots: &[Dot<'_>], front: &Front, scales: &Scales) {
    let mut path = String::new();
    for dot in on_front(dots, front) {
        let (x, y) = (scales.x(dot.cost), scales.y(dot.rms));
        let _ = if path.is_empty() { write!(path, "M{x:.1} {y:.1}") } else { write!(path, "H{x:.1}V{y:.1}") };
    }
    if !path.is_empty() {
        let _ = write!(svg, "<path class=\"front\" d=\"{path}H{RIGHT}\"/>");
    }
}

fn on_front<'a>(dots: &'a [Dot<'a>], front: &Front) -> impl Iterator<Item = &'a Dot<'a>> {
    front.points.iter().filter_map(|index| dots.iter().find(|dot| dot.index == *index))
}

/// Names of the points on the front and of the scene's own settings, where there is room beside them.
fn labels(svg: &mut String, dots: &[Dot<'_>], front: &Front, scales: &Scales) {
    let taken = dots.iter().map(|dot| Area::around(scales.x(dot.cost), scales.y(dot.rms), 5.0)).collect();
    let inside = Area { left: LEFT, top: TOP, right: RIGHT, bottom: BOTTOM };
    let mut labels = Labels::new(inside, taken, FONT);
    let asked =
        dots.iter().filter(|dot| dot.point.sweeps.contains(&Sweep::AsAsked) && !front.points.contains(&dot.index));
    for dot in asked.chain(on_front(dots, front)) {
        let label = dot.point.label();
        if let Some(area) = labels.place((scales.x(dot.cost), scales.y(dot.rms)), &label, 20.0) {
            let _ = write!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" textLength=\"{:.1}\" lengthAdjust=\"spacingAndGlyphs\">{label}</text>",
                area.left,
                area.bottom - 0.25 * FONT,
                area.right - area.left
            );
        }
    }
}

/// What the marks mean, in as many rows as it takes.
fn legend(svg: &mut String, proved: bool) {
    let dot = |class| format!("<circle class=\"{class}\" cx=\"5\" cy=\"-4\" r=\"4\"/>");
    let marks = [
        (dot("depth"), "depth"),
        (dot("weight"), "smallest weight"),
        (dot("certain"), "proved"),
        (dot("samples"), "samples"),
        (dot("asked"), "as the scene says"),
        (dot("depth double"), "double"),
        ("<path class=\"reach\" d=\"M5 2V-10m-3 0h6\"/>".to_owned(), "largest difference"),
        ("<circle class=\"knee\" cx=\"5\" cy=\"-4\" r=\"6\"/>".to_owned(), "after it time gains less"),
        ("<rect class=\"proved\" x=\"2\" y=\"-11\" width=\"6\" height=\"14\"/>".to_owned(), "proved bound"),
    ];
    let (mut x, mut y) = (LEFT, 18.0);
    for (mark, name) in marks.iter().take(if proved { marks.len() } else { marks.len() - 1 }) {
        let wide = 16.0 + width(name, FONT);
        if x + wide > RIGHT {
            (x, y) = (LEFT, y + 18.0);
        }
        let _ = write!(
            svg,
            "<g transform=\"translate({x:.1} {y})\">{mark}<text class=\"soft\" x=\"14\" textLength=\"{:.1}\" \
             lengthAdjust=\"spacingAndGlyphs\">{name}</text></g>",
            width(name, FONT)
        );
        x += wide + 8.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let near = |found: Vec<f64>, wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            assert!(found.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?}");
        };
        near(ticks([0.0, 1.0]), &[1.0, 2.0, 5.0, 10.0]);
        near(ticks([3.36, 3.64]), &[2500.0, 3000.0, 3500.0, 4000.0]);
        near(ticks([-1.2, 3.1]), &[0.1, 1.0, 10.0, 100.0, 1000.0]);
        assert_eq!([round(0.1), round(50.0), round(1e6)], ["0.1", "50", "1e6"]);
    }

    #[test]
    fn axes_hold_what_they_are_for() {
        let [low, high] = ends([2.0, 30.0].into_iter(), 0.05);
        assert!(low < libm::log10(2.0) && libm::log10(30.0) < high);
        let [low, high] = ends([5.0].into_iter(), 0.05);
        assert!(high - low > 0.2);
        assert!(ends(std::iter::empty(), 0.05).iter().all(|end| end.is_finite()));
    }

    #[test]
    fn the_legend_stays_above_the_plane_and_inside_the_drawing() {
        let mut svg = String::new();
        legend(&mut svg, true);
        let entries: Vec<&str> = svg.split("translate(").skip(1).collect();
        assert_eq!(entries.len(), 9);
        for entry in entries {
            let (x, rest) = entry.split_once(' ').unwrap();
            let y: f64 = rest.split_once(')').unwrap().0.parse().unwrap();
            let wide: f64 = rest.split_once("textLength=\"").unwrap().1.split_once('"').unwrap().0.parse().unwrap();
            assert!(x.parse::<f64>().unwrap() + 14.0 + wide <= WIDTH && y + 4.0 <= TOP, "{entry}");
        }
    }

    #[test]
    fn a_plane_without_points_is_still_a_drawing() {
        let front = Front { error: Source::Total, cost: Cost::Time, points: Vec::new(), knee: None };
        let svg = plot(&[], &front, true);
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>") && !svg.contains("NaN"), "{svg}");
    }
}
